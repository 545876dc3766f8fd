// SPDX-License-Identifier: Apache-2.0
// Files become datasets on all ranks, together.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>

#include "core/comm/error.h"
#include "core/comm/wire.h"
#include "core/data/bricks.h"
#include "core/data/geometry_bytes.h"
#include "core/io/automatic_partitioning.h"
#include "core/io/import_geometry.h"
#include "core/io/import_volume.h"
#include "core/scene/json_text.h"
#include "multiserver/server/datasets.h"
#include "multiserver/server/session.h"

namespace gxy {

using nlohmann::json;

namespace {

GeometryKind kindOf(DatasetType type) {
  if (type == DatasetType::Particles) return GeometryKind::Particles;
  return type == DatasetType::PathLines ? GeometryKind::PathLines : GeometryKind::Triangles;
}

// Bytes that this rank holds of a volume while it is read.
int64_t bytesToCome(const VolumeFile& file, const Partitioning& partitioning, int rank) {
  const size_t each = file.bytesPerPoint() + size_t(file.heldPerPoint);
  size_t points = 0, largest = 0;
  for (const int p : partitioning.owned(rank)) {
    const size_t block = Bricks(extentOf(file.grid, partitioning.box(p), kGhostLayers).points).count();
    points += block;
    largest = std::max(largest, block);
  }
  const bool becomesFloat = bytesOf(file.array.type) > sizeof(float);  // block by block
  return int64_t(points * each +
                 (becomesFloat ? largest * sizeof(float) * size_t(file.array.components) : 0));
}

bool holds(const Box& outer, const Box& inner) {
  for (int a = 0; a < 3; a++)
    if (inner.lo[a] < outer.lo[a] || inner.hi[a] > outer.hi[a]) return false;
  return true;
}

json specToJson(const DatasetSpec& d) {
  return {{"name", d.name},
          {"type", int(d.type)},
          {"file", d.filename},
          {"array", d.array},
          {"radius array", d.radiusArray},
          {"color", {d.color.r, d.color.g, d.color.b, d.color.a}}};
}

Bytes written(const Partitioning& p) {
  std::vector<int32_t> owners;
  for (int i = 0; i < p.partitions(); i++) owners.push_back(p.owner(i));
  Writer w;
  for (int a = 0; a < 3; a++) w.write(p.faces(a));
  return w.write(p.cellPartition()).write(owners).take();
}

Partitioning readPartitioning(std::span<const std::byte> message) {
  Reader r(message, "partitioning");
  std::array<std::vector<double>, 3> faces;
  for (auto& f : faces) f = r.readVector<double>();
  auto cells = r.readVector<int32_t>(), owners = r.readVector<int32_t>();
  return {std::move(faces), std::move(cells), std::move(owners)};
}

}  // namespace

std::shared_ptr<const Partitioning> Datasets::partitioningFor(const json& p, const Box& data,
                                                              const Grid* grid) const {
  std::shared_ptr<const Partitioning> like;
  std::vector<Key> candidates;
  {
    const std::lock_guard lock(mutex_);
    if (const auto asked = like_.find(p.at("exchange").get<uint64_t>()); asked != like_.end())
      like = asked->second;
    if (const auto own = newest_.find(p.at("tenant").get<std::string>()); own != newest_.end())
      candidates = own->second;
  }
  if (like) {
    if (!data.empty() && !holds(like->domain(), data))
      throw Error("import: the data reach beyond the domain of the partitioning that they were to share");
    return like;
  }
  while (!p.at("new").get<bool>() && !like && !candidates.empty()) {
    try {
      like = node_.objects.pin(candidates.back()).get<Dataset>()->partitioning;
    } catch (const Error&) {
      // dropped meanwhile
    }
    candidates.pop_back();
  }
  if (like && holds(like->domain(), data)) return like;
  return automaticPartitioning(data, grid, {}, node_.ranks());
}

// Every rank: reads, agrees on a partitioning, imports. All ranks make the same exchanges, whatever fails: each step that
// can fail on one of them is inside agree().
json Datasets::importHere(const json& p) {
  const auto exchange = p.at("exchange").get<uint64_t>();
  const auto tenant = p.at("tenant").get<std::string>();
  const json& specs = p.at("datasets");
  const ReadScope inside = node_.folders.reading();
  Exchanges::Part part = node_.exchanges.join(exchange);
  RankCollectives& ranks = part.ranks;
  const ReadWatch watch([&] { ranks.check(); });

  std::vector<std::shared_ptr<Dataset>> made;
  std::vector<DatasetType> types;
  agree(ranks, [&] {
    for (const json& s : specs) {
      auto d = std::make_shared<Dataset>();
      types.push_back(DatasetType(s.at("type").get<int>()));
      d->file = node_.folders.dataToRead(s.at("file").get<std::string>());
      d->array = s.at("array").get<std::string>();
      d->radiusArray = s.at("radius array").get<std::string>();
      d->origins = {{s.at("key").get<uint64_t>(), s.at("generation").get<int64_t>()}};
      for (int c = 0; c < 4; c++) d->color[c] = s.at("color").at(size_t(c)).get<double>();
      made.push_back(std::move(d));
    }
  });
  Box box;
  std::optional<Grid> first;
  std::vector<LoadedGeometry> loaded(made.size());  // of those that are geometry
  std::vector<std::string> warnings;                // on rank 0
  const auto all = int64_t(made.size());
  int64_t finished = 0;
  const auto begin = [&](const char* what, size_t i, bool phase = false) {
    part.begin(finished, all, what + specs[i].at("name").get<std::string>(), phase);
  };
  for (size_t i = 0; i < made.size(); i++) {
    Dataset& d = *made[i];
    begin(types[i] == DatasetType::Volume ? "opening " : "reading ", i);
    if (types[i] == DatasetType::Volume) {
      const Grid grid = gridOf(d.file, d.array, ranks, &warnings);
      box.extend(grid.box());
      if (!first) first = grid;
    } else {
      std::vector<LedgerEntry> reading;  // until it is known what is kept
      ValuesWanted wanted(d.array);
      wanted.radii = d.radiusArray;
      loaded[i] = loadGeometry(
          d.file, kindOf(types[i]), wanted, ranks,
          [&](int64_t bytes) { reading.push_back(node_.takeMemory(tenant, "geometry", bytes)); }, &warnings);
      agree(ranks, [&] {
        reading.clear();
        d.memory = node_.takeMemory(tenant, "geometry", bytesOf(loaded[i].geometry.block));
      });
      box.extend(loaded[i].geometry.box);
      finished++;
    }
  }

  // Rank 0 says how they are cut: what it took that from may have been dropped on others.
  std::shared_ptr<const Partitioning> partitioning;
  Bytes told;
  agree(ranks, [&] {
    if (node_.rank() != 0) return;
    partitioning = partitioningFor(p, box, first ? &*first : nullptr);
    told = written(*partitioning);
  });
  told = node_.collective.broadcast(exchange, 0, std::move(told));
  agree(ranks, [&] {
    if (!partitioning) partitioning = std::make_shared<const Partitioning>(readPartitioning(told));
  });

  bool samples = false;
  for (size_t i = 0; i < made.size(); i++) {
    Dataset& d = *made[i];
    d.partitioning = partitioning;
    if (types[i] != DatasetType::Volume) {
      d.geometry =
          std::make_shared<const OwnedGeometry>(ownedGeometry(std::move(loaded[i]), *partitioning, ranks));
      d.bytes = bytesOf(d.geometry->block);
      d.memory.resize(d.bytes);
      continue;
    }
    begin("importing ", i, !std::exchange(samples, true));
    VolumeFile file;
    agree(ranks, [&] {
      file = openVolume(d.file, d.array);
      d.bytes = bytesToCome(file, *partitioning, node_.rank());
      d.memory = node_.takeMemory(tenant, "volume", d.bytes);
    });
    d.volume = importVolume(std::move(file), *partitioning, kGhostLayers, ranks);
    d.bytes = gxy::bytesOf(*d.volume);
    d.memory.resize(d.bytes);
    finished++;
  }

  // Whoever shows the generation before the current one lets go of it soon (docs/protocol.md section 9).
  constexpr WhenTaken whenTaken{std::chrono::seconds(1)};
  // Objects that exist get a second buffer, which is committed when all ranks have theirs; the others are made. Rank 0 goes
  // before the others: what is pinned there keeps them all from giving that generation up.
  size_t done = 0;
  const auto store = [&] {
    for (; done < made.size(); done++) {
      const Key key{specs[done].at("key").get<uint64_t>()};
      if (!specs[done].at("update").get<bool>()) {
        node_.objects.add(key, Payload(std::shared_ptr<const Dataset>(made[done])), whenTaken);
      } else {
        if (!node_.objects.reserve(key))
          throw Error("dataset " + inQuotes(specs[done].at("name").get<std::string>()) +
                      ": both its generations are in use, so this step is left out");
        node_.objects.stage(key, Payload(std::shared_ptr<const Dataset>(made[done])));
      }
    }
  };
  try {
    agree(ranks, [&] {
      if (node_.rank() == 0) store();
    });
    agree(ranks, store);
  } catch (const Error&) {
    for (size_t i = 0; i < done; i++) {
      const Key key{specs[i].at("key").get<uint64_t>()};
      if (specs[i].at("update").get<bool>())
        abandonHere(key);
      else if (node_.objects.contains(key))  // nobody else knows its name
        node_.objects.drop(key);
    }
    throw;
  }
  return warnings;
}

constexpr size_t kAtOnce = 10000;  // datasets: all ranks are told of all of them

/// An import under way, which ends when one of its names is dropped.
struct Datasets::Importing {
  explicit Importing(std::string whose) : tenant(std::move(whose)) {}

