// SPDX-License-Identifier: Apache-2.0
// How long a device worked, and how long it had nothing to do though frames were under way.
#pragma once
#include <cstdint>
#include <map>
#include <mutex>

namespace gxy::vulkan {

/// Times of one clock, in any order, as a set of intervals that do not touch.
class Intervals {
 public:
  /// Adds [begin, end); how much of it was not in yet.
  int64_t add(uint64_t begin, uint64_t end);
  /// Forgets those that end before `time`, but for the latest few: of what is added late, times there would count twice.
  void forget(uint64_t time);
  size_t size() const { return ends_.size(); }

 private:
  std::map<uint64_t, uint64_t> ends_;  ///< by beginnings
};

/// A frame is under way on the device from the beginning of the first to the end of the last that the device does for it. The
/// device is busy while it works for any frame, and idle while it does not although some frame is under way: both are unions, so
/// it does not matter whose work comes next, and neither counts a time twice. A pause is counted when the next work of one of
/// those frames shows that it went on. Nanoseconds of the device's clock. Thread safe.
class DeviceTime {
 public:
  /// `round`: after so long its clock begins anew; 0: never.
  explicit DeviceTime(uint64_t round = 0) : round_(round) {}
  struct Spent {
    int64_t busy = 0;
    int64_t idle =
        0;  ///< below 0 where work is told after later work, and the time of it was counted as idle
  };
  /// The device has worked for a frame from `began` to `ended` (nothing is counted if they are the same, as without a clock): what
  /// that adds to the sums. Work is told within half a round.
  Spent worked(uint64_t frame, uint64_t began, uint64_t ended);
  /// The device does nothing more for this frame; it may never have done anything.
  void over(uint64_t frame);
  /// Intervals that it remembers, for tests.
  size_t remembered() const;

 private:
  /// The moment nearest to the latest that is known at which the clock says so.
  uint64_t unwound(uint64_t time);

  struct Span {
    uint64_t began, ended;
  };
  const uint64_t round_;
  mutable std::mutex mutex_;
  uint64_t latest_ = 0;
  std::map<uint64_t, Span> underWay_;  ///< frames that are not over
  Intervals frames_, work_;
};

}  // namespace gxy::vulkan
