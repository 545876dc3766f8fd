// SPDX-License-Identifier: Apache-2.0
// Verb `watch`: tells a client when a condition on whole fields begins to hold.
#pragma once
#include <atomic>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>

#include "multiserver/server/datasets.h"
#include "multiserver/server/filter_runs.h"
#include "multiserver/server/session.h"

namespace gxy {

/// The condition of a watch, as a client says it.
struct WatchedCondition {
  std::string name;                           ///< of the watch
  std::string expression;                     ///< logical, without fields in its result: max(p) > 3
  std::map<std::string, std::string> inputs;  ///< datasets by the names that the expression calls them

  /// Reads {"expression": TEXT, "name": TEXT, "inputs": {NAME: DATASET}}; without `inputs` the expression's names are those of
  /// datasets, without `name` the expression is the name. Throws Error (what is wrong, what is expected).
  static WatchedCondition read(const nlohmann::json& request);
};

class Watch;

/// Watches that are to be looked at, one after the other. It works on a thread of its own while there are some. Thread safe.
class WatchQueue : public std::enable_shared_from_this<WatchQueue> {
 public:
  explicit WatchQueue(Transport& transport) : transport_(transport) {}
  /// Adds a watch, unless it waits already.
  void add(const std::shared_ptr<Watch>& watch);

 private:
  void work();

  Transport& transport_;
  std::mutex mutex_;
  std::deque<std::weak_ptr<Watch>> waiting_;
  bool isWorking_ = false;
};

/// One watch. Evaluates its condition with the filter Number when data that it reads have a newer generation: of those that have come
/// meanwhile, the newest. Thread safe.
class Watch : public std::enable_shared_from_this<Watch> {
 public:
  Watch(ServerRank& serverRank, std::string tenant, std::shared_ptr<Outbox> outbox,
        std::shared_ptr<WatchQueue> queue, WatchedCondition condition);

  /// Evaluates the condition now, for a request, and from then on by itself. Returns its value: true, false, or null where there
  /// are no data. Throws Error, and then end() is all that is left.
  nlohmann::json begin(Request& request);
  /// Evaluates it again, and tells what is to be told. Waits.
  void look();
  /// Cancels an evaluation that is under way on all ranks, and waits for its end. Nothing happens any more.
  void end();

 private:
  nlohmann::json evaluate(const Asker& asker, std::map<std::string, Generation>& read);

  ServerRank& serverRank_;
  const std::string tenant_;
  const std::shared_ptr<Outbox> outbox_;
  const std::shared_ptr<WatchQueue> queue_;
  const WatchedCondition condition_;
  std::atomic<bool> isEnded_ = false;
  std::atomic<uint64_t> exchange_ = 0;
  std::mutex evaluating_;  ///< held during an evaluation; guards the two below
  bool held_ = false;      ///< whether the condition held last
  std::string problem_;    ///< why it could not be evaluated last
  std::mutex handles_;     ///< guards the two below
  std::shared_ptr<void> want_, subscription_;
};

/// The watches of a session, by name. Thread safe.
class Watches {
 public:
  static constexpr size_t kMost = 64;

  explicit Watches(Session& session) : queue_(std::make_shared<WatchQueue>(session.serverRank().transport)) {}
  ~Watches();
  /// Verb `watch`.
  nlohmann::json add(Request& request, const WatchedCondition& condition);
  /// Verb `unwatch`. Throws Error if there is no watch of this name.
  void remove(const std::string& name);

 private:
  const std::shared_ptr<WatchQueue> queue_;
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Watch>> watches_;
};

}  // namespace gxy
