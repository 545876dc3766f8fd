// SPDX-License-Identifier: Apache-2.0
// What a graph's Flow asks for, carried out with the ranks.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/scene/dataset_type.h"
#include "multiserver/graph/graph.h"

namespace gxy {

using nlohmann::json;

Graph::Failure Graph::failureOf(const std::string& text) {
  int rank = 0, size = 0;
  if (std::sscanf(text.c_str(), "rank %d: %n", &rank, &size) == 1 && size > 0)
    return {text.substr(size_t(size)), rank};
  return {text};
}

// Functions here are called with the lock held, but for adopt(), fetch(), evaluate(), giveUpOldest() and dropUnused(), which wait.

void Graph::act() {
  forgetLeft();
  for (std::vector<flow::Action> actions = flow_.take(); !actions.empty(); actions = flow_.take()) {
    for (const flow::Action& action : actions) try {
        std::visit([this](const auto& a) { carryOut(a); }, action);
      } catch (const std::exception& e) {
        // The Flow waits for no answer that will not come, and those that follow are carried out all the same.
        couldNot(action, textOf(e));
      }
    forgetLeft();
  }
  changed_.notify_all();
}

void Graph::couldNot(const flow::Action& action, const std::string& text) {
  if (const auto* start = std::get_if<flow::StartEvaluation>(&action)) {
    running_.erase(start->evaluation);
    flow_.failed(start->evaluation, text, -1);
  } else if (const auto* fetched = std::get_if<flow::FetchSource>(&action)) {
    fetched_.erase(fetched->source);
    flow_.sourceFailed(fetched->source, text, -1);
  } else if (const auto* adopted = std::get_if<flow::AdoptGeneration>(&action)) {
    flow_.refused(adopted->hold, text);
  } else if (const auto* pinned = std::get_if<flow::PinGeneration>(&action)) {
    flow_.lost(pinned->data);
  }
}

void Graph::carryOut(const flow::PinGeneration& action) {
  const auto& [object, generation] = action.data;
  try {
    Pin pin = services_.serverRank.objects.pin(object, generation);
    const auto dataset = pin.get<Dataset>();
    NamedDataset shown{object,  action.source, Scope::Private, nameOf(typeOf(*dataset)),
                       tenant_, false,         generation};
    if (const auto found = services_.serverRank.datasets->find(tenant_, action.source))
      shown.owner = found->owner;
    holds_[action.hold] = std::make_shared<KeptData>(std::move(shown), std::move(pin));
    heldIds_[action.hold] = action.data;
  } catch (const Error&) {
    flow_.lost(action.data);
  }
}

void Graph::carryOut(const flow::ReleaseGeneration& action) {
  const auto found = heldIds_.find(action.hold);
  if (found == heldIds_.end()) return;
  wanted_.erase(found->second);
  heldIds_.erase(found);
  holds_.erase(action.hold);
}

void Graph::carryOut(const flow::AdoptGeneration& action) {
  const auto found = holds_.find(action.hold);
  if (found == holds_.end()) return;
  post([this, hold = action.hold, kept = found->second] { adopt(hold, kept); });
}

void Graph::adopt(uint64_t hold, const std::shared_ptr<KeptData>& kept) {
  ServerRank& serverRank = services_.serverRank;
  std::shared_ptr<OwnedObject> object;
  std::string refused;
  try {
    const auto exchange = serverRank.exchanges.begin(Asker{});
    const Key key = serverRank.keys.next();
    serverRank.callAll("graph.adopt", {{"exchange", *exchange},
                                       {"key", kept->shown().key.value},
                                       {"generation", kept->shown().generation},
                                       {"object", key.value},
                                       {"name", kept->shown().name},
                                       {"tenant", tenant_},
                                       {"purpose", "graph " + name_}});
    object = std::make_shared<OwnedObject>(serverRank, key);
  } catch (const std::exception& e) {
    refused = textOf(e);
  }
  const std::lock_guard lock(mutex_);
  const auto held = heldIds_.find(hold);
  if (isEnded_ || held == heldIds_.end()) return;
  if (object) {
    kept->adopt(std::move(object));
    wanted_.erase(held->second);
    flow_.adopted(hold);
  } else {
    flow_.refused(hold, refused);
  }
  act();
}

void Graph::carryOut(const flow::FetchSource& action) {
  const DatasetSpec* spec = document_.dataset(action.source);
  if (!spec) return;
  auto running = std::make_shared<Running>(action.source);
  fetched_[action.source] = {*spec, true, running};
  post([this, fetched = *spec, running] { fetch(fetched, running); });
}

void Graph::fetch(const DatasetSpec& spec, const std::shared_ptr<Running>& running) {
  Datasets& datasets = *services_.serverRank.datasets;
  Datasets::Import what;
  what.specs = {spec};
  what.specs[0].name = name_ + "/" + spec.name;
  what.ofGraph = true;
  Asker asker;
  asker.check = [running] {
    if (running->isCancelled) throw Error("cancelled");
  };
  std::optional<Key> published;
  std::optional<flow::SourceData> data;
  std::string error;
  try {
    const DatasetDraft made = datasets.import(tenant_, asker, begunOf(running), what).datasets.at(0);
    published = made.key;
    const auto dataset = services_.serverRank.objects.pin(made.key, made.generation).get<Dataset>();
    data = flow::SourceData{{made.key, made.generation}, typeOf(*dataset), dataset->origins};
  } catch (const std::exception& e) {
    error = textOf(e);
  }
  const std::lock_guard lock(mutex_);
  if (published) {
    std::set<Key>& keys = imported_[spec.name];
    std::erase_if(keys, [&](Key key) { return !services_.serverRank.objects.contains(key); });
    keys.insert(*published);
    const DatasetSpec* now = document_.dataset(spec.name);
    if (!now || now->filename.empty()) dropImported(spec.name);
  }
  const auto found = fetched_.find(spec.name);
  if (isEnded_ || found == fetched_.end() || found->second.running != running) return;
  found->second.isUnderWay = false;
  const Failure failure = failureOf(error);
  if (data)
    flow_.update(spec.name, *data);
  else
    flow_.sourceFailed(spec.name, failure.text, failure.rank);
  act();
}

// Between its two lines, begunOf() may come: whoever is second tells the ranks.
void Graph::stop(Running& running) {
  running.isCancelled = true;
  if (const uint64_t exchange = running.exchange) services_.serverRank.exchanges.cancel(exchange);
}

std::function<void(uint64_t)> Graph::begunOf(const std::shared_ptr<Running>& running) {
  return [this, running](uint64_t exchange) {
    running->exchange = exchange;
    if (running->isCancelled) services_.serverRank.exchanges.cancel(exchange);
  };
}

void Graph::carryOut(const flow::StartEvaluation& action) {
  const auto isThere = [this](const GraphOutput& output) {
    return !output.object || services_.serverRank.objects.contains(output.object->key());
  };
  if (auto output = services_.outputs.find(tenant_, action.key); output && isThere(*output)) {
    const flow::Made made = output->made;
    outputs_[action.key] = std::move(output);
    return flow_.finished(action.evaluation, made);
  }
  auto running = std::make_shared<Running>(action.node);
  running_[action.evaluation] = running;
  post([this, action, running] { evaluate(action, running); });
}

void Graph::carryOut(const flow::CancelEvaluation& action) {
  if (const auto found = running_.find(action.evaluation); found != running_.end()) stop(*found->second);
}

Asker Graph::askerFor(uint64_t evaluation, const std::shared_ptr<Running>& running) {
  Asker asker;
  asker.check = [running] {
    if (running->isCancelled) throw Error("cancelled");
  };
  struct Progress {
    std::mutex mutex;
    Clock::time_point at{};
    int64_t done = 0, of = 0;
    std::string text;
    bool isPosted = false;
  };
  const auto progress = std::make_shared<Progress>();
  // It is called with locks of others, so the graph is told by a task.
  asker.progress = [this, evaluation, progress](int64_t done, int64_t of, const std::string& text,
                                                bool phase) {
    constexpr std::chrono::milliseconds kBetween{50};
    const std::lock_guard lock(progress->mutex);
    progress->done = done;
    progress->of = of;
    progress->text = text;
    const auto now = Clock::now();
    if (progress->isPosted || (!phase && now < progress->at + kBetween)) return;
    progress->at = now;
    progress->isPosted = true;
    services_.serverRank.transport.postWaiting([self = shared_from_this(), evaluation, progress] {
      int64_t toldDone = 0, toldOf = 0;
      std::string told;
      {
        const std::lock_guard again(progress->mutex);
        progress->isPosted = false;
        toldDone = progress->done;
        toldOf = progress->of;
        told = progress->text;
      }
      const std::lock_guard graph(self->mutex_);
      if (self->isEnded_) return;
      self->flow_.progress(evaluation, double(toldDone), double(toldOf), told);
      self->act();
    });
  };
  return asker;
}

std::shared_ptr<KeptData> Graph::keptSource(const flow::SourceGeneration& id) const {
  for (const auto& [hold, held] : heldIds_)
    if (held == id) return holds_.at(hold);
  return nullptr;
}

std::vector<FilterRuns::Evaluation::Source> Graph::sourcesOf(const flow::StartEvaluation& action) const {
  std::vector<FilterRuns::Evaluation::Source> sources;
  const std::lock_guard lock(mutex_);
  for (const auto& input : action.inputs)
    for (const auto& item : input.items) {
      ObjectGeneration where;
      if (const auto* id = std::get_if<flow::SourceGeneration>(&item.data)) {
        const auto kept = keptSource(*id);
        if (!kept) throw Error("dataset " + inQuotes(item.node) + ": its data are gone");
        where = kept->where();
      } else {
        const auto output = outputs_.find(std::get<flow::NodeKey>(item.data));
        if (output == outputs_.end() || !output->second->object)
          throw Error("dataset " + inQuotes(item.node) + ": its data are gone");
        where = {output->second->object->key(), 1};
      }
      sources.push_back(
          {input.input, item.node, where, services_.serverRank.objects.pin(where.key, where.generation)});
    }
  return sources;
}

void Graph::evaluate(const flow::StartEvaluation& action, const std::shared_ptr<Running>& running) {
  ServerRank& serverRank = services_.serverRank;
  FilterRuns::Evaluation what;
  what.tenant = tenant_;
  what.label = "dataset " + inQuotes(name_ + "/" + action.node);
  what.purpose = "graph " + name_ + "/" + action.node;
  what.filter = action.filter;
  what.properties = action.properties;
  StepAndTime at;
  what.sources = [&] {
    auto sources = sourcesOf(action);
    for (const auto& source : sources) {
      const auto dataset = source.pin.get<Dataset>();
      at.step = std::max(at.step, newestStep(*dataset));
      if (!std::isnan(dataset->time)) at.time = dataset->time;
    }
    return sources;
  };
  what.begun = begunOf(running);
  const auto begin = Clock::now();
  std::optional<FilterRuns::Evaluated> made;
  std::string error;
  for (bool again = true; again;) {
    again = false;
    try {
      made = serverRank.filterRuns->evaluate(askerFor(action.evaluation, running), what);
    } catch (const NoRoom& e) {
      error = e.what();
      running->exchange = 0;
      again = !running->isCancelled && giveUpOldest();
    } catch (const std::exception& e) {
      error = textOf(e);
    }
  }
  std::shared_ptr<GraphOutput> output;
  if (made) {
    output = std::make_shared<GraphOutput>();
    output->type = made->type;
    output->told = std::move(made->told);
    output->made.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    output->made.bytes = made->bytes;
    if (made->key.valid()) output->object = std::make_shared<OwnedObject>(serverRank, made->key);
  }
  const std::lock_guard lock(mutex_);
  running_.erase(action.evaluation);
  if (isEnded_) return;
  if (output) {
    output->made.generation = ++generations_[action.node];
    services_.outputs.add(tenant_, action.key, output);
    outputs_[action.key] = output;
    keepTold(action.node, *output, at);
    flow_.finished(action.evaluation, output->made);
    // Also where the node has a newer key by now.
    if (!running->isCancelled) giveName(action.node, action.key);
  } else if (running->isCancelled) {
    flow_.cancelled(action.evaluation);
  } else {
    const Failure failure = failureOf(error);
    flow_.failed(action.evaluation, failure.text, failure.rank);
  }
  act();
}

// Gives up the output that was used longest ago, of those that nobody needs. Without the lock.
bool Graph::giveUpOldest() {
  std::map<flow::NodeKey, std::shared_ptr<const GraphOutput>> gone;
  {
    const std::lock_guard lock(mutex_);
    if (isEnded_) return false;
    gone = outputs_;
    if (!flow_.makeRoom()) return false;
    act();
    std::erase_if(gone, [this](const auto& item) { return outputs_.contains(item.first); });
  }
  dropUnused(gone);
  return true;
}

// Waits for the ranks where no other graph and no view has an output. The others are dropped when the last of these lets go.
void Graph::dropUnused(const std::map<flow::NodeKey, std::shared_ptr<const GraphOutput>>& outputs) {
  for (const auto& [key, output] : outputs)
    if (output->object && services_.outputs.removeIfUnused(tenant_, key, output)) output->object->drop();
}

void Graph::carryOut(const flow::DropOutput& action) {
  for (auto it = named_.begin(); it != named_.end();) {
    if (it->second.first != action.key) {
      ++it;
      continue;
    }
    services_.serverRank.datasets->unnameOfGraph(tenant_, name_ + "/" + it->first, it->second.second);
    it = named_.erase(it);
  }
  outputs_.erase(action.key);
}

std::vector<Graph::ShownItem> Graph::itemsOf(const flow::ShowData& action,
                                             const std::vector<ShownItem>& known) const {
  std::vector<ShownItem> items;
  for (const flow::ShownData& data : action.data) {
    const auto before = std::find_if(known.begin(), known.end(), [&](const ShownItem& item) {
      return item.node == data.node && item.data == data.data;
    });
    std::shared_ptr<const KeptData> kept;
    if (const auto* id = std::get_if<flow::SourceGeneration>(&data.data)) {
      kept = keptSource(*id);
    } else if (before != known.end()) {
      kept = before->kept;
    } else if (const auto found = outputs_.find(std::get<flow::NodeKey>(data.data));
               found != outputs_.end() && found->second->object) {
      const GraphOutput& output = *found->second;
      kept = std::make_shared<KeptData>(
          NamedDataset{output.object->key(), data.node, Scope::Private, nameOf(output.type), tenant_, false,
                       output.made.generation},
          output.object);
    }
    if (kept) items.push_back({data.node, data.data, std::move(kept)});
  }
  return items;
}

void Graph::carryOut(const flow::ShowData& action) {
  if (action.target.kind == flow::TargetId::Kind::Output) return carryOut(action, itemsOf(action, {}));
  if (action.target.kind != flow::TargetId::Kind::View) return;
  Shown& shown = shown_[action.target.name];
  shown.items = itemsOf(action, shown.items);
  shown.isHeld = false;
  const std::string before = std::exchange(shown.failure, failureOf(shown.items));
  shown.text.clear();
  for (const flow::Problem& problem : action.problems)
    if (shown.text.empty()) shown.text = inQuotes(problem.node) + ": " + problem.text;
  if (shown.failure != before) tellNode({flow::NodeId::Kind::View, action.target.name});
  viewsChanged();
}

void Graph::carryOut(const flow::HoldPicture& action) {
  if (action.target.kind == flow::TargetId::Kind::Output) return stopOutput(action.target.name);
  if (action.target.kind != flow::TargetId::Kind::View) return;
  Shown& shown = shown_[action.target.name];
  shown.items.clear();
  shown.failure.clear();
  shown.isHeld = true;
  shown.text = "held picture: " + action.text;
  viewsChanged();
}

// The name GRAPH/NODE means what the node was made last, or what it has found again.
void Graph::giveName(const std::string& node, const flow::NodeKey& key) {
  const auto output = outputs_.find(key);
  const DatasetSpec* spec = document_.dataset(node);
  if (output == outputs_.end() || !output->second->object || !spec || spec->filter.empty()) return;
  const Key object = output->second->object->key();
  services_.serverRank.datasets->nameOfGraph(tenant_, name_ + "/" + node, object, output->second->type);
  named_[node] = {key, object};
}

void Graph::carryOut(const flow::ChangeState& action) {
  if (action.node.kind == flow::NodeId::Kind::Dataset && action.state.output)
    giveName(action.node.name, *action.state.output);
  tellNode(action.node);
}

}  // namespace gxy
