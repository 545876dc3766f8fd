// SPDX-License-Identifier: Apache-2.0
// How long a polling thread sleeps between polls.
#pragma once
#include <algorithm>
#include <chrono>

namespace gxy {

/// The sleep is zero for a while after activity, then grows, and is longest after two seconds without activity.
/// What comes to all ranks after a rest wakes one rank of a tree after the other, and each may still sleep for so
/// long. But a poll takes up to 25 microseconds of a processor. So of ranks on many nodes those of each node
/// together poll a thousand times a second at rest, if they are 16 at most. Ranks that are all on one node, such as a
/// laptop, are few, and rest longer.
class Backoff {
 public:
  using Clock = std::chrono::steady_clock;
  using Microseconds = std::chrono::microseconds;
  static constexpr Microseconds hot{80}, hotInTransfer{20'000}, firstSleep{20}, maxSleep{4000},
      restSleepOfEach{1000}, maxRestSleep{16'000}, restAfter{2'000'000};

  /// Without `spins` the thread never polls without a sleep, not even in a transfer: other threads need the core.
  Backoff(bool spins, int ranks, int ranksOnNode)
      : spins_(spins),
        restSleep_(ranksOnNode == ranks
                       ? maxRestSleep
                       : std::min<Microseconds>(restSleepOfEach * ranksOnNode, maxRestSleep)) {}

  void active() {
    sleep_ = firstSleep;
    lastActive_ = Clock::now();
  }

  /// Returns how long to sleep now. Each call without activity in between returns a longer sleep, up to that of a
  /// rest, but before restAfter not more than maxSleep. Data move only while MPI is called, so sleeps stay short
  /// during a transfer.
  Microseconds next(bool inTransfer) {
    const auto quiet = Clock::now() - lastActive_;
    if (spins_ && quiet < (inTransfer ? hotInTransfer : hot)) return {};
    const auto sleep = sleep_;
    const auto longest = quiet < restAfter ? std::min(maxSleep, restSleep_) : restSleep_;
    sleep_ = inTransfer ? firstSleep : std::min<Microseconds>(sleep * 5 / 4, longest);
    return sleep;
  }

 private:
  const bool spins_;
  const Microseconds restSleep_;
  Microseconds sleep_ = firstSleep;
  Clock::time_point lastActive_{};
};

}  // namespace gxy
