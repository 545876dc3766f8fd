// SPDX-License-Identifier: Apache-2.0
// Which ranks answer.
#pragma once
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <vector>

#include "core/comm/process.h"
#include "core/comm/transport.h"

namespace gxy {

constexpr Channel kPresenceChannel = Channel(3);

/// One on each rank. A rank asks the others, whose progress threads answer, whatever their tasks do: a rank that does not
/// answer is stopped, hangs, or has died. A rank has one question out at most to each other, so that ranks that are silent
/// for long cost nothing. Thread safe; nothing here waits but answered().
class Presence {
 public:
  using Clock = std::chrono::steady_clock;

  struct Options {
    std::function<Clock::time_point()> now = Clock::now;
    ProcessId process = ProcessId::ofThis();  ///< of this rank
  };

  explicit Presence(Transport& transport, Options options);
  explicit Presence(Transport& transport) : Presence(transport, Options{}) {}
  ~Presence();
  Presence(const Presence&) = delete;
  Presence& operator=(const Presence&) = delete;

  /// Asks all ranks that have answered the last question.
  void ask();

  struct Missing {
    int rank;
    bool died;  ///< its process has ended; known of ranks on the same machine that have answered once
    std::chrono::seconds since;  ///< for so long its answer is out
  };
  /// The ranks that have died, and those whose answers are out for at least so long.
  std::vector<Missing> missing(std::chrono::milliseconds patience) const;

  /// Waits until no answer is out, at most so long, and no longer once a rank is known to have died.
  void answered(std::chrono::milliseconds atMost) const;

  /// Whether this rank's process is known to have ended.
  bool died(int rank) const;

 private:
  struct Other {
    std::optional<Clock::time_point> asked;  ///< its answer is out since then
    bool known = false;                      ///< process is its
    WatchedProcess process;
  };
  void send(int rank, bool question);
  void receive(int source, const Bytes& message);

  Transport& transport_;
  const Options options_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::vector<Other> others_;  ///< by rank, this one's unused
};

/// The ranks for people: "rank 1 has died" or "ranks 1 and 3 have not answered for 12 s"; empty where there are none.
std::string textOf(const std::vector<Presence::Missing>& missing);

}  // namespace gxy
