// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/rays/iso_mask.h"

namespace gxy::test {

<<<<<<< HEAD
/// The isoMask of a walk that looks into every cell.
=======
/// Returns an isoPlan that skips no cell.
>>>>>>> 8941ed3 (Comments of test support and cmake in whole sentences)
inline std::vector<int32_t> everyCell(size_t macrocells) {
  const size_t first = std::max(macrocells, kIsoWords);  // Smaller numbers have special meanings.
  std::vector<int32_t> plan(first + kIsoWords, int32_t(first));
  std::fill(plan.end() - kIsoWords, plan.end(), -1);
  return plan;
}

}  // namespace gxy::test
