// SPDX-License-Identifier: Apache-2.0
// Long computations whose progress ends them.
#pragma once
#include <gtest/gtest.h>

#include <atomic>
#include <functional>

#include "core/comm/advance.h"

namespace gxy::test {

/// Runs `work` again and again, ended at the first, second, fourth, eighth... call of its Advance, until it comes to its end.
/// What it throws then must be what the call threw. Returns how often it was ended.
inline int timesEnded(const std::function<void(const Advance&)>& work) {
  struct Ended {};
  for (int times = 0;; times++) {
    std::atomic<int> calls = 0;
    try {
      work([&](double share) {
        EXPECT_GE(share, 0);
        EXPECT_LE(share, 1);
        if (++calls >= 1 << times) throw Ended();
      });
      return times;
    } catch (const Ended&) {
    }
  }
}

}  // namespace gxy::test
