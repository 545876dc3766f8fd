// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/rays/iso_mask.h"

namespace gxy::test {

/// The isoMask of a walk that looks into every cell.
inline std::vector<int32_t> everyCell(size_t macrocells) {
  const size_t first = std::max(macrocells, kIsoWords);  // small numbers mean other things
  std::vector<int32_t> plan(first + kIsoWords, int32_t(first));
  std::fill(plan.end() - kIsoWords, plan.end(), -1);
  return plan;
}

}  // namespace gxy::test