  const std::string tenant;
  std::atomic<uint64_t> exchange = 0;  ///< 0: it has not begun
  std::atomic<bool> dropped = false;

  void check() const {
    if (dropped) throw Error("cancelled: a dataset of this import was dropped");
  }
};

bool Datasets::endImportsOf(const std::string& tenant, const std::string& name) {
  std::vector<uint64_t> ended;
  {
    const std::lock_guard lock(mutex_);
    for (const std::string& whose : {tenant, std::string()})
      if (const auto at = importing_.find(whose + "\n" + name);
          at != importing_.end() && at->second->tenant == tenant) {
        at->second->dropped = true;
        ended.push_back(at->second->exchange);
      }
  }
  for (const uint64_t exchange : ended) node_.exchanges.cancel(exchange);
  return !ended.empty();
}

// The names are the caller's until it lets go.
std::shared_ptr<void> Datasets::takeNames(Request& request, const Import& what,
                                          const std::shared_ptr<Importing>& importing) {
  std::set<std::string> names;
  for (const DatasetSpec& d : what.specs) {
    checkDatasetName(d.name);
    const std::string whose = what.scope == Scope::Shared ? "" : request.session().tenant();
    if (!names.insert(whose + "\n" + d.name).second)
      throw Error("import: the name " + inQuotes(d.name) +
                  " is there twice, expected a name for each dataset");
  }
  request.onCancel([this] {
    const std::lock_guard lock(mutex_);
    changed_.notify_all();
  });
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] {
    return request.cancelled() || std::none_of(names.begin(), names.end(), [this](const std::string& name) {
             return importing_.count(name) > 0;
           });
  });
  request.check();
  for (const std::string& name : names) importing_.emplace(name, importing);
  return {nullptr, [this, names](void*) {
            const std::lock_guard again(mutex_);
            for (const std::string& name : names) importing_.erase(name);
            changed_.notify_all();
          }};
}

