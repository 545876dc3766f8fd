// SPDX-License-Identifier: Apache-2.0
// What a rank did when, for chrome://tracing and ui.perfetto.dev.
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

/// Stages of a rank, kept in memory: the newest `most`, 64 bytes each. Thread safe. Whoever may be traced has a pointer to
/// one, null when nobody asked for a trace; then a stage costs a comparison.
class Trace {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Trace(size_t most = size_t(1) << 18) : most_(most) {}

  /// A stage, from construction to destruction, on the thread that it is on.
  class Span {
   public:
    /// `value`: bytes, rays, ... of the stage; the name is copied, up to 23 bytes of it.
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

  /// A stage that began on any thread and ends now; those of one name may overlap, told apart by `id`.
  void addLong(std::string_view name, uint64_t id, Clock::time_point begin);

  /// The events as a list of JSON objects, without its brackets, with the rank as their process. Times of ranks are
  /// comparable as far as the clocks of their machines agree.
  std::string events(int rank) const;

  /// A whole document of the events of all ranks.
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
  /// What the system's time is ahead of the steady clock.
  const std::chrono::nanoseconds ahead_ =
      std::chrono::system_clock::now().time_since_epoch() - Clock::now().time_since_epoch();
  mutable std::mutex mutex_;
  std::vector<Event> events_;
  size_t oldest_ = 0;  ///< where the next goes, once all places are taken
};

}  // namespace gxy
