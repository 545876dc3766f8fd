// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/triggers.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "core/comm/error.h"
#include "core/scene/json_text.h"

namespace gxy {

using nlohmann::json;

Triggers::Triggers(ServerRank& serverRank, std::string stream, std::string tenant, Tell tell, Steer steer)
    : serverRank_(serverRank),
      stream_(std::move(stream)),
      tenant_(std::move(tenant)),
      tell_(std::move(tell)),
      steer_(std::move(steer)) {}

void Triggers::finish() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return over_ || running_ == 0; });
}

void Triggers::end() {
  OwnSession* session = nullptr;
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
    session = session_.get();
    changed_.notify_all();
  }
  if (session) session->end();  // without the lock, which the ends of its requests take
}

void Triggers::add(Trigger trigger) {
  if (trigger.document.is_object()) {
    {
      const std::lock_guard lock(mutex_);
      if (over_) throw Error("trigger: the stream has ended");
      if (!session_)
        session_ = std::make_unique<OwnSession>(serverRank_, tenant_, "triggers of stream " + stream_);
    }
    session_->load("viewer");
  }
  const std::lock_guard lock(mutex_);
  std::erase_if(triggers_, [&](const ArmedPtr& t) { return t->trigger.name == trigger.name; });
  if (triggers_.size() >= kMost)
    throw Error("trigger: the stream has " + std::to_string(kMost) + " triggers, no more are allowed");
  triggers_.push_back(std::make_shared<Armed>(std::move(trigger)));
}

void Triggers::remove(const std::string& name) {
  const std::lock_guard lock(mutex_);
  if (std::erase_if(triggers_, [&](const ArmedPtr& t) { return t->trigger.name == name; }) == 0)
    throw Error("trigger " + inQuotes(name) + ": the stream has none of this name");
}

json Triggers::list() const {
  const std::lock_guard lock(mutex_);
  json list = json::array();
  for (const ArmedPtr& t : triggers_) {
    json one = written(t->trigger);
    for (const char* document : {"batch", "cinema"}) one.erase(document);  // They may be long.
    one["fired"] = t->fired;
    one["done"] = t->done;
    if (!t->problem.empty()) one["problem"] = t->problem;
    list.push_back(std::move(one));
  }
  return list;
}

Triggers::Wants Triggers::wants() const {
  const std::lock_guard lock(mutex_);
  Wants wants;
  bool each = false;
  for (const ArmedPtr& t : triggers_) {
    wants.any = true;
    const auto next = t->condition.next();
    each = each || !next;
    if (next) wants.from = std::min(wants.from.value_or(*next), *next);
  }
  if (each) wants.from.reset();
  return wants;
}

void Triggers::published(int64_t step, double time, const ValuesOf& valuesOf,
                         const std::function<void()>& check) {
  std::vector<ArmedPtr> due;
  {
    const std::lock_guard lock(mutex_);
    for (const ArmedPtr& t : triggers_) {
      try {
        if (t->condition.holds(step, valuesOf)) due.push_back(t);
      } catch (const Error& e) {
        t->problem = e.what();
      }
    }
  }
  for (const ArmedPtr& t : due) fire(t, step, time, valuesOf);
  std::unique_lock lock(mutex_);
  const auto waits = [&] {
    return std::any_of(due.begin(), due.end(),
                       [](const ArmedPtr& t) { return t->trigger.exact && t->running; });
  };
  while (waits()) {
    lock.unlock();
    check();
    lock.lock();
    changed_.wait_for(lock, std::chrono::milliseconds(100), [&] { return !waits(); });
  }
}

void Triggers::fire(const ArmedPtr& armed, int64_t step, double time, const ValuesOf& valuesOf) {
  const Trigger& trigger = armed->trigger;
  json event{{"event", "trigger"}, {"stream", stream_}, {"trigger", trigger.name}, {"step", step}};
  if (!std::isnan(time)) event["time"] = time;
  for (const Trigger::Threshold& t : trigger.thresholds) {
    StepValues values;
    try {
      values = valuesOf(t.field);
    } catch (const Error&) {
      continue;  // The dataset was dropped just now.
    }
    event["values"][t.field] = {{"nodata", values.noData}};
    if (values.least <= values.largest) event["values"][t.field]["range"] = {values.least, values.largest};
  }
  tell_(std::move(event));
  std::string problem;
  if (trigger.does == Trigger::Does::Steer) try {
      steer_(trigger.steer);
    } catch (const Error& e) {
      problem = e.what();
    }
  bool begins = false;
  {
    const std::lock_guard lock(mutex_);
    armed->fired++;
    if (!trigger.document.is_object()) {
      armed->done += problem.empty();
      armed->problem = problem;
    } else if (armed->running)
      armed->next = step;
    else
      begins = armed->running = ++running_ > 0;
  }
  if (begins) begin(armed, step);
}

void Triggers::begin(const ArmedPtr& armed, int64_t step) {
  session_->run(statementOf(armed->trigger, step),
                [this, armed, step](const std::string& error) { ended(armed, step, error); });
}

// On any thread.
void Triggers::ended(const ArmedPtr& armed, int64_t step, const std::string& error) {
  std::optional<int64_t> next;
  {
    const std::lock_guard lock(mutex_);
    if (error.empty()) armed->done++;
    armed->problem = error;
    if (!over_) next = std::exchange(armed->next, std::nullopt);
    armed->running = next.has_value();
    if (!armed->running) running_--;
    changed_.notify_all();
    if (over_) return;
  }
  if (!error.empty()) {
    spdlog::warn("rank 0: stream {}, trigger {}: {}", stream_, armed->trigger.name, error);
    tell_({{"event", "trigger failed"},
           {"stream", stream_},
           {"trigger", armed->trigger.name},
           {"step", step},
           {"error", error}});
  }
  if (next) begin(armed, *next);
}

}  // namespace gxy
