// SPDX-License-Identifier: Apache-2.0
#include "multiserver/graph/graphs.h"

#include <algorithm>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/space/publication.h"
#include "multiserver/protocol/json.h"
#include "multiserver/rendering/rendering.h"

namespace gxy {

using nlohmann::json;

namespace {

/// On each rank: makes a generation a new object, whose memory is the tenant's.
json adoptHere(ServerRank& serverRank, const json& p) {
  Exchanges::Part part = serverRank.exchanges.join(p.at("exchange").get<uint64_t>());
  auto adopted = std::make_shared<Dataset>();
  agree(part.ranks, [&] {
    const Pin pin =
        serverRank.objects.pin(Key{p.at("key").get<uint64_t>()}, p.at("generation").get<Generation>());
    const auto from = pin.get<Dataset>();
    adopted->file = from->file;
    adopted->array = from->array;
    adopted->radiusArray = from->radiusArray;
    adopted->fields = from->fields;
    adopted->stream = from->stream;
    adopted->color = from->color;
    adopted->partitioning = from->partitioning;
    adopted->volume = from->volume;
    adopted->mesh = from->mesh;
    adopted->geometry = from->geometry;
    adopted->origins = from->origins;
    adopted->time = from->time;
    adopted->provenance = from->provenance;
    adopted->bytes = from->bytes;
    adopted->memory = serverRank.takeMemory(p.at("tenant").get<std::string>(),
                                            p.at("purpose").get<std::string>(), from->bytes);
  });
  const std::string label = "dataset " + inQuotes(p.at("name").get<std::string>());
  Publication publication(serverRank.objects, part.ranks, {{Key{p.at("object").get<uint64_t>()}, 1, label}});
  publication.stage(0, Payload(std::shared_ptr<const Dataset>(std::move(adopted))));
  publication.commit();
  return nullptr;
}

[[noreturn]] void failNoGraph(const std::string& name) {
  throw Error("graph " + inQuotes(name) + ": there is none; `graph.list` names them, `graph.new` makes one");
}

}  // namespace

void checkGraphName(const std::string& name) {
  if (name.empty() || name.size() > 100 || protocol::hasControls(name) || name.find('/') != std::string::npos)
    throw Error("graph " + inQuotes(name) +
                ": expected a name of 1 to 100 bytes without control characters and /");
}

Graphs::Graphs(Registration& registration)
    : services_{registration.serverRank(), renderingOf(registration), {}, [this] { wake(); }} {
  ServerRank& serverRank = registration.serverRank();
  registration.work(
      "graph.adopt", [&serverRank](const Work::Call& call) { return adoptHere(serverRank, call.parameters); },
      Work::Runs::Waiting);
  if (serverRank.rank() != 0) return;
  datasets_ = serverRank.datasets->observe([this](const DatasetEvent& event) { onDataset(event); });
  objects_ = serverRank.observers.subscribe({}, [this](const ObjectEvent& event) {
    if (event.kind != ObjectEvent::Kind::Wanted && event.kind != ObjectEvent::Kind::Dropped) return;
    const bool isWanted = event.kind == ObjectEvent::Kind::Wanted;
    for (const auto& graph : all())
      isWanted ? graph->onWanted({event.key, event.generation}) : graph->onDropped(event.key);
  });
  serverRank.endings.add([this] { end(); });
}

Graphs::~Graphs() { end(); }

void Graphs::end() {
  objects_.end();
  datasets_ = nullptr;
  {
    const std::lock_guard lock(mutex_);
    isEnding_ = true;
    woken_.notify_all();
  }
  if (clock_.joinable()) clock_.join();
  for (const auto& graph : all()) graph->end();
  const std::lock_guard lock(mutex_);
  graphs_.clear();
  shared_.clear();
}

std::vector<std::shared_ptr<Graph>> Graphs::all() const {
  std::vector<std::shared_ptr<Graph>> all;
  const std::lock_guard lock(mutex_);
  for (const auto& [tenant, graphs] : graphs_)
    for (const auto& [name, graph] : graphs) all.push_back(graph);
  return all;
}

std::vector<Graphs::Listed> Graphs::list(const std::string& tenant) const {
  std::vector<Listed> out;
  const std::lock_guard lock(mutex_);
  const auto sharedOf = [&](const std::shared_ptr<Graph>& graph) -> std::optional<Access> {
    const auto found = shared_.find(graph->name());
    if (found == shared_.end() || found->second.graph != graph) return std::nullopt;
    return found->second.access;
  };
  if (const auto own = graphs_.find(tenant); own != graphs_.end())
    for (const auto& [name, graph] : own->second) out.push_back({graph, sharedOf(graph)});
  for (const auto& [name, shared] : shared_)
    if (shared.graph->tenant() != tenant) out.push_back({shared.graph, shared.access});
  return out;
}

// With the lock held.
std::shared_ptr<Graph> Graphs::own(const std::string& tenant, const std::string& name) const {
  const auto graphs = graphs_.find(tenant);
  if (graphs == graphs_.end()) return nullptr;
  const auto found = graphs->second.find(name);
  return found == graphs->second.end() ? nullptr : found->second;
}

std::shared_ptr<Graph> Graphs::get(const std::string& tenant, const std::string& name, Access access) const {
  const std::lock_guard lock(mutex_);
  if (auto graph = own(tenant, name)) return graph;
  const auto shared = shared_.find(name);
  if (shared == shared_.end()) failNoGraph(name);
  if (access == Access::Change && shared->second.access == Access::Look)
    throw Error("graph " + inQuotes(name) + ": it belongs to " + shared->second.graph->tenant() +
                ", who lets others look at it, and not change it");
  return shared->second.graph;
}

void Graphs::publish(const std::string& tenant, const std::string& name, Access access) {
  const std::lock_guard lock(mutex_);
  const auto graph = own(tenant, name);
  if (!graph) failNoGraph(name);
  const auto [shared, isNew] = shared_.try_emplace(name, Shared{graph, access});
  if (!isNew && shared->second.graph != graph)
    throw Error("graph " + inQuotes(name) + ": " + shared->second.graph->tenant() +
                " has published one of this name");
  shared->second.access = access;
}

void Graphs::unpublish(const std::string& tenant, const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto graph = own(tenant, name);
  if (!graph) failNoGraph(name);
  if (const auto found = shared_.find(name); found != shared_.end() && found->second.graph == graph)
    shared_.erase(found);
}

std::pair<std::shared_ptr<Graph>, std::vector<std::string>> Graphs::make(const std::string& tenant,
                                                                         const std::string& name,
                                                                         const json& document,
                                                                         const StateReader& readState) {
  checkGraphName(name);
  const auto graph = std::make_shared<Graph>(services_, tenant, name);
  std::vector<std::string> warnings = graph->setDocument(document, readState);
  try {
    const std::lock_guard lock(mutex_);
    auto& graphs = graphs_[tenant];
    if (isEnding_) throw Error("the server stops");
    if (graphs.contains(name))
      throw Error("graph " + inQuotes(name) + ": there is one, expected a free name");
    if (graphs.size() >= kOfTenant)
      throw Error("graph " + inQuotes(name) + ": there are " + std::to_string(kOfTenant) +
                  " graphs, expected fewer; `graph.drop` one");
    graphs.emplace(name, graph);
    if (!clock_.joinable()) clock_ = std::thread([this] { runClock(); });
  } catch (const Error&) {
    graph->end();
    throw;
  }
  graph->onData();  // that have come while nobody told it
  return {graph, std::move(warnings)};
}

void Graphs::drop(const std::string& tenant, const std::string& name) {
  std::shared_ptr<Graph> graph;
  {
    const std::lock_guard lock(mutex_);
    graph = own(tenant, name);
    if (!graph) failNoGraph(name);
    if (const auto found = shared_.find(name); found != shared_.end() && found->second.graph == graph)
      shared_.erase(found);
  }
  graph->end();
  const std::lock_guard lock(mutex_);
  auto& graphs = graphs_[tenant];
  if (const auto found = graphs.find(name); found != graphs.end() && found->second == graph)
    graphs.erase(found);
  if (graphs.empty()) graphs_.erase(tenant);
}

void Graphs::onDataset(const DatasetEvent& event) {
  if (event.kind == DatasetEvent::Kind::Skipped) return;
  for (const auto& graph : all()) {
    const bool isOwn = event.dataset.ofGraph && event.dataset.name.starts_with(graph->name() + "/");
    if (event.visibleTo(graph->tenant()) && !isOwn) graph->onData();
  }
}

void Graphs::wake() {
  const std::lock_guard lock(mutex_);
  isAwake_ = true;
  woken_.notify_all();
}

// Sleeps while no graph waits for time to pass.
void Graphs::runClock() {
  const auto period = std::min<std::chrono::milliseconds>(services_.serverRank.options.adoptAfter / 10,
                                                          std::chrono::milliseconds(100));
  std::unique_lock lock(mutex_);
  while (!isEnding_) {
    woken_.wait(lock, [this] { return isAwake_ || isEnding_; });
    woken_.wait_for(lock, period, [this] { return isEnding_; });
    if (isEnding_) return;
    isAwake_ = false;
    lock.unlock();
    bool again = false;
    for (const auto& graph : all()) again = graph->tick() || again;
    lock.lock();
    isAwake_ = isAwake_ || again;
  }
}

std::shared_ptr<Graphs> graphsOf(Registration& registration) {
  return registration.shared<Graphs>([&] { return std::make_shared<Graphs>(registration); });
}

}  // namespace gxy
