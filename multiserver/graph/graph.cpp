// SPDX-License-Identifier: Apache-2.0
// What a graph is told.
#include "multiserver/graph/graph.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/scene/dataset_type.h"
#include "multiserver/graph/document_edits.h"
#include "multiserver/protocol/json.h"
#include "multiserver/rendering/cost.h"
#include "multiserver/server/document_reader.h"

namespace gxy {

using nlohmann::json;

Graph::Graph(GraphServices& services, std::string tenant, std::string name)
    : services_(services),
      tenant_(std::move(tenant)),
      name_(std::move(name)),
      flow_(services.serverRank.filters) {}

Graph::~Graph() = default;

void Graph::checkNotEnded() const {
  if (isEnded_) throw Error("graph " + inQuotes(name_) + ": it was dropped");
}

// The document.

std::vector<std::string> Graph::setDocument(const json& document, const StateReader& readState) {
  const std::lock_guard editing(editing_);
  GraphDocument read = readGraphDocument(name_, document, services_.serverRank.filters, withRoom(readState));
  std::vector<std::string> warnings = read.warnings;
  LedgerEntry memory = roomFor(read);
  const std::lock_guard lock(mutex_);
  checkNotEnded();
  commit(std::move(read), std::move(memory), false, nullptr);
  return warnings;
}

json Graph::edit(const json& edits, bool live, const std::optional<EditMark>& mark, const Client& by,
                 const StateReader& readState) {
  const std::lock_guard editing(editing_);
  json now;
  {
    const std::lock_guard lock(mutex_);
    checkNotEnded();
    now = document_.json;
  }
  if (const auto before = mark ? marked_.revisionOf(*mark) : std::nullopt)
    return {{"revision", *before}, {"repeated", true}, {"warnings", json::array()}};
  EditedDocument made = edited(now, edits);
  GraphDocument read =
      readGraphDocument(name_, std::move(made.document), services_.serverRank.filters, withRoom(readState));
  json warnings = read.warnings;
  LedgerEntry memory = roomFor(read);
  const std::lock_guard lock(mutex_);
  checkNotEnded();
  commit(std::move(read), std::move(memory), live,
         {{"event", "graph"}, {"graph", name_}, {"by", by.json()}, {"edits", edits}, {"live", live}},
         made.renamedViews);
  if (mark) marked_.add(*mark, revision_);
  return {{"revision", revision_}, {"inverse", std::move(made.inverse)}, {"warnings", std::move(warnings)}};
}

// Of what a document takes. Outputs that nothing shows have to give way.
LedgerEntry Graph::roomFor(const GraphDocument& document) {
  int64_t bytes = parsingBytes(protocol::dump(document.json));
  for (const auto& [view, look] : document.looks) bytes += bytesOf(look.visualization);
  for (;;) try {
      return services_.serverRank.takeMemory(tenant_, "graph " + name_, bytes);
    } catch (const NoRoom&) {
      if (!giveUpOldest()) throw;
    }
}

// The same of what reading it takes.
StateReader Graph::withRoom(const StateReader& readState) {
  return [this, &readState](std::string_view text, const std::string& what) {
    for (;;) try {
        return readState(text, what);
      } catch (const NoRoom&) {
        if (!giveUpOldest()) throw;
      }
  };
}

// With the lock held, like all that follow here without a lock of their own.
void Graph::commit(GraphDocument document, LedgerEntry memory, bool live, const json& event,
                   const std::vector<std::pair<std::string, std::string>>& renamedViews) {
  try {
    flow_.edit(document.flow, live);
  } catch (const Error& e) {
    const DocumentProblem problem = problemOf(e.what());
    throw Error(problem.path + ": " + problem.text);
  }
  document_ = std::move(document);
  documentMemory_ = std::move(memory);
  for (const auto& renamed : renamedViews) follow(renamed);
  revision_++;
  if (!event.is_null()) {
    json told = event;
    told["revision"] = revision_;
    send(told);
  }
  dropWhatTheDocumentHasNot();
  lookAtData();
  act();
  for (const flow::ViewSpec& view : document_.flow.views) tellNode({flow::NodeId::Kind::View, view.name});
  wantNews();
  viewsChanged();
}

void Graph::dropWhatTheDocumentHasNot() {
  ServerRank& serverRank = services_.serverRank;
  std::erase_if(told_, [&](const auto& item) {
    const auto& [kind, name] = item.first;
    if (kind == flow::NodeId::Kind::Output) return !document_.outputs.contains(name);
    return kind == flow::NodeId::Kind::View ? !document_.looks.contains(name) : !document_.dataset(name);
  });
  std::erase_if(series_, [&](const auto& item) {
    const DatasetSpec* now = document_.dataset(item.first);
    const DatasetSpec& then = item.second.spec;
    return !now || now->filter != then.filter || now->inputs != then.inputs ||
           now->properties != then.properties;
  });
  dropOutputsThatTheDocumentHasNot();
  for (auto it = named_.begin(); it != named_.end();) {
    const DatasetSpec* spec = document_.dataset(it->first);
    if (spec && !spec->filter.empty()) {
      ++it;
      continue;
    }
    serverRank.datasets->unnameOfGraph(tenant_, name_ + "/" + it->first, it->second.second);
    it = named_.erase(it);
  }
  for (auto it = fetched_.begin(); it != fetched_.end();) {
    const DatasetSpec* spec = document_.dataset(it->first);
    if (spec) it->second.spec.color = spec->color;
    if (spec && *spec == it->second.spec) {
      ++it;
      continue;
    }
    stop(*it->second.running);
    it = fetched_.erase(it);
  }
  std::vector<std::string> gone;
  for (const auto& [source, keys] : imported_)
    if (const DatasetSpec* spec = document_.dataset(source); !spec || spec->filename.empty())
      gone.push_back(source);
  for (const std::string& source : gone) dropImported(source);
}

// The name is free at once, for whatever the node is next.
void Graph::dropImported(const std::string& source) {
  const auto imported = imported_.extract(source);
  for (const Key key : imported.mapped()) {
    const std::string name = name_ + "/" + source;
    services_.serverRank.datasets->unnameOfGraph(tenant_, name, key);
    post([this, name, key] { services_.serverRank.datasets->dropOfGraph(tenant_, name, key); });
  }
}

json Graph::describe() const {
  const std::lock_guard lock(mutex_);
  checkNotEnded();
  return {{"graph", name_},
          {"document", document_.json},
          {"revision", revision_},
          {"paused", flow_.isPaused()},
          {"nodes", nodesJson()}};
}

json Graph::summary() const {
  const std::lock_guard lock(mutex_);
  return {{"graph", name_},
          {"revision", revision_},
          {"nodes", document_.flow.datasets.size() + document_.flow.views.size() + document_.outputs.size()},
          {"clients", watchers_.size()},
          {"paused", flow_.isPaused()}};
}

// Who watches, and what they ask for.

void Graph::watch(const Client& client, const std::shared_ptr<Outbox>& outbox) {
  const std::lock_guard lock(mutex_);
  checkNotEnded();
  watchers_[client.session] = {client, outbox};
  sendPresent();
}

void Graph::unwatch(uint64_t session) {
  const std::lock_guard lock(mutex_);
  if (watchers_.erase(session) > 0) sendPresent();
}

void Graph::run(const std::optional<std::string>& node) {
  const std::lock_guard lock(mutex_);
  checkNotEnded();
  node ? flow_.run(*node) : flow_.run();
  act();
}

void Graph::cancel(const std::optional<std::string>& node) {
  const std::lock_guard lock(mutex_);
  checkNotEnded();
  node ? flow_.cancel(*node) : flow_.cancel();
  for (const auto& [source, fetched] : fetched_)
    if (fetched.isUnderWay && (!node || source == *node)) stop(*fetched.running);
  if (!node) {
    for (const auto& [name, job] : due_) flow_.written(name, job.wave);
    due_.clear();
    for (const auto& [name, writing] : writing_) stop(*writing.running);
  }
  act();
}

void Graph::pause() {
  const std::lock_guard lock(mutex_);
  checkNotEnded();
  flow_.pause();
  act();
  wantNews();
}

void Graph::resume() {
  const std::lock_guard lock(mutex_);
  checkNotEnded();
  flow_.resume();
  act();
  wantNews();
}

bool Graph::waitUntilIdle(std::chrono::duration<double> patience, const std::function<void()>& check) {
  const auto until = Clock::now() + std::chrono::duration_cast<Clock::duration>(patience);
  for (;;) {
    check();
    std::unique_lock lock(mutex_);
    checkNotEnded();
    const bool fetches = std::any_of(fetched_.begin(), fetched_.end(),
                                     [](const auto& item) { return item.second.isUnderWay; });
    if (!isBusy() && !fetches && !isLookPosted()) return true;
    if (Clock::now() >= until) return false;
    changed_.wait_for(lock, std::chrono::milliseconds(50));
  }
}

uint64_t Graph::show(const std::string& view, std::function<void()> changed) {
  const std::lock_guard lock(mutex_);
  checkNotEnded();
  const uint64_t window = nextWindow_++;
  windows_[view][window].changed = std::move(changed);
  viewOf_[window] = view;
  left_.erase(view);
  flow_.show(view);
  act();
  wantNews();
  return window;
}

bool Graph::isFollowed(const std::string& view) const {
  const auto windows = windows_.find(view);
  return windows != windows_.end() && std::any_of(windows->second.begin(), windows->second.end(),
                                                  [](const auto& window) { return window.second.follow; });
}

void Graph::setFollow(uint64_t window, bool follow) {
  const std::lock_guard lock(mutex_);
  const std::string& view = viewOf_.at(window);
  windows_.at(view).at(window).follow = follow;
  if (isEnded_) return;
  flow_.show(view, isFollowed(view));
  act();
  wantNews();
}

void Graph::hide(uint64_t window) {
  const std::lock_guard lock(mutex_);
  const std::string view = viewOf_.extract(window).mapped();
  auto& windows = windows_[view];
  windows.erase(window);
  const bool isShown = !windows.empty();
  if (!isShown) windows_.erase(view);
  if (isEnded_ && !isShown) shown_.erase(view);
  if (isEnded_) return;
  if (isShown)
    flow_.show(view, isFollowed(view));
  else
    leave(view);
  act();
  wantNews();
}

// Whoever loads a page anew, or comes back after a break of the connection, finds what was begun.
void Graph::leave(const std::string& view) {
  flow_.show(view, false);
  left_[view] = Clock::now() + services_.serverRank.options.leftViewsFor;
  services_.wake();
}

// Hides the views whose time is over; all, if nothing runs any more.
void Graph::forgetLeft() {
  const auto now = Clock::now();
  for (auto it = left_.begin(); it != left_.end();) {
    if (flow_.isBusy() && now < it->second) {
      ++it;
      continue;
    }
    flow_.hide(it->first);
    shown_.erase(it->first);
    it = left_.erase(it);
  }
}

// Windows on a view go with it where it is renamed.
void Graph::follow(const std::pair<std::string, std::string>& renamed) {
  const auto& [from, to] = renamed;
  auto windows = windows_.extract(from);
  if (windows.empty()) return;
  left_.erase(to);
  for (auto& [number, window] : windows.mapped()) {
    viewOf_[number] = to;
    windows_[to][number] = std::move(window);
  }
  if (auto shown = shown_.extract(from)) shown_[to] = std::move(shown.mapped());
  flow_.hide(from);
  flow_.show(to, isFollowed(to));
}

void Graph::viewsChanged() {
  serial_++;
  for (const auto& [view, windows] : windows_)
    for (const auto& [number, window] : windows) post(window.changed);
}

// Data.

// It and those that observe data need no lock.
void Graph::post(std::function<void()> task) {
  {
    const std::lock_guard lock(tasksMutex_);
    tasks_++;
  }
  services_.serverRank.transport.postWaiting([self = shared_from_this(), task = std::move(task)] {
    try {
      task();
    } catch (const std::exception&) {
      // Ranks do not answer any more, and there is nobody to be told.
    }
    const std::lock_guard lock(self->tasksMutex_);
    self->tasks_--;
    self->tasksEnded_.notify_all();
  });
}

void Graph::onData() {
  {
    const std::lock_guard lock(tasksMutex_);
    if (takesNoTasks_ || std::exchange(lookIsPosted_, true)) return;
  }
  post([this] {
    const std::lock_guard lock(mutex_);
    {
      const std::lock_guard tasks(tasksMutex_);
      lookIsPosted_ = false;
    }
    if (isEnded_) return;
    lookAtData();
    act();
  });
}

bool Graph::isLookPosted() const {
  const std::lock_guard lock(tasksMutex_);
  return lookIsPosted_;
}

// Sees all live sources at one moment, so what was published together comes together.
void Graph::lookAtData() {
  constexpr int kLooks = 8;  // at names whose objects are dropped meanwhile, each time
  Datasets& datasets = *services_.serverRank.datasets;
  const auto isThere = [&](const std::string& name) {
    try {
      datasets.getPinned(tenant_, name);
      return true;
    } catch (const Error&) {
      return false;
    }
  };
  std::vector<std::string> live;
  for (const DatasetSpec& d : document_.flow.datasets)
    if (d.isLive()) live.push_back(d.name);
  for (int look = 0; look < kLooks; look++) {
    std::vector<std::string> names;
    std::copy_if(live.begin(), live.end(), std::back_inserter(names), isThere);
    std::vector<flow::Flow::Update> updates;
    try {
      for (const auto& [d, pin] : datasets.getPinned(tenant_, names)) {
        const auto dataset = pin.get<Dataset>();
        updates.push_back({d.name, {{d.key, d.generation}, typeOf(*dataset), dataset->origins}});
      }
    } catch (const Error&) {
      continue;  // dropped in between
    }
    const std::set<std::string> there(names.begin(), names.end());
    for (const std::string& name : there_)
      if (!there.contains(name)) flow_.dropped(name);
    there_ = there;
    flow_.update(updates);
    return;
  }
  onData();
}

void Graph::onWanted(const flow::SourceGeneration& generation) {
  postUnlessEnding([this, generation] {
    const std::lock_guard lock(mutex_);
    const bool isHeld = std::any_of(heldIds_.begin(), heldIds_.end(),
                                    [&](const auto& item) { return item.second == generation; });
    if (isEnded_ || !isHeld || !wanted_.insert(generation).second) return;
    flow_.wanted(generation);
    act();
    services_.wake();
  });
}

// Rank 0's pin keeps nothing on the other ranks then, so what is pinned is lost. What has been adopted is not.
void Graph::onDropped(Key object) {
  postUnlessEnding([this, object] {
    const std::lock_guard lock(mutex_);
    std::vector<flow::SourceGeneration> lost;
    for (auto it = heldIds_.begin(); it != heldIds_.end();) {
      const auto held = it++;
      if (held->second.object != object || holds_.at(held->first)->isOwned()) continue;
      lost.push_back(held->second);
      wanted_.erase(held->second);
      holds_.erase(held->first);
      heldIds_.erase(held);
    }
    std::vector<flow::NodeKey> evicted;
    for (const auto& [key, output] : outputs_)
      if (output->object && output->object->key() == object) evicted.push_back(key);
    if (isEnded_) return;
    for (const flow::SourceGeneration& generation : lost) flow_.lost(generation);
    for (const flow::NodeKey& key : evicted) {
      carryOut(flow::DropOutput{key});
      flow_.evicted(key);
    }
    if (!lost.empty() || !evicted.empty()) act();
  });
}

void Graph::postUnlessEnding(std::function<void()> task) {
  {
    const std::lock_guard lock(tasksMutex_);
    if (takesNoTasks_) return;
  }
  post(std::move(task));
}

// Sources of data that come by themselves make what somebody waits for.
void Graph::wantNews() {
  std::vector<std::string> names;
  for (const flow::Target& target : flow_.document().targets()) {
    const bool isNeeded = target.id.kind == flow::TargetId::Kind::Output || isFollowed(target.id.name);
    if (!isNeeded || !target.follow || flow_.isPaused()) continue;
    for (size_t source : target.sources)
      if (const DatasetSpec& spec = flow_.document().nodes()[source].spec; spec.isLive())
        names.push_back(spec.name);
  }
  auto wish = names.empty() ? nullptr : services_.serverRank.datasets->want(tenant_, names);
  wish_ = std::move(wish);
}

// Its end.

void Graph::end() {
  const std::lock_guard editing(editing_);
  {
    const std::lock_guard lock(mutex_);
    if (isEnded_) return;
    isEnded_ = true;
    wish_ = nullptr;
    for (const auto& [number, running] : running_) stop(*running);
    for (const auto& [source, fetched] : fetched_) stop(*fetched.running);
    due_.clear();
    for (const auto& [name, writing] : writing_) stop(*writing.running);
    viewsChanged();
    send({{"event", "graph"}, {"graph", name_}, {"revision", revision_}, {"dropped", true}});
    watchers_.clear();
    changed_.notify_all();
  }
  {
    std::unique_lock lock(tasksMutex_);
    takesNoTasks_ = true;
    tasksEnded_.wait(lock, [this] { return tasks_ == 0; });
  }
  release();
}

// Nothing runs any more.
void Graph::release() {
  Datasets& datasets = *services_.serverRank.datasets;
  std::map<std::string, std::pair<flow::NodeKey, Key>> named;
  std::map<std::string, std::set<Key>> imported;
  std::map<flow::NodeKey, std::shared_ptr<const GraphOutput>> outputs;
  {
    const std::lock_guard lock(mutex_);
    named.swap(named_);
    imported.swap(imported_);
    outputs.swap(outputs_);
    unpublish(true);
    series_.clear();
    shown_.clear();
    holds_.clear();
    told_.clear();
    document_ = {};
    flow_.edit(document_.flow);
    flow_.take();
    documentMemory_ = {};
  }
  for (const auto& [node, output] : named) datasets.unnameOfGraph(tenant_, name_ + "/" + node, output.second);
  for (const auto& [source, keys] : imported)
    for (const Key key : keys) datasets.dropOfGraph(tenant_, name_ + "/" + source, key);
  dropUnused(outputs);
}

}  // namespace gxy
