// SPDX-License-Identifier: Apache-2.0
// Names and events; datasets_publish.cpp, datasets_import.cpp and datasets_copy.cpp have the rest.
#include "multiserver/server/datasets.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/analysis/made_geometry.h"
#include "core/comm/error.h"
#include "core/data/mesh_counts.h"
#include "core/scene/json_text.h"
#include "multiserver/protocol/json.h"
#include "multiserver/server/session.h"

namespace gxy {

using nlohmann::json;

namespace {

json point(const glm::dvec3& p) { return json::array({p.x, p.y, p.z}); }

json listed(const std::vector<Origin>& origins) {
  json list = json::array();
  for (const auto& [source, step] : origins) list.push_back({{"source", source}, {"step", step}});
  return list;
}

json described(const Provenance& provenance) {
  json inputs = json::array();
  for (const Provenance::Input& input : provenance.inputs)
    inputs.push_back({{"input", input.input}, {"name", input.name}, {"generation", input.generation}});
  return {{"filter", provenance.filter},
          {"version", provenance.version},
          {"properties", json::parse(provenance.properties)},
          {"inputs", inputs}};
}

[[noreturn]] void failMissing(const std::string& name) {
  throw Error("dataset " + inQuotes(name) + ": there is none that you see; `list` names what there is");
}

[[noreturn]] void failOfGraph(const std::string& name) {
  throw Error("dataset " + inQuotes(name) +
              " is a node of a graph, which alone changes it; expected another name");
}

const char* nameOf(DatasetEvent::Kind kind) {
  constexpr const char* names[] = {"added", "updated", "skipped", "dropped", "renamed"};
  return names[size_t(kind)];
}

}  // namespace

void checkDatasetName(const std::string& name) {
  if (name.empty() || name.size() > 255 || protocol::hasControls(name))
    throw Error("name " + inQuotes(name.substr(0, 40)) +
                ": expected 1 to 255 bytes without control characters");
}

json DatasetEvent::json() const {
  nlohmann::json json{{"event", nameOf(kind)},
                      {"name", dataset.name},
                      {"scope", dataset.scope == Scope::Shared ? "shared" : "private"},
                      {"type", dataset.type},
                      {"generation", dataset.generation}};
  if (kind == Kind::Renamed) json["to"] = newName;
  if (!origin.is_null()) json.update(origin);
  return json;
}

namespace {

// What there is of a mesh, and what is remarkable in it.
json told(const Mesh& mesh) {
  const MeshReport& report = mesh.report;
  json told{{"points", report.points}};
  if (mesh.ofCells) told["values"] = "cells";
  uint64_t cells = 0;
  for (const uint64_t ofType : report.cells) cells += ofType;
  told["cells"] = cells;
  for (const auto& [name, count] : namedCounts(report)) told[name] = count;
  return told;
}

}  // namespace

Datasets::Datasets(ServerRank& serverRank) : serverRank_(serverRank) {
  if (serverRank_.rank() == 0)
    subscription_ =
        serverRank_.observers.subscribe({}, [this](const ObjectEvent& event) { onObject(event); });
}

Datasets::~Datasets() = default;

void Datasets::addWorks() {
  serverRank_.work.add(
      "datasets.import", [this](const Work::Call& call) { return importHere(call.parameters); },
      Work::Runs::Waiting);
  serverRank_.work.add(
      "datasets.copy", [this](const Work::Call& call) { return copyHere(call.parameters); },
      Work::Runs::Waiting);
  serverRank_.work.add("datasets.info", [this](const Work::Call& call) { return infoHere(call.parameters); });
  serverRank_.work.add("datasets.drop", [this](const Work::Call& call) -> json {
    const Key key{call.parameters.at("key").get<uint64_t>()};
    if (serverRank_.objects.contains(key)) serverRank_.objects.drop(key);
    return nullptr;
  });
}

json Datasets::infoHere(const json& parameters) const {
  Pin pin;
  try {
    pin = serverRank_.objects.pin(Key{parameters.at("key").get<uint64_t>()});
  } catch (const Error&) {
    return nullptr;  // dropped meanwhile
  }
  const auto d = pin.get<Dataset>();
  json result{{"bytes", d->bytes}, {"generation", pin.generation()}};
  if (serverRank_.rank() != 0) return result;
  const Box box = d->box();
  const Range range = d->range();
  result["box"] = box.empty() ? json(nullptr) : json::array({point(box.lo), point(box.hi)});
  result["range"] = range.empty() ? json(nullptr) : json::array({range.min, range.max});
  result["components"] = d->components();
  result["partitions"] = d->partitioning->partitions();
  if (!d->file.empty()) {
    result["array"] = d->array;
    if (!d->radiusArray.empty()) result["radius array"] = d->radiusArray;
    result["file"] = d->file;
  }
  if (!d->stream.empty()) result.update({{"stream", d->stream}, {"array", d->array}});
  if (!d->origins.empty()) result["origins"] = listed(d->origins);
  if (!std::isnan(d->time)) result["time"] = d->time;
  if (!d->provenance.filter.empty()) result["provenance"] = described(d->provenance);
  if (d->volume) result["points"] = d->volume->grid.points;
  if (d->mesh) result["mesh"] = told(*d->mesh);
  if (d->geometry) {
    result["primitives"] = d->geometry->primitives;
    if (!d->geometry->fields.empty()) result["fields"] = toldOf(d->geometry->fields);
  }
  return result;
}

json Datasets::info(const NamedDataset& dataset) {
  const std::vector<json> parts = serverRank_.callAll("datasets.info", {{"key", dataset.key.value}});
  json result = parts.at(0);
  int64_t bytes = 0;
  for (const json& part : parts) {
    if (part.is_null()) return nullptr;
    bytes += part.at("bytes").get<int64_t>();
  }
  result["bytes"] = bytes;
  return result;
}

std::pair<NamedDataset, json> Datasets::info(const std::string& tenant, const std::string& name) {
  for (;;) {
    NamedDataset d = get(tenant, name);
    json known = info(d);
    if (!known.is_null()) return {std::move(d), std::move(known)};
    // Dropped after the look at its name, which means another dataset by now, or none.
    if (const auto now = find(tenant, name); now && now->key == d.key)
      throw Error("dataset " + inQuotes(name) + ": it is not on all ranks");
  }
}

Generation Datasets::generationOf(Key key) const {
  try {
    return serverRank_.objects.pin(key).generation();
  } catch (const Error&) {
    return 0;  // dropped meanwhile
  }
}

json Datasets::originOf(const Dataset& dataset) {
  if (dataset.stream.empty()) return nullptr;
  json origin{{"stream", dataset.stream}, {"step", dataset.origins.front().step}};
  if (!std::isnan(dataset.time)) origin["time"] = dataset.time;
  return origin;
}

json Datasets::originOf(Key key) const {
  try {
    return originOf(*serverRank_.objects.pin(key).get<Dataset>());
  } catch (const Error&) {
    return nullptr;  // dropped meanwhile
  }
}

NamedDataset Datasets::named(const std::string& name, Scope scope, const DirectoryEntry& e) const {
  return {e.key, name, scope, e.type, e.owner, e.readOnly, generationOf(e.key), e.ofGraph};
}

std::vector<NamedDataset> Datasets::list(const std::string& tenant) const {
  std::vector<NamedDataset> all;
  for (const Directory::Listed& l : serverRank_.directory.list(tenant))
    all.push_back(named(l.name, l.scope, l.entry));
  return all;
}

std::optional<NamedDataset> Datasets::find(const std::string& tenant, const std::string& name) const {
  const auto found = serverRank_.directory.find(tenant, std::span(&name, 1)).front();
  if (!found) return std::nullopt;
  return named(name, found->scope, found->entry);
}

NamedDataset Datasets::get(const std::string& tenant, const std::string& name) const {
  if (auto found = find(tenant, name)) return *std::move(found);
  failMissing(name);
}

std::pair<NamedDataset, Pin> Datasets::getPinned(const std::string& tenant, const std::string& name) const {
  return std::move(getPinned(tenant, std::span(&name, 1)).front());
}

std::vector<std::pair<NamedDataset, Pin>> Datasets::getPinned(const std::string& tenant,
                                                              std::span<const std::string> names) const {
  std::vector<NamedDataset> datasets;
  // A name is taken away before its object is dropped, so what has one is there.
  std::vector<Pin> pins = serverRank_.objects.pin([&] {
    std::vector<Key> keys;
    const auto all = serverRank_.directory.find(tenant, names);
    for (size_t i = 0; i < names.size(); i++) {
      if (!all[i]) failMissing(names[i]);
      const auto& [name, scope, entry] = *all[i];
      datasets.push_back({entry.key, name, scope, entry.type, entry.owner, entry.readOnly, 0, entry.ofGraph});
      keys.push_back(entry.key);
    }
    return keys;
  });
  std::vector<std::pair<NamedDataset, Pin>> pinned;
  for (size_t i = 0; i < pins.size(); i++) {
    datasets[i].generation = pins[i].generation();
    pinned.emplace_back(std::move(datasets[i]), std::move(pins[i]));
  }
  return pinned;
}

void Datasets::pin(const std::string& tenant, const std::vector<std::string>& names,
                   PinnedData& pinned) const {
  std::vector<std::string> missing;
  for (const std::string& name : names)
    if (!pinned.contains(name)) missing.push_back(name);
  auto all = getPinned(tenant, missing);
  for (size_t i = 0; i < missing.size(); i++) pinned.insert_or_assign(missing[i], std::move(all[i]));
}

std::optional<NamedDataset> Datasets::mayName(const std::string& tenant, const std::string& name, Scope scope,
                                              bool ofGraph) const {
  const auto entry = serverRank_.directory.find(tenant, name, scope);
  if (!entry) return std::nullopt;
  if (entry->ofGraph && !ofGraph) failOfGraph(name);
  if (!entry->ofGraph && ofGraph)
    throw Error("dataset " + inQuotes(name) +
                " is not of the graph, expected another name for it or for the graph's node");
  if (entry->readOnly && entry->owner != tenant)
    throw Error("dataset " + inQuotes(name) + " belongs to " + entry->owner +
                " and is read-only, expected a name that is free or your own");
  return named(name, scope, *entry);
}

void Datasets::nameOfGraph(const std::string& tenant, const std::string& name, Key key, DatasetType type) {
  std::optional<DirectoryEntry> now;
  do {
    now = serverRank_.directory.find(tenant, name, Scope::Private);
    if (now && (!now->ofGraph || now->key == key)) return;
  } while (!serverRank_.directory.bindIf(name, now, {key, nameOf(type), tenant, false, true}));
  const auto kind = now ? DatasetEvent::Kind::Updated : DatasetEvent::Kind::Added;
  tell({kind, {key, name, Scope::Private, nameOf(type), tenant, false, 1, true}, {}, {}});
}

bool Datasets::publishOfGraph(const std::string& tenant, const std::string& name, Key key, DatasetType type,
                              Key present) {
  std::optional<DirectoryEntry> now;
  do {
    if (const auto known = find(tenant, name); known && known->scope == Scope::Shared) return false;
    now = serverRank_.directory.find(tenant, name, Scope::Private);
    if (now && now->ofGraph && now->key == key) return true;
    if (now && (!now->ofGraph || now->key != present)) return false;
  } while (!serverRank_.directory.bindIf(name, now, {key, nameOf(type), tenant, false, true}));
  const auto kind = now ? DatasetEvent::Kind::Updated : DatasetEvent::Kind::Added;
  tell({kind, {key, name, Scope::Private, nameOf(type), tenant, false, 1, true}, {}, {}});
  return true;
}

void Datasets::unnameOfGraph(const std::string& tenant, const std::string& name, Key key) {
  const auto now = serverRank_.directory.find(tenant, name, Scope::Private);
  if (!now || !now->ofGraph || now->key != key) return;
  if (!serverRank_.directory.removeIf(tenant, name, *now)) return;
  tell({DatasetEvent::Kind::Dropped, named(name, Scope::Private, *now), {}, {}});
}

void Datasets::dropObject(Key key) {
  {
    const std::lock_guard lock(mutex_);
    names_.erase(key);
    for (auto& [tenant, keys] : newest_) std::erase(keys, key);
  }
  serverRank_.callAll("datasets.drop", {{"key", key.value}});
}

void Datasets::drop(const std::string& tenant, const std::string& name) {
  Key key;
  {
    const std::lock_guard naming(naming_);
    if (endPublishingOf(tenant, name) && !find(tenant, name)) return;
    const NamedDataset dataset = get(tenant, name);
    if (dataset.ofGraph) failOfGraph(name);
    serverRank_.directory.remove(tenant, name, dataset.scope);
    key = dataset.key;
    tell({DatasetEvent::Kind::Dropped, dataset, {}, {}});
  }
  dropObject(key);
}

void Datasets::dropOfGraph(const std::string& tenant, const std::string& name, Key key) {
  {
    const std::lock_guard naming(naming_);
    unnameOfGraph(tenant, name, key);
  }
  dropObject(key);
}

void Datasets::rename(const std::string& tenant, const std::string& name, const std::string& newName) {
  checkDatasetName(newName);
  const std::lock_guard naming(naming_);
  const NamedDataset d = get(tenant, name);
  if (d.ofGraph) failOfGraph(name);
  if (find(tenant, newName))
    throw Error("rename: the name " + inQuotes(newName) + " is in use, expected a free one");
  if (d.scope == Scope::Shared && d.owner != tenant)
    throw Error("rename: " + inQuotes(name) + " belongs to " + d.owner + ", expected a dataset of your own");
  serverRank_.directory.remove(tenant, name, d.scope);
  serverRank_.directory.bind(newName, d.scope, {d.key, d.type, d.owner, d.readOnly});
  {
    const std::lock_guard lock(mutex_);
    names_[d.key].first = newName;
  }
  tell({DatasetEvent::Kind::Renamed, d, newName, {}});
}

void Datasets::move(const std::string& tenant, const std::string& name, Scope to, bool readOnly) {
  const std::lock_guard naming(naming_);
  const Scope from = to == Scope::Shared ? Scope::Private : Scope::Shared;
  const auto entry = serverRank_.directory.find(tenant, name, from);
  NamedDataset d = entry ? named(name, from, *entry) : get(tenant, name);
  if (d.ofGraph) failOfGraph(name);
  if (d.owner != tenant)
    throw Error("dataset " + inQuotes(name) + " belongs to " + d.owner + ", expected one of your own");
  if (!entry)
    throw Error("dataset " + inQuotes(name) + " is " + (to == Scope::Shared ? "shared" : "private") +
                " already");
  if (serverRank_.directory.find(tenant, name, to))
    throw Error("the name " + inQuotes(name) + " is in use there, expected a free one");
  serverRank_.directory.bind(name, to, {d.key, d.type, d.owner, readOnly});
  {
    const std::lock_guard lock(mutex_);
    names_[d.key].second = to;
  }
  serverRank_.directory.remove(tenant, name, from);
  tell({DatasetEvent::Kind::Dropped, d, {}, {}});
  d.scope = to;
  d.readOnly = readOnly;
  tell({DatasetEvent::Kind::Added, d, {}, {}});
}

Generation Datasets::wait(Request& request, const std::string& name, std::optional<Generation> generation,
                          double seconds) {
  using namespace std::chrono;
  const std::string tenant = request.session().tenant();
  const auto wish = want(tenant, {name});
  const auto now = find(tenant, name);
  const Generation wanted = generation ? *generation : now ? now->generation + 1 : 1;
  const auto until = steady_clock::now() + duration_cast<steady_clock::duration>(duration<double>(seconds));
  request.onCancel([this] {
    const std::lock_guard lock(mutex_);
    changed_.notify_all();
  });
  for (;;) {
    const auto found = find(tenant, name);
    const bool isAnother = found && now && !generation && found->key != now->key;
    if (isAnother || (found && found->generation >= wanted)) return found->generation;
    request.check();
    if (steady_clock::now() >= until)
      throw Error("wait: " + inQuotes(name) + " has no generation " + std::to_string(wanted) + " after " +
                  numberText(seconds) + " s");
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, std::min(until, steady_clock::now() + milliseconds(200)));
  }
}

