// SPDX-License-Identifier: Apache-2.0
// Remote calls: a rank sends the name of a registered action and parameters; the receiving rank runs the action.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/comm/trace.h"
#include "core/comm/transport.h"

namespace gxy {

class Reader;

/// Calls named actions on one rank or on all (down a binary tree rooted at the sender), and brings the
/// results back (up the same tree, so that a rank gets two messages at most, and equal results stand in them
/// once). If a name is unknown, a request is malformed, the results in a reply are, or an action throws, the
/// sender gets an error with that rank. A reply that does not say which call it answers is refused, and its
/// caller still waits. None of these ends a process.
///
/// Threads: any thread may call all functions except the constructor and destructor, handlers included. Only
/// call() and callAll() wait: call them from the main thread or from postWaiting() and postLong() tasks.
class Work {
 public:
  /// The arguments of an action. They are valid during the call only.
  struct Call {
    int sender;
    const nlohmann::json& parameters;  ///< as sent; NaN and infinity arrive as null, as JSON has neither
    std::span<const std::byte> attachment;
  };

  /// Returns the result. Throws when it fails; an Error has a message for the user.
  using Action = std::function<nlohmann::json(const Call&)>;

  /// How an action runs. Short: as a task on a worker, for a millisecond at most, since rendering waits for
  /// workers (Transport::post). Waiting: as a task that may wait for other ranks, as in a Collective
  /// (postWaiting). Long: as a task that may wait and computes for long, at low priority (postLong).
  enum class Runs { Short, Waiting, Long };

  struct Reply {
    int rank;
    nlohmann::json result;  ///< null if the action failed
    std::string error;      ///< empty on success, else "rank 3: <reason>"
    bool ok() const { return error.empty(); }
  };

  /// Called once, as a post() task on the sender, with the replies of one rank or of all ranks in order.
  using OnDone = std::function<void(std::vector<Reply>)>;

  /// Each action becomes a stage of `trace`, unless it is null. Both arguments must outlive the object.
  explicit Work(Transport& transport, Trace* trace = nullptr);

  /// Waits for the actions that are running here and drops those that have not begun. It does not wait for
  /// outstanding replies; their OnDone is never called.
  ~Work();

  Work(const Work&) = delete;
  Work& operator=(const Work&) = delete;

  /// Registers an action. Do so on each rank before any rank sends it. Throws Error if the name is taken.
  void add(const std::string& name, Action action, Runs runs = Runs::Short);

  /// Whether an action with this name is registered.
  bool contains(const std::string& name) const;

  /// How the action with this name runs. Throws Error if there is none.
  Runs runsOf(const std::string& name) const;

  /// Calls the action on rank `rank`, or on all ranks, and returns at once. The attachment is copied. send()
  /// throws Error if there is no such rank.
  void send(int rank, const std::string& name, const nlohmann::json& parameters, OnDone onDone,
            std::span<const std::byte> attachment = {});
  void broadcast(const std::string& name, const nlohmann::json& parameters, OnDone onDone,
                 std::span<const std::byte> attachment = {});

  /// These wait for the results and return them, callAll() by rank. They throw Error with the errors of all
  /// ranks if there are any.
  nlohmann::json call(int rank, const std::string& name, const nlohmann::json& parameters,
                      std::span<const std::byte> attachment = {});
  std::vector<nlohmann::json> callAll(const std::string& name, const nlohmann::json& parameters,
                                      std::span<const std::byte> attachment = {});

 private:
  struct Registered {
    Action action;
    Runs runs;
  };
  using CallId = std::pair<int, uint64_t>;  ///< the sender, and its number of the call
  /// Errors and results as JSON text, with the ranks that gave them.
  using Replies = std::map<std::pair<std::string, std::string>, std::vector<int32_t>>;
  /// Replies to a call of all ranks on their way up the tree: those of this rank and of the ranks below it.
  struct Gathering {
    std::set<int> missing;  ///< ranks whose message is to come: this one, and its children
    Replies replies;
  };
  struct Message;
  class Gate;

  Bytes request(const std::string& name, const nlohmann::json& parameters,
                std::span<const std::byte> attachment, bool toAll, OnDone onDone);
  void receive(int source, Bytes message);
  void receiveRequest(Bytes message);
  void receiveReply(int source, const Bytes& message);
  void run(const Message& request, const Action& action);
  void reply(const Message& request, const nlohmann::json& result, const std::string& error);
  static Replies readReplies(Reader& reader, std::vector<int32_t> expected);
  void gather(CallId call, int source, Replies replies);
  void sendReplies(int destination, CallId call, bool toAll, const Replies& replies);
  void conclude(uint64_t id, const Replies& replies);
  void startTask(Runs runs, Transport::Task task);
  std::vector<nlohmann::json> wait(const std::function<void(OnDone)>& start);

  Transport& transport_;
  Trace* const trace_;
  const std::shared_ptr<Gate> gate_;  ///< shared with tasks: those that start too late find it closed
  mutable std::mutex mutex_;
  std::map<std::string, Registered> actions_;
  std::map<uint64_t, OnDone> pending_;      ///< of this rank's calls, by number
  std::map<CallId, Gathering> gatherings_;  ///< of any rank's calls
  uint64_t nextId_ = 0;
};

}  // namespace gxy
