// SPDX-License-Identifier: Apache-2.0
// The triggers of one stream, and what they do.
#pragma once
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "multiserver/insitu/own_session.h"
#include "multiserver/insitu/trigger.h"

namespace gxy {

/// Used on rank 0. Thread safe, but one thread only calls published().
class Triggers {
 public:
  /// Returns a dataset's values in the step that was just published. Throws Error if there is no such field.
  using ValuesOf = TriggerCondition::ValuesOf;
  /// Tells the clients of the stream's tenant.
  using Tell = std::function<void(nlohmann::json event)>;

  /// Steers the simulation. Throws Error.
  using Steer = std::function<void(const std::map<std::string, double>& values)>;

  Triggers(ServerRank& serverRank, std::string stream, std::string tenant, Tell tell, Steer steer);
  ~Triggers() { end(); }

  static constexpr size_t kMost = 64;

  /// Adds a trigger, or replaces that of the same name. Loads what it needs, so it may wait. Throws Error.
  void add(Trigger trigger);
  /// Throws Error if there is none of this name.
  void remove(const std::string& name);
  nlohmann::json list() const;

  /// Does what is to be done with a step. Waits for what is `exact`, until `check` throws.
  void published(int64_t step, double time, const ValuesOf& valuesOf, const std::function<void()>& check);

  /// Waits until everything that was begun is done, or until end().
  void finish();
  /// Cancels what is under way, and waits for it. Nothing is begun any more.
  void end();

  /// Whether any step is wanted, and the first step that may be: nothing: each may be.
  struct Wants {
    bool any = false;
    std::optional<int64_t> from;
  };
  Wants wants() const;

 private:
  struct Armed {
    explicit Armed(Trigger t) : trigger(std::move(t)), condition(trigger) {}
    const Trigger trigger;
    TriggerCondition condition;
    int64_t fired = 0, done = 0;
    std::optional<int64_t> next;  ///< the step that it is to be done for once the one under way is done
    bool running = false;
    std::string problem;
  };
  using ArmedPtr = std::shared_ptr<Armed>;
  void fire(const ArmedPtr& armed, int64_t step, double time, const ValuesOf& valuesOf);
  void begin(const ArmedPtr& armed, int64_t step);
  void ended(const ArmedPtr& armed, int64_t step, const std::string& error);

  ServerRank& serverRank_;
  const std::string stream_, tenant_;
  const Tell tell_;
  const Steer steer_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<ArmedPtr> triggers_;
  int running_ = 0;  ///< triggers of which something is under way, removed ones included
  bool over_ = false;
  std::unique_ptr<OwnSession> session_;  ///< once a trigger needs it
};

}  // namespace gxy