std::shared_ptr<void> Datasets::want(const std::string& tenant, const std::vector<std::string>& names) {
  const std::vector<std::string> all = names.empty() ? std::vector<std::string>{{}} : names;
  const std::lock_guard lock(mutex_);
  for (const std::string& name : all) wishes_[name][tenant]++;
  return {this, [tenant, all](Datasets* self) {
            const std::lock_guard again(self->mutex_);
            for (const std::string& name : all) {
              auto& tenants = self->wishes_[name];
              if (--tenants[tenant] == 0) tenants.erase(tenant);
              if (tenants.empty()) self->wishes_.erase(name);
            }
          }};
}

bool Datasets::wanted(const std::string& tenant, Scope scope, const std::string& name) const {
  const std::lock_guard lock(mutex_);
  for (const std::string& wish : {name, std::string()}) {
    const auto tenants = wishes_.find(wish);
    if (tenants != wishes_.end() && (scope == Scope::Shared || tenants->second.count(tenant) > 0))
      return true;
  }
  return false;
}

std::shared_ptr<void> Datasets::observe(Observer observer) {
  const std::lock_guard lock(mutex_);
  const uint64_t id = nextObserver_++;
  observers_[id] = std::make_shared<Observer>(std::move(observer));
  return {nullptr, [this, id](void*) {
            const std::lock_guard lock(mutex_);
            observers_.erase(id);
          }};
}

