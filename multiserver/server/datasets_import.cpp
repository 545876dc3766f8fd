// SPDX-License-Identifier: Apache-2.0
// Files become datasets on all ranks, together.
#include <algorithm>
#include <chrono>
#include <cstring>
#include <map>

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
      throw Error("import: the data reach beyond the domain of the partitioning that they were to fraction");
    return like;
  }
  while (!p.at("new").get<bool>() && !like && !candidates.empty()) {
    try {
      like = serverRank_.objects.pin(candidates.back()).get<Dataset>()->partitioning;
    } catch (const Error&) {
      // dropped meanwhile
    }
    candidates.pop_back();
  }
  if (like && holds(like->domain(), data)) return like;
  return automaticPartitioning(data, grid, {}, serverRank_.ranks());
}

// Every rank: reads, agrees on a partitioning, imports. All ranks make the same exchanges, whatever fails: each step that
// can fail on one of them is inside agree().
json Datasets::importHere(const json& p) {
  const auto exchange = p.at("exchange").get<uint64_t>();
  const auto tenant = p.at("tenant").get<std::string>();
  const json& specs = p.at("datasets");
  const ReadScope inside = serverRank_.folders.reading();
  Exchanges::Part part = serverRank_.exchanges.join(exchange);
  RankCollectives& ranks = part.ranks;
  const ReadWatch watch([&] { ranks.check(); });
  Publication publication = join(p.at("items"), ranks);
  publication.reserve();

  std::vector<std::shared_ptr<Dataset>> made;
  std::vector<DatasetType> types;
  agree(ranks, [&] {
    for (size_t i = 0; i < specs.size(); i++) {
      const json& s = specs[i];
      const Publication::Item& item = publication.items()[i];
      auto d = std::make_shared<Dataset>();
      types.push_back(DatasetType(s.at("type").get<int>()));
      d->file = serverRank_.folders.dataToRead(s.at("file").get<std::string>());
      d->array = s.at("array").get<std::string>();
      d->radiusArray = s.at("radius array").get<std::string>();
      d->origins = {{item.key.value, int64_t(item.generation)}};
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
          [&](int64_t bytes) { reading.push_back(serverRank_.takeMemory(tenant, "geometry", bytes)); },
          &warnings);
      agree(ranks, [&] {
        reading.clear();
        d.memory = serverRank_.takeMemory(tenant, "geometry", bytesOf(loaded[i].geometry.block));
      });
      box.extend(loaded[i].geometry.box);
      finished++;
    }
  }

  // Rank 0 says how they are cut: what it took that from may have been dropped on others.
  std::shared_ptr<const Partitioning> partitioning;
  Bytes told;
  agree(ranks, [&] {
    if (serverRank_.rank() != 0) return;
    partitioning = partitioningFor(p, box, first ? &*first : nullptr);
    told = written(*partitioning);
  });
  told = serverRank_.collective.broadcast(exchange, 0, std::move(told));
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
      d.bytes = bytesToCome(file, *partitioning, serverRank_.rank());
      d.memory = serverRank_.takeMemory(tenant, "volume", d.bytes);
    });
    d.volume = importVolume(std::move(file), *partitioning, kGhostLayers, ranks);
    d.bytes = gxy::bytesOf(*d.volume);
    d.memory.resize(d.bytes);
    finished++;
  }

  for (size_t i = 0; i < made.size(); i++)
    publication.stage(i, Payload(std::shared_ptr<const Dataset>(std::move(made[i]))));
  publish(publication, exchange);
  return warnings;
}

constexpr size_t kAtOnce = 10000;  // datasets: all ranks are told of all of them

std::vector<std::string> Datasets::import(Request& request, const Import& what) {
  const std::string tenant = request.session().tenant();
  if (what.specs.empty()) throw Error("import: there is no dataset in `Datasets`, expected one or more");
  if (what.specs.size() > kAtOnce)
    throw Error("import: there are " + std::to_string(what.specs.size()) + " datasets, expected at most " +
                std::to_string(kAtOnce) + " in one request");
  const auto exchange = serverRank_.exchanges.begin(request);
  std::vector<DatasetDraft> drafts;
  for (const DatasetSpec& d : what.specs) drafts.push_back({d.name, d.type});
  const auto names = begin(request, *exchange, "import", what.scope, std::move(drafts), what.onlyMissing);
  if (names->drafts().empty()) return {};
  json parameters{
      {"exchange", *exchange}, {"tenant", tenant}, {"new", what.newPartitioning}, {"items", names->items()}};
  std::map<std::string, const DatasetSpec*> specs;
  for (const DatasetSpec& d : what.specs) specs[d.name] = &d;
  for (const DatasetDraft& d : names->drafts())
    parameters["datasets"].push_back(specToJson(*specs.at(d.name)));
  if (!what.like.empty()) {
    auto like = getPinned(tenant, what.like).second.get<Dataset>()->partitioning;
    const std::lock_guard lock(mutex_);
    like_[*exchange] = std::move(like);
  }
  const std::shared_ptr<void> forget(nullptr, [&](void*) {
    const std::lock_guard lock(mutex_);
    like_.erase(*exchange);
  });
  std::vector<std::string> warnings;
  try {
    warnings = serverRank_.callAll("datasets.import", parameters).at(0).get<std::vector<std::string>>();
  } catch (const Error&) {
    newObjects(*names);  // if a name is why, this says more
    throw;
  }
  const auto all = int64_t(names->drafts().size()) * Exchanges::kUnits;
  request.progress(all, all, "done");
  return warnings;
}

}  // namespace gxy
