// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/analysis/watches.h"

#include <utility>
#include <vector>

#include "core/analysis/expression.h"
#include "core/comm/error.h"

namespace gxy {

namespace {
using nlohmann::json;

std::string textOf(const json& value, const std::string& key) {
  if (!value.is_string() || value.get_ref<const std::string&>().empty())
    throw Error("watch: " + inQuotes(key, '`') + ": expected a text, found " + value.dump());
  return value.get<std::string>();
}

}  // namespace

WatchedCondition WatchedCondition::read(const json& request) {
  WatchedCondition c;
  for (const auto& [key, value] : request.items()) {
    if (key == "expression")
      c.expression = textOf(value, key);
    else if (key == "name")
      c.name = textOf(value, key);
    else if (key != "inputs")
      throw Error("watch: unknown key " + inQuotes(key, '`') + ", expected `expression`, `name` or `inputs`");
  }
  if (c.expression.empty()) throw Error("watch: there is no `expression`, expected one, such as max(p) > 3");
  const Expression parsed(c.expression);
  for (const std::string& name : parsed.names()) c.inputs[name] = name;
  if (const auto inputs = request.find("inputs"); inputs != request.end()) {
    if (!inputs->is_object())
      throw Error("watch: `inputs`: expected an object {NAME: DATASET}, found " + inputs->dump());
    for (const auto& [name, dataset] : inputs->items()) {
      if (!c.inputs.count(name))
        throw Error("watch: `inputs`: the expression has no name " + inQuotes(name, '`'));
      c.inputs[name] = textOf(dataset, name);
    }
  }
  if (c.inputs.empty()) throw Error("watch: the expression names no dataset, expected one, as in max(p) > 3");
  if (c.name.empty()) c.name = c.expression;
  return c;
}

Watch::Watch(ServerRank& serverRank, std::string tenant, std::shared_ptr<Outbox> outbox,
             WatchedCondition condition)
    : serverRank_(serverRank),
      tenant_(std::move(tenant)),
      outbox_(std::move(outbox)),
      condition_(std::move(condition)) {}

json Watch::begin(Request& request) {
  running_ = true;  // What comes during the first evaluation is looked at after it.
  std::vector<std::string> names;
  for (const auto& [name, dataset] : condition_.inputs) names.push_back(dataset);
  auto subscription = serverRank_.datasets->observe(
      [weak = weak_from_this(), names, tenant = tenant_](const DatasetEvent& event) {
        const auto watch = weak.lock();
        if (!watch || !event.visibleTo(tenant)) return;
        for (const std::string& name : names)
          if (name == event.dataset.name || name == event.newName) return watch->look();
      });
  auto want = serverRank_.datasets->want(tenant_, names);
  {
    const std::lock_guard lock(mutex_);
    subscription_ = std::move(subscription);
    want_ = std::move(want);
  }
  const auto rest = [this] {
    running_ = false;
    changed_.notify_all();
  };
  try {
    std::map<std::string, Generation> read;
    const json value = evaluate(askerOf(request), read);
    held_ = value == true;
    const std::lock_guard lock(mutex_);
    if (again_)
      serverRank_.transport.postWaiting([self = shared_from_this()] { self->runAll(); });
    else
      rest();
    return value;
  } catch (...) {
    const std::lock_guard lock(mutex_);
    rest();
    throw;
  }
}

void Watch::look() {
  const std::lock_guard lock(mutex_);
  again_ = true;
  if (running_ || ended_) return;
  running_ = true;
  serverRank_.transport.postWaiting([self = shared_from_this()] { self->runAll(); });
}

void Watch::runAll() {
  while (true) {
    {
      const std::lock_guard lock(mutex_);
      if (!again_ || ended_) {
        running_ = false;
        changed_.notify_all();
        return;
      }
      again_ = false;
    }
    Asker asker;
    asker.check = [this] {
      const std::lock_guard lock(mutex_);
      if (ended_) throw Error("cancelled");
    };
    json event{{"event", "watch"}, {"watch", condition_.name}};
    try {
      std::map<std::string, Generation> read;
      const json value = evaluate(asker, read);
      problem_.clear();
      if (value == true && !held_) {
        event["value"] = true;
        event["generations"] = read;
        tell(std::move(event));
      }
      held_ = value == true;
    } catch (const std::exception& e) {
      held_ = false;
      if (problem_ == e.what()) continue;
      problem_ = e.what();
      event["error"] = problem_;
      tell(std::move(event));
    }
  }
}

void Watch::tell(json event) {
  {
    const std::lock_guard lock(mutex_);
    if (ended_) return;
  }
  outbox_->event(event);
}

json Watch::evaluate(const Asker& asker, std::map<std::string, Generation>& read) {
  FilterRuns::Evaluation what;
  what.tenant = tenant_;
  what.label = "watch " + condition_.name;
  what.purpose = "derived";
  what.filter = "Number";
  what.properties = json{{"expression", condition_.expression}}.dump();
  what.sources = [&] {
    std::vector<std::string> names;
    for (const auto& [input, dataset] : condition_.inputs) names.push_back(dataset);
    auto pinned = serverRank_.datasets->getPinned(tenant_, names);
    std::vector<FilterRuns::Evaluation::Source> sources;
    size_t i = 0;
    for (const auto& [input, dataset] : condition_.inputs) {
      auto& [named, pin] = pinned[i++];
      if (named.type != nameOf(DatasetType::Volume))
        throw Error("watch: dataset " + inQuotes(dataset) + " is " + named.type + ", expected a Volume");
      read[dataset] = named.generation;
      sources.push_back({input, dataset, {named.key, named.generation}, std::move(pin)});
    }
    return sources;
  };
  const json value = serverRank_.filterRuns->evaluate(asker, what).told.at("value");
  if (value.is_number())
    throw Error("watch: " + inQuotes(condition_.expression) +
                " is a number, expected a condition, such as max(p) > 3");
  return value;
}

void Watch::end() {
  std::shared_ptr<void> want, subscription;
  std::unique_lock lock(mutex_);
  ended_ = true;
  want.swap(want_);
  subscription.swap(subscription_);
  changed_.wait(lock, [&] { return !running_; });
}

Watches::~Watches() {
  for (const auto& [name, watch] : watches_) watch->end();
}

json Watches::add(Request& request, const WatchedCondition& condition) {
  Session& session = request.session();
  const auto watch =
      std::make_shared<Watch>(session.serverRank(), session.tenant(), session.sharedOutbox(), condition);
  std::shared_ptr<Watch> before;
  const std::shared_ptr<void> last(nullptr, [&](void*) {
    if (before) before->end();
  });
  json value;
  try {
    value = watch->begin(request);
  } catch (...) {
    watch->end();
    throw;
  }
  {
    const std::lock_guard lock(mutex_);
    const auto found = watches_.find(condition.name);
    if (found != watches_.end())
      before = std::exchange(found->second, watch);
    else if (watches_.size() < kMost)
      watches_[condition.name] = watch;
    else
      before = watch;
  }
  if (before == watch)
    throw Error("watch: " + std::to_string(kMost) + " watches of this connection, expected fewer");
  return {{"watch", condition.name}, {"value", value}, {"text", condition.name + ": " + value.dump()}};
}

void Watches::remove(const std::string& name) {
  std::shared_ptr<Watch> watch;
  {
    const std::lock_guard lock(mutex_);
    const auto found = watches_.find(name);
    if (found == watches_.end()) throw Error("unwatch: there is no watch " + inQuotes(name));
    watch = std::move(found->second);
    watches_.erase(found);
  }
  watch->end();
}

}  // namespace gxy
