// SPDX-License-Identifier: Apache-2.0
// Verb `watch`: tells a client when a condition on whole fields begins to hold.
#pragma once
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
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

/// One watch. Evaluates its condition with the filter Number whenever data that it reads have a newer generation, one evaluation at
/// a time: of generations that come meanwhile, the newest counts. Thread safe.
class Watch : public std::enable_shared_from_this<Watch> {
 public:
  Watch(ServerRank& serverRank, std::string tenant, std::shared_ptr<Outbox> outbox,
        WatchedCondition condition);

  /// Evaluates the condition now, for a request, and from then on by itself. Returns its value: true, false, or null where there
  /// are no data. Throws Error, and then end() is all that is left.
  nlohmann::json begin(Request& request);
  /// Cancels an evaluation that is under way, and waits for its end. Nothing happens any more. Not within an event.
  void end();

 private:
  void look();
  void runAll();
  nlohmann::json evaluate(const Asker& asker, std::map<std::string, Generation>& read);
  void tell(nlohmann::json event);

  ServerRank& serverRank_;
  const std::string tenant_;
  const std::shared_ptr<Outbox> outbox_;
  const WatchedCondition condition_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool running_ = false, again_ = false, ended_ = false;
  // Of the thread that evaluates:
  bool held_ = false;    ///< whether the condition held last
  std::string problem_;  ///< why it could not be evaluated last
  // Handles, let go of by end():
  std::shared_ptr<void> want_, subscription_;
};

/// The watches of a session, by name. Thread safe.
class Watches {
 public:
  static constexpr size_t kMost = 64;

  ~Watches();
  /// Verb `watch`.
  nlohmann::json add(Request& request, const WatchedCondition& condition);
  /// Verb `unwatch`. Throws Error if there is no watch of this name.
  void remove(const std::string& name);

 private:
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Watch>> watches_;
};

}  // namespace gxy
