// SPDX-License-Identifier: Apache-2.0
// How many rays are traced together.
#pragma once
#include <time.h>

#include <algorithm>
#include <atomic>
#include <chrono>

namespace gxy {

/// Rays a packet, so that one takes at most kMostWork: whoever is more urgent waits for the packets under way. Begins small,
/// doubles while packets are cheap, and shrinks in proportion where they are not. Thread safe; one that is told of two
/// packets at once may forget one of them.
class PacketSize {
 public:
  /// Of a thread's processor time, or a device's.
  static constexpr std::chrono::nanoseconds kMostWork{5'000'000};
  static constexpr int kFewest = 16;  ///< the widest gang

  /// At most `most` rays; `first` while nobody knows what they take.
  explicit PacketSize(int most, int first = kFewest) : most_(most), rays_(std::min(most, first)) {}

  int rays() const { return rays_; }

  /// A packet of so many rays took so much processor time.
  void took(int rays, std::chrono::nanoseconds work) {
    const int now = rays_;
    if (2 * work > kMostWork)
      rays_ = std::clamp(int(rays * (kMostWork / 4) / work), std::min(kFewest, now), now);
    else if (rays >= now && 4 * work < kMostWork)
      rays_ = std::min(2 * now, most_);
  }

  /// Of the calling thread.
  static std::chrono::nanoseconds processorTime() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return std::chrono::seconds(t.tv_sec) + std::chrono::nanoseconds(t.tv_nsec);
  }

 private:
  const int most_;
  std::atomic<int> rays_;
};

}  // namespace gxy