std::vector<std::string> Datasets::import(Request& request, const Import& what) {
  const std::string tenant = request.session().tenant();
  if (what.specs.empty()) throw Error("import: there is no dataset in `Datasets`, expected one or more");
  if (what.specs.size() > kAtOnce)
    throw Error("import: there are " + std::to_string(what.specs.size()) + " datasets, expected at most " +
                std::to_string(kAtOnce) + " in one request");
  const auto importing = std::make_shared<Importing>(tenant);
  const std::shared_ptr<void> names = takeNames(request, what, importing);
  std::vector<DatasetSpec> specs = what.specs;
  if (what.onlyMissing) std::erase_if(specs, [&](const DatasetSpec& d) { return find(tenant, d.name); });
  if (specs.empty()) return {};
  Asker asker = askerOf(request);
  asker.check = [&request, importing] {
    importing->check();
    request.check();
  };
  const auto exchange = node_.exchanges.begin(std::move(asker));
  importing->exchange = *exchange;
  request.onCancel([this, number = *exchange] { node_.exchanges.cancel(number); });
  json parameters{{"exchange", *exchange}, {"tenant", tenant}, {"new", what.newPartitioning}};
  std::shared_ptr<const Partitioning> like;
  if (!what.like.empty()) like = getPinned(tenant, what.like).second.get<Dataset>()->partitioning;
  json updates = json::array();
  std::vector<Unnamed> added;
  for (const DatasetSpec& d : specs) {
    json spec = specToJson(d);
    const auto present = mayName(tenant, d.name, what.scope);
    const bool update = present && present->type == nameOf(d.type);
    const Key key = update ? present->key : node_.keys.next();
    const Generation generation = update ? present->generation + 1 : 1;
    spec["key"] = key.value;
    spec["generation"] = generation;
    spec["update"] = update;
    if (update)
      updates.push_back({{"name", d.name}, {"key", key.value}, {"generation", generation}});
    else
      added.push_back({d.name, key, d.type});
    parameters["datasets"].push_back(std::move(spec));
  }
  if (like) {
    const std::lock_guard lock(mutex_);
    like_[*exchange] = std::move(like);
  }
  const std::shared_ptr<void> forget(nullptr, [&](void*) {
    const std::lock_guard lock(mutex_);
    like_.erase(*exchange);
  });
  std::vector<std::string> warnings;
  try {
    warnings = node_.callAll("datasets.import", parameters).at(0).get<std::vector<std::string>>();
  } catch (const Error&) {
    importing->check();  // where one of these is why, it says more
    checkUpdates(tenant, what.scope, updates);
    throw;
  }
  nameAll(tenant, what.scope, added, updates, [&] { importing->check(); });
  const auto all = int64_t(specs.size()) * Exchanges::kUnits;
  request.progress(all, all, "done");
  return warnings;
}

}  // namespace gxy
