// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/rays/iso_mask.h"

namespace gxy::test {

/// Returns an isoMask that skips no cell.
inline std::vector<int32_t> everyCell(size_t macrocells) {
  const size_t first = std::max(macrocells, kIsoWords);  // Smaller numbers have special meanings.
  std::vector<int32_t> plan(first + kIsoWords, int32_t(first));
  std::fill(plan.end() - kIsoWords, plan.end(), -1);
  return plan;
}

}  // namespace gxy::test