void Datasets::tell(const DatasetEvent& event) {
  std::vector<std::shared_ptr<Observer>> observers;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [id, observer] : observers_) observers.push_back(observer);
    changed_.notify_all();
  }
  for (const auto& observer : observers) (*observer)(event);
}

// New generations come from whoever publishes them.
void Datasets::onObject(const ObjectEvent& event) {
  if (event.kind != ObjectEvent::Kind::Updated && event.kind != ObjectEvent::Kind::Skipped) return;
  std::unique_lock lock(mutex_);
  const auto at = names_.find(event.key);
  if (at == names_.end()) return;
  const auto [name, scope] = at->second;
  lock.unlock();
  std::optional<NamedDataset> dataset;
  if (scope == Scope::Shared) {
    if (const auto entry = serverRank_.directory.find({}, name); entry && entry->key == event.key)
      dataset = named(name, scope, *entry);
  } else {
    std::string owner;
    {
      const std::lock_guard again(mutex_);
      for (const auto& [tenant, keys] : newest_)
        if (std::find(keys.begin(), keys.end(), event.key) != keys.end()) owner = tenant;
    }
    if (const auto entry = serverRank_.directory.find(owner, name); entry && entry->key == event.key)
      dataset = named(name, scope, *entry);
  }
  if (!dataset) return;
  dataset->generation = event.generation;
  const bool updated = event.kind == ObjectEvent::Kind::Updated;
  tell({updated ? DatasetEvent::Kind::Updated : DatasetEvent::Kind::Skipped,
        *dataset,
        {},
        updated ? originOf(event.key) : json()});
}

}  // namespace gxy
