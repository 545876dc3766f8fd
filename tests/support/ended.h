// SPDX-License-Identifier: Apache-2.0
// Ends long computations by an exception from their progress function.
#pragma once
#include <gtest/gtest.h>

#include <atomic>
#include <functional>

#include "core/comm/advance.h"

namespace gxy::test {

/// Runs `work` repeatedly until it completes. Its Advance throws at the first call in the first run, at the
/// second call in the next run, then at the fourth, the eighth, and so on; `work` must pass that exception
/// on. Returns the number of runs that were ended in this way.
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
