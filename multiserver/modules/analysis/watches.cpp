// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/analysis/watches.h"

#include <utility>
#include <vector>

#include "core/analysis/expression.h"
#include "core/comm/error.h"
#include "multiserver/protocol/json.h"

namespace gxy {

namespace {
using nlohmann::json;

constexpr size_t kMostNameBytes = 255;

std::string textOf(const json& value, const std::string& key) {
  if (!value.is_string() || value.get_ref<const std::string&>().empty())
    throw Error("watch: " + inQuotes(key, '`') + ": expected a text, found " +
                protocol::dump(value).substr(0, 100));
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
  for (const auto& [name, dataset] : c.inputs) checkDatasetName(dataset);
  if (c.name.empty()) c.name = c.expression.substr(0, kMostNameBytes);
  if (c.name.size() > kMostNameBytes)
    throw Error("watch: `name`: expected at most " + std::to_string(kMostNameBytes) + " bytes, found " +
                std::to_string(c.name.size()));
  return c;
}

void WatchQueue::add(const std::shared_ptr<Watch>& watch) {
  const std::lock_guard lock(mutex_);
  for (const auto& waiting : waiting_)
    if (waiting.lock() == watch) return;
  waiting_.push_back(watch);
  if (std::exchange(isWorking_, true)) return;
  transport_.postWaiting([self = shared_from_this()] { self->work(); });
}

void WatchQueue::work() {
  while (true) {
    std::shared_ptr<Watch> watch;
    {
      const std::lock_guard lock(mutex_);
      while (!watch && !waiting_.empty()) {
        watch = waiting_.front().lock();
        waiting_.pop_front();
      }
      if (!watch) {
        isWorking_ = false;
        return;
      }
    }
    watch->look();
  }
}

Watch::Watch(ServerRank& serverRank, std::string tenant, std::shared_ptr<Outbox> outbox,
             std::shared_ptr<WatchQueue> queue, WatchedCondition condition)
    : serverRank_(serverRank),
      tenant_(std::move(tenant)),
      outbox_(std::move(outbox)),
      queue_(std::move(queue)),
      condition_(std::move(condition)) {}

json Watch::begin(Request& request) {
  std::vector<std::string> names;
  for (const auto& [name, dataset] : condition_.inputs) names.push_back(dataset);
  const std::lock_guard evaluating(evaluating_);
  auto subscription = serverRank_.datasets->observe(
      [weak = weak_from_this(), names, tenant = tenant_](const DatasetEvent& event) {
        const auto watch = weak.lock();
        if (!watch || !event.visibleTo(tenant) || event.kind == DatasetEvent::Kind::Skipped) return;
        for (const std::string& name : names)
          if (name == event.dataset.name || name == event.newName) return watch->queue_->add(watch);
      });
  auto want = serverRank_.datasets->want(tenant_, names);
  {
    const std::lock_guard lock(handles_);
    subscription_ = std::move(subscription);
    want_ = std::move(want);
  }
  std::map<std::string, Generation> read;
  const json value = evaluate(askerOf(request), read);
  held_ = value == true;
  return value;
}

void Watch::look() {
  const std::lock_guard evaluating(evaluating_);
  if (isEnded_) return;
  Asker asker;
  asker.check = [this] {
    if (isEnded_) throw Error("cancelled");
  };
  json event{{"event", "watch"}, {"watch", condition_.name}};
  std::string problem;
  try {
    std::map<std::string, Generation> read;
    const bool holds = evaluate(asker, read) == true;
    if (holds && !held_) event.update({{"value", true}, {"generations", read}});
    held_ = holds;
  } catch (const std::exception& e) {
    held_ = false;
    problem = e.what();
    if (problem != problem_) event["error"] = problem;
  }
  problem_ = problem;
  if (!isEnded_ && event.size() > 2) outbox_->event(event);
}

json Watch::evaluate(const Asker& asker, std::map<std::string, Generation>& read) {
  FilterRuns::Evaluation what;
  what.tenant = tenant_;
  what.label = "watch " + condition_.name;
  what.purpose = "derived";
  what.filter = "Number";
  what.properties = json{{"expression", condition_.expression}}.dump();
  what.begun = [this](uint64_t exchange) {
    exchange_ = exchange;
    if (isEnded_) serverRank_.exchanges.cancel(exchange);
  };
  std::vector<Pin> kept;  // until it has ended
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
      kept.push_back(serverRank_.objects.pin(named.key, named.generation));
      sources.push_back({input, dataset, {named.key, named.generation}, std::move(pin)});
    }
    return sources;
  };
  const std::shared_ptr<void> over(nullptr, [this](void*) { exchange_ = 0; });
  const json value = serverRank_.filterRuns->evaluate(asker, what).told.at("value");
  if (value.is_number())
    throw Error("watch: " + inQuotes(condition_.expression) +
                " is a number, expected a condition, such as max(p) > 3");
  return value;
}

void Watch::end() {
  isEnded_ = true;
  if (const uint64_t exchange = exchange_) serverRank_.exchanges.cancel(exchange);
  std::shared_ptr<void> want, subscription;  // let go of without the lock
  {
    const std::lock_guard lock(handles_);
    want.swap(want_);
    subscription.swap(subscription_);
  }
  const std::lock_guard evaluating(evaluating_);
}

Watches::~Watches() {
  for (const auto& [name, watch] : watches_) watch->end();
}

json Watches::add(Request& request, const WatchedCondition& condition) {
  Session& session = request.session();
  const auto watch = std::make_shared<Watch>(session.serverRank(), session.tenant(), session.sharedOutbox(),
                                             queue_, condition);
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
