// SPDX-License-Identifier: Apache-2.0
// What gpu_report finds out about a device, written as it finds it out.
#pragma once
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <ostream>
#include <string>
#include <thread>

#include "backends/vulkan/vulkan_backend.h"

namespace gxy::gpu_report {

/// Both to the file and to the terminal, at once: what was found stays if the device takes the program with it. Ends the program,
/// with status 1, where its time is over and it has not been finished; `least` seconds are always given.
class Report {
 public:
  Report(std::ostream& file, std::ostream& terminal, double minutes, double least = 30)
      : file_(file),
        terminal_(terminal),
        end_(Clock::now() + duration(60 * minutes)),
        watch_([this, last = std::max(end_, Clock::now() + duration(least))](std::stop_token finished) {
          std::unique_lock lock(mutex_);
          finished_.wait_until(lock, finished, last, [] { return false; });
          if (finished.stop_requested()) return;
          lock.unlock();
          line("\nThe time is over, and what was begun last is not done.");
          std::_Exit(1);
        }) {}
  /// After the last line: whatever takes time from here on is nobody's concern.
  void finish() {
    watch_.request_stop();
    watch_.join();
  }
  void line(const std::string& text) {
    std::lock_guard lock(mutex_);
    file_ << text << std::endl;
    terminal_ << text << std::endl;
  }
  /// Seconds that are left of its time.
  double left() const { return std::chrono::duration<double>(end_ - Clock::now()).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  static Clock::duration duration(double seconds) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  }
  std::ostream &file_, &terminal_;
  const Clock::time_point end_;
  std::mutex mutex_;
  std::condition_variable_any finished_;
  std::jthread watch_;
};

/// How many scenes there are, for how many there was time, and how many of these failed.
struct Tally {
  int all = 0, tried = 0, failed = 0;
};

/// Pictures of many small scenes against the Embree backend's, and against the device's own of a domain in
/// pieces. A device agrees where Difference::agrees() and the pieces do not show at all.
/// `most`: of these scenes, so many at most. `folder`, if not empty: where the pictures of each scene are left, SCENE.embree.raw and SCENE.device.raw.
Tally agreement(const Backend& device, int most, const std::string& folder, Report& report);

/// Times of frames, and what they say of the device, which is the one that `options` choose. `scale`: of the data's size, 1 for a
/// large GPU; `seconds`: of frames, for each benchmark.
Tally benchmarks(const Backend& device, const VulkanOptions& options, double scale, double seconds,
                 Report& report);

}  // namespace gxy::gpu_report
