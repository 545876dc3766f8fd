// SPDX-License-Identifier: Apache-2.0
// PacketSize: how many rays are traced together.
#pragma once
#include <time.h>

#include <algorithm>
#include <atomic>
#include <chrono>

namespace gxy {

/// Adapts the number of rays in a packet, so that a packet takes at most kMostWork, because whoever is more
/// urgent waits for the packets under way. It begins small, doubles while packets are cheap, and shrinks in
/// proportion when they are not. Thread safe; if two packets report at once, one of them may be forgotten.
class PacketSize {
 public:
  /// Processor time of a thread, or time of a device.
  static constexpr std::chrono::nanoseconds kMostWork{5'000'000};
  static constexpr int kFewest = 16;  ///< the widest gang

  /// A packet has at most `most` rays, and `first` until the time of one is known.
  explicit PacketSize(int most, int first = kFewest) : most_(most), rays_(std::min(most, first)) {}

  int rays() const { return rays_; }

  /// Reports that a packet of `rays` rays took this much processor or device time.
  void took(int rays, std::chrono::nanoseconds work) {
    const int now = rays_;
    if (2 * work > kMostWork)
      rays_ = std::clamp(int(rays * (kMostWork / 4) / work), std::min(kFewest, now), now);
    else if (rays >= now && 4 * work < kMostWork)
      rays_ = std::min(2 * now, most_);
  }

  /// Processor time of the calling thread so far.
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
