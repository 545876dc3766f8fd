// SPDX-License-Identifier: Apache-2.0
// How long a thread that polls may sleep.
#pragma once
#include <algorithm>
#include <chrono>

namespace gxy {

/// Zero for a while after activity, then growing; longest after two seconds without any.
class Backoff {
 public:
  using Clock = std::chrono::steady_clock;
  using Microseconds = std::chrono::microseconds;
  static constexpr Microseconds hot{80}, hotInTransfer{20'000}, firstSleep{20}, maxSleep{4000},
      restSleep{16'000}, restAfter{2'000'000};

  /// Without `spins` it sleeps at once, in a transfer too: the core is needed by others.
  explicit Backoff(bool spins) : spins_(spins) {}

  void active() {
    sleep_ = firstSleep;
    lastActive_ = Clock::now();
  }

  /// The sleep due now; each call in a row returns a longer one, up to maxSleep, and restSleep at rest. Data move only
  /// while MPI is called, so with a transfer under way there is something to do, and sleeps stay short.
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
