// SPDX-License-Identifier: Apache-2.0
// line_probe.h in C++, and the comparison of its results with those of another language.
#pragma once
#include <vector>

namespace gxy::test {

/// lineProbe(f, i) at f * kLineInputs + i.
inline constexpr int kLineInputs = 5'000;
std::vector<float> lineProbesInCpp();

/// Expects that every probe has the same bits in both.
void expectSameLineProbes(const std::vector<float>& a, const std::vector<float>& b);

}  // namespace gxy::test
