// SPDX-License-Identifier: Apache-2.0
// How long a polling thread sleeps between polls.
#pragma once
#include <algorithm>
#include <chrono>

namespace gxy {

/// The sleep is zero for a while after activity, then grows, and is longest after two seconds without activity.
class Backoff {
 public:
  using Clock = std::chrono::steady_clock;
  using Microseconds = std::chrono::microseconds;
  static constexpr Microseconds hot{80}, hotInTransfer{20'000}, firstSleep{20}, maxSleep{4000},
      restSleep{16'000}, restAfter{2'000'000};

  /// Without `spins` the thread never polls without a sleep, not even in a transfer: other threads need the core.
  explicit Backoff(bool spins) : spins_(spins) {}

  void active() {
    sleep_ = firstSleep;
    lastActive_ = Clock::now();
  }

  /// Returns how long to sleep now. Each call without activity in between returns a longer sleep, up to
  /// maxSleep; after restAfter it is restSleep. Data move only while MPI is called, so sleeps stay short
  /// during a transfer.
  Microseconds next(bool inTransfer) {
    const auto quiet = Clock::now() - lastActive_;
    if (spins_ && quiet < (inTransfer ? hotInTransfer : hot)) return {};
    const auto sleep = sleep_;
    sleep_ = inTransfer ? firstSleep
                        : std::min<Microseconds>(sleep * 5 / 4, quiet < restAfter ? maxSleep : restSleep);
    return sleep;
  }

 private:
  const bool spins_;
  Microseconds sleep_ = firstSleep;
  Clock::time_point lastActive_{};
};

}  // namespace gxy
