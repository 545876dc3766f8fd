// SPDX-License-Identifier: Apache-2.0
// How long a thread that polls may sleep.
#pragma once
#include <algorithm>
#include <chrono>

namespace gxy {

/// Zero for a while after activity, then growing.
class Backoff {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::microseconds hot{80}, firstSleep{20}, maxSleep{2000};

  /// Without `spins` it sleeps from the start: the core is needed by others.
  explicit Backoff(bool spins) : spins_(spins) {}

  void active() {
    sleep_ = firstSleep;
    if (spins_) hotUntil_ = Clock::now() + hot;
  }

  /// The sleep due now; each call in a row returns a longer one, up to maxSleep.
  std::chrono::microseconds next() {
    if (spins_ && Clock::now() < hotUntil_) return {};
    const auto sleep = sleep_;
    sleep_ = std::min<std::chrono::microseconds>(sleep * 5 / 4, maxSleep);
    return sleep;
  }

 private:
  const bool spins_;
  std::chrono::microseconds sleep_ = firstSleep;
  Clock::time_point hotUntil_{};
};

}  // namespace gxy
