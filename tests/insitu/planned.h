// SPDX-License-Identifier: Apache-2.0
// A Conductor that has a plan.
#pragma once
#include <set>
#include <utility>

#include "insitu/plan/conductor.h"

namespace gxy::test {

/// All ranks have said what they have from the first publish on. `owners`: the ranks of Galaxy that get samples.
inline insitu::Conductor planned(int ranks, std::set<int> owners) {
  insitu::Conductor conductor(ranks);
  for (int r = 0; r < ranks; r++) conductor.describe(r, 1);
  conductor.plan(conductor.described(), std::move(owners));
  return conductor;
}

}  // namespace gxy::test
