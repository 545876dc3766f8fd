// SPDX-License-Identifier: Apache-2.0
// Finds out which ranks still answer.
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

/// There is one on each rank. A rank asks the others, and their progress threads answer, whatever their tasks
/// do. A rank that does not answer is stopped, hangs, or has died. A rank has at most one unanswered question
/// to each other rank, so ranks that are silent for long cost nothing. Thread safe. Only answered() waits.
class Presence {
 public:
  using Clock = std::chrono::steady_clock;

  struct Options {
    std::function<Clock::time_point()> now = Clock::now;
    ProcessId process = ProcessId::ofThis();  ///< this rank's process
  };

  explicit Presence(Transport& transport, Options options);
  explicit Presence(Transport& transport) : Presence(transport, Options{}) {}
  ~Presence();
  Presence(const Presence&) = delete;
  Presence& operator=(const Presence&) = delete;

  /// Asks all other ranks, except those that have not answered the last question yet.
  void ask();

  struct Missing {
    int rank;
    bool died;  ///< its process has ended; known only of ranks on this machine that have sent a message once
    std::chrono::seconds since;  ///< how long this rank has waited for its answer
  };
  /// Returns the ranks that have died, and those that have not answered for at least `patience`.
  std::vector<Missing> missing(std::chrono::milliseconds patience) const;

  /// Waits until all questions are answered or a rank is known to have died, but at most `atMost`.
  void answered(std::chrono::milliseconds atMost) const;

  /// Whether the process of rank `rank` is known to have ended.
  bool died(int rank) const;

 private:
  struct Other {
    std::optional<Clock::time_point> asked;  ///< time of the question that it has not answered
    bool known = false;                      ///< it has sent its ProcessId, and `process` watches it
    WatchedProcess process;
  };
  void send(int rank, bool question);
  void receive(int source, const Bytes& message);

  Transport& transport_;
  const Options options_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::vector<Other> others_;  ///< by rank; this rank's own entry is unused
};

/// Returns text for users, such as "rank 1 has died" or "ranks 1 and 3 have not answered for 12 s"; empty for
/// no ranks.
std::string textOf(const std::vector<Presence::Missing>& missing);

}  // namespace gxy
