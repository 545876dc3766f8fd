// SPDX-License-Identifier: Apache-2.0
// DeviceTime: how long a device worked, and how long it had nothing to do while frames were under way.
#pragma once
#include <cstdint>
#include <map>
#include <mutex>

namespace gxy::vulkan {

/// A set of intervals that do not touch, of times of one clock, added in any order.
class Intervals {
 public:
  /// Adds [begin, end). Returns how much of it was not in the set yet.
  int64_t add(uint64_t begin, uint64_t end);
  /// Forgets intervals that end before `time`, but keeps the latest few. If times that are forgotten are
  /// added again, they count twice.
  void forget(uint64_t time);
  size_t size() const { return ends_.size(); }

 private:
  std::map<uint64_t, uint64_t> ends_;  ///< key: where the interval begins
};

/// A frame is under way on the device from the beginning of the first work to the end of the last that the
/// device does for it. The device is busy while it works for any frame, and idle while it does not although
/// some frame is under way. Both are unions of intervals: it does not matter whose work comes next, and no
/// time is counted twice. A pause is counted when the next work of one of those frames shows that the frame
/// went on. All times are nanoseconds of the device's clock. Thread safe.
class DeviceTime {
 public:
  /// `round`: after so many nanoseconds the clock starts again at 0; 0: never.
  explicit DeviceTime(uint64_t round = 0) : round_(round) {}
  struct Spent {
    int64_t busy = 0;
    /// Negative if work is told after later work, and its time was counted as idle before.
    int64_t idle = 0;
  };
  /// Says that the device has worked for a frame from `began` to `ended`. Returns what that adds to the sums;
  /// nothing if the two are the same, as without a clock. Work must be told within half a round.
  Spent worked(uint64_t frame, uint64_t began, uint64_t ended);
  /// Says that the device does nothing more for this frame. It may never have done anything for it.
  void over(uint64_t frame);
  /// The number of intervals that it remembers, for tests.
  size_t remembered() const;

 private:
  /// The time, counted without starting again, that is nearest to the latest known one and at which the clock
  /// shows `time`.
  uint64_t unwound(uint64_t time);

  struct Span {
    uint64_t began, ended;
  };
  const uint64_t round_;
  mutable std::mutex mutex_;
  uint64_t latest_ = 0;
  std::map<uint64_t, Span> underWay_;  ///< key: number of a frame that is not over
  Intervals frames_, work_;
};

}  // namespace gxy::vulkan
