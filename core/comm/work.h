// SPDX-License-Identifier: Apache-2.0
// Remote action: a registered name, parameters, and an action on the objects of the rank that gets it.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/comm/trace.h"
#include "core/comm/transport.h"

namespace gxy {

/// Sends named actions to one rank or to all (down a binary tree rooted at the sender), and brings the
/// results back. An unknown name, a malformed message, and an action that throws are errors of that rank,
/// told to the sender; nothing of this ends a process.
///
/// Threads: all calls but the constructor and destructor may come from any thread, handlers included, but for
/// the calls that wait, which may come from the main thread and from postWaiting() and postLong() tasks only.
class Work {
 public:
  /// What an action is called with; valid during the call.
  struct Call {
    int sender;
    const nlohmann::json& parameters;  ///< as sent; a NaN or infinity in them arrives as null (JSON has none)
    std::span<const std::byte> attachment;
  };

  /// Returns the result; throws (gxy::Error: a message for the user) when it fails.
  using Action = std::function<nlohmann::json(const Call&)>;

  /// Where an action runs: as a task on a worker, which all that is rendered waits for, so for a millisecond at most
  /// (Transport::post); as a task that may wait for other ranks, as in a Collective (postWaiting); or as one that may wait and
  /// computes long, with what the others leave of the processors (postLong).
  enum class Runs { Short, Waiting, Long };

  struct Reply {
    int rank;
    nlohmann::json result;  ///< null when it failed
    std::string error;      ///< empty: success; else "rank 3: <reason>"
    bool ok() const { return error.empty(); }
  };

  /// Called once, as a task on the sender, with the replies by rank (of one rank, or of all).
  using OnDone = std::function<void(std::vector<Reply>)>;

  /// Actions are stages of `trace`, if not null.
  explicit Work(Transport& transport, Trace* trace = nullptr);

  /// Waits for the actions that run here, drops those that have not begun. Replies that are still out are not
  /// awaited, and their OnDone never called.
  ~Work();

  Work(const Work&) = delete;
  Work& operator=(const Work&) = delete;

  /// Before anyone sends it. Throws Error when the name is taken.
  void add(const std::string& name, Action action, Runs runs = Runs::Short);

  /// Whether an action has this name.
  bool contains(const std::string& name) const;

  /// Where the action of this name runs. Throws Error where there is none.
  Runs runsOf(const std::string& name) const;

  void send(int rank, const std::string& name, const nlohmann::json& parameters, OnDone onDone,
            std::span<const std::byte> attachment = {});
  void broadcast(const std::string& name, const nlohmann::json& parameters, OnDone onDone,
                 std::span<const std::byte> attachment = {});

  /// These wait for the results, and throw Error with the errors of all ranks when there are any.
  nlohmann::json call(int rank, const std::string& name, const nlohmann::json& parameters,
                      std::span<const std::byte> attachment = {});
  std::vector<nlohmann::json> callAll(const std::string& name, const nlohmann::json& parameters,
                                      std::span<const std::byte> attachment = {});

 private:
  struct Registered {
    Action action;
    Runs runs;
  };
  struct Pending {
    size_t expected;
    std::map<int, Reply> replies;
    OnDone onDone;
  };
  struct Request;
  class Gate;

  Bytes request(const std::string& name, const nlohmann::json& parameters,
                std::span<const std::byte> attachment, bool toAll, size_t expected, OnDone onDone);
  void receive(int source, Bytes message);
  void receiveRequest(Bytes message);
  void receiveReply(int source, const Bytes& message);
  void run(const Request& request, const Action& action);
  void reply(const Request& request, const nlohmann::json& result, const std::string& error);
  void startTask(Runs runs, Transport::Task task);
  std::vector<nlohmann::json> wait(const std::function<void(OnDone)>& start);

  Transport& transport_;
  Trace* const trace_;
  const std::shared_ptr<Gate> gate_;  ///< tasks share it: one that comes too late finds it closed
  mutable std::mutex mutex_;
  std::map<std::string, Registered> actions_;
  std::map<uint64_t, Pending> pending_;
  uint64_t nextId_ = 0;
};

}  // namespace gxy
