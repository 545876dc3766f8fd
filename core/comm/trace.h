// SPDX-License-Identifier: Apache-2.0
// Records what a rank did at which time, in the format of chrome://tracing and ui.perfetto.dev.
#pragma once
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace gxy {

/// Keeps the newest `most` stages of a rank in memory, 56 bytes each. Thread safe. Code that can be traced holds
/// a pointer to a Trace. The pointer is null when nobody asked for a trace; then a stage costs one comparison.
class Trace {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Trace(size_t most = size_t(1) << 18) : most_(most) {}

  /// A stage that lasts from construction to destruction, on the thread that destroys it.
  class Span {
   public:
    /// `value` is a number to show with the stage, such as its bytes or rays. `name` must outlive the Span;
    /// its first 23 bytes are kept.
    Span(Trace* trace, std::string_view name, uint64_t value = 0) : trace_(trace) {
      if (trace_) start(name, value);
    }
    ~Span() {
      if (trace_) end();
    }
    Span(const Span&) = delete;
    Span& operator=(const Span&) = delete;

   private:
    void start(std::string_view name, uint64_t value);
    void end();
    Trace* const trace_;
    std::string_view name_;
    uint64_t value_;
    Clock::time_point begin_;
  };

  /// Adds a stage that began on any thread and ends now. Stages of one name may overlap; `id` tells them apart.
  void addLong(std::string_view name, uint64_t id, Clock::time_point begin);

  /// Returns the stages as a list of JSON objects without the list's brackets, with the rank as their
  /// process. Times of different ranks are comparable as far as the clocks of their machines agree.
  std::string events(int rank) const;

  /// Returns a JSON document with the events of all ranks; `eventsOfRanks` has the result of events() of each.
  static std::string document(const std::vector<std::string>& eventsOfRanks);

 private:
  struct Event {
    std::array<char, 24> name;
    Clock::time_point begin, end;
    uint64_t value;
    int thread;
    bool isLong;
  };
  void add(std::string_view name, uint64_t value, Clock::time_point begin, bool isLong);

  const size_t most_;
  /// Difference of the system clock from the steady clock.
  const std::chrono::nanoseconds ahead_ =
      std::chrono::system_clock::now().time_since_epoch() - Clock::now().time_since_epoch();
  mutable std::mutex mutex_;
  std::vector<Event> events_;
  size_t oldest_ = 0;  ///< index that the next event overwrites once events_ is full
};

}  // namespace gxy
