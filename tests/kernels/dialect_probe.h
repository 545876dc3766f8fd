// SPDX-License-Identifier: Apache-2.0
// probe.h in C++, and the comparison of its results with those of another language.
#pragma once
#include <vector>

namespace gxy {

/// probe(f, i) at f * kProbeInputs + i.
inline constexpr int kProbeInputs = 50'000;
std::vector<float> probesInCpp();

/// Expects that every probe has the same bits in both; NaN of any bits are the same.
void expectSameProbes(const std::vector<float>& a, const std::vector<float>& b);

}  // namespace gxy
