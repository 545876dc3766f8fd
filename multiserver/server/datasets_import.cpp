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
#include "core/data/partitioning_bytes.h"
#include "core/io/automatic_partitioning.h"
#include "core/io/import_geometry.h"
#include "core/io/import_mesh.h"
#include "core/io/import_volume.h"
#include "core/scene/json_text.h"
#include "core/space/freed_memory.h"
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
  const bool becomesFloat = isWide(file.array.type);  // block by block
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
          {"fields", d.fields},
          {"color", {d.color.r, d.color.g, d.color.b, d.color.a}}};
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
      like = serverRank_.objects.pin(candidates.back()).get<Dataset>()->partitioning;
    } catch (const Error&) {
      // dropped meanwhile
    }
    candidates.pop_back();
  }
  if (like && holds(like->domain(), data)) return like;
  return automaticPartitioning(data, grid, {}, serverRank_.ranks());
}

namespace {

// One dataset of an import on this rank.
struct Importing {
  std::shared_ptr<Dataset> dataset = std::make_shared<Dataset>();
  DatasetType type = DatasetType::Volume;
  std::string name;
  bool isMesh = false;    // of a volume: it is unstructured
  LoadedGeometry loaded;  // of a geometry, until it has a partitioning
  LoadedMesh loadedMesh;  // of an unstructured volume, until it has a partitioning

  bool isOnGrid() const { return type == DatasetType::Volume && !isMesh; }
};

// The part of an import that one rank does. All ranks call the same functions in the same order and make the
// same collective calls, whatever fails: each step that can fail on one of them is inside agree(), or is a
// collective call that agrees itself.
class ImportPart {
 public:
  // `like`: how wide samples are stored if that will do.
  ImportPart(ServerRank& serverRank, Exchanges::Part& part, std::string tenant,
             std::optional<StoredLike> like)
      : serverRank_(serverRank), part_(part), ranks_(part.ranks), tenant_(std::move(tenant)), like_(like) {}

  // `specs` are those of specToJson(), one for each item.
  void describe(const json& specs, const std::vector<Publication::Item>& items) {
    agree(ranks_, [&] {
      for (size_t i = 0; i < specs.size(); i++) {
        const json& s = specs[i];
        Importing& one = importing_.emplace_back();
        one.type = DatasetType(s.at("type").get<int>());
        one.name = s.at("name").get<std::string>();
        Dataset& d = *one.dataset;
        d.file = serverRank_.folders.dataToRead(s.at("file").get<std::string>());
        d.array = s.at("array").get<std::string>();
        d.radiusArray = s.at("radius array").get<std::string>();
        d.fields = s.at("fields").get<std::vector<std::string>>();
        d.origins = {{items[i].key.value, int64_t(items[i].generation)}};
        for (int c = 0; c < 4; c++) d.color[c] = s.at("color").at(size_t(c)).get<double>();
      }
    });
  }

  // Finds out which volumes are unstructured, and reads the grids of the others.
  void openVolumes() {
    std::vector<uint8_t> meshes(importing_.size(), 0);
    agree(ranks_, [&] {
      for (size_t i = 0; i < importing_.size(); i++)
        meshes[i] = importing_[i].type == DatasetType::Volume && isMeshFile(importing_[i].dataset->file);
    });
    meshes = gatherValues(ranks_, std::span<const uint8_t>(meshes)).at(0);
    for (size_t i = 0; i < importing_.size(); i++) importing_[i].isMesh = meshes[i] != 0;
    for (const Importing& one : importing_) {
      if (!one.isOnGrid()) continue;
      begin("opening ", one);
      const Grid grid = gridOf(one.dataset->file, one.dataset->array, ranks_, &warnings);
      box.extend(grid.box());
      if (!firstGrid) firstGrid = grid;
    }
  }

  // Reads geometry and unstructured volumes.
  void readCells() {
    for (Importing& one : importing_) {
      if (one.isOnGrid()) continue;
      begin("reading ", one);
      one.isMesh ? readMesh(one) : readGeometry(one);
      box.extend(one.isMesh ? one.loadedMesh.box : one.loaded.geometry.box);
      if (!one.isMesh) finished_++;
    }
  }

  void takePartitioning(const std::shared_ptr<const Partitioning>& partitioning) {
    bool isFirst = true;
    for (Importing& one : importing_) {
      one.dataset->partitioning = partitioning;
      if (one.type != DatasetType::Volume) {
        keepGeometry(one);
      } else {
        begin("importing ", one, std::exchange(isFirst, false));
        one.isMesh ? distributeMesh(one) : readSamples(one);
        finished_++;
      }
    }
  }

  void stage(Publication& publication) {
    for (size_t i = 0; i < importing_.size(); i++)
      publication.stage(i, Payload(std::shared_ptr<const Dataset>(std::move(importing_[i].dataset))));
  }

  Box box;                            // of what openVolumes() and readCells() have read
  std::optional<Grid> firstGrid;      // of the first volume
  std::vector<std::string> warnings;  // on rank 0

 private:
  void begin(const char* what, const Importing& one, bool phase = false) {
    part_.begin(finished_, int64_t(importing_.size()), what + one.name, phase);
  }

  void readGeometry(Importing& one) {
    Dataset& d = *one.dataset;
    std::vector<LedgerEntry> reading;  // until it is known what is kept
    ValuesWanted wanted(d.array);
    wanted.radii = d.radiusArray;
    wanted.fields = d.fields;
    one.loaded = loadGeometry(
        d.file, kindOf(one.type), wanted, ranks_,
        [&](int64_t bytes) { reading.push_back(serverRank_.takeMemory(tenant_, "geometry", bytes)); },
        &warnings);
    agree(ranks_, [&] {
      reading.clear();
      d.memory = serverRank_.takeMemory(tenant_, "geometry", bytesOf(one.loaded.geometry.block));
    });
  }

  void readMesh(Importing& one) {
    Dataset& d = *one.dataset;
    std::vector<LedgerEntry> reading;  // until it is known what is kept
    one.loadedMesh = loadMesh(
        d.file, d.array, ranks_,
        [&](int64_t bytes) { reading.push_back(serverRank_.takeMemory(tenant_, "volume", bytes)); },
        &warnings);
    agree(ranks_, [&] {
      reading.clear();
      d.memory = serverRank_.takeMemory(tenant_, "volume", bytesOf(one.loadedMesh.piece));
    });
  }

  void distributeMesh(Importing& one) {
    Dataset& d = *one.dataset;
    std::vector<LedgerEntry> onTheWay;
    d.mesh = meshOf(
        std::move(one.loadedMesh), *d.partitioning, ranks_,
        [&](int64_t bytes) { onTheWay.push_back(serverRank_.takeMemory(tenant_, "volume", bytes)); },
        &warnings);
    d.bytes = bytesOf(*d.mesh);
    onTheWay.clear();
    d.memory.resize(d.bytes);
  }

  void keepGeometry(Importing& one) {
    Dataset& d = *one.dataset;
    d.geometry =
        std::make_shared<const OwnedGeometry>(ownedGeometry(std::move(one.loaded), *d.partitioning, ranks_));
    d.bytes = bytesOf(d.geometry->block);
    d.memory.resize(d.bytes);
  }

  void readSamples(Importing& one) {
    Dataset& d = *one.dataset;
    VolumeFile file;
    agree(ranks_, [&] {
      file = openVolume(d.file, d.array);
      d.bytes = bytesToCome(file, *d.partitioning, serverRank_.rank());
      d.memory = serverRank_.takeMemory(tenant_, "volume", d.bytes);
    });
    d.volume = importVolume(std::move(file), *d.partitioning, kGhostLayers, ranks_, {}, nullptr, like_);
    d.bytes = gxy::bytesOf(*d.volume);
    d.memory.resize(d.bytes);
  }

  ServerRank& serverRank_;
  Exchanges::Part& part_;
  RankCollectives& ranks_;
  const std::string tenant_;
  const std::optional<StoredLike> like_;
  std::vector<Importing> importing_;
  int64_t finished_ = 0;  // datasets that have been read
};

}  // namespace

// Rank 0 decides, because what it takes the partitioning from may have been dropped on other ranks.
std::shared_ptr<const Partitioning> Datasets::agreedPartitioning(const json& p, const Box& data,
                                                                 const Grid* grid, Collectives& ranks) {
  std::shared_ptr<const Partitioning> partitioning;
  Bytes told;
  agree(ranks, [&] {
    if (ranks.rank() != 0) return;
    partitioning = partitioningFor(p, data, grid);
    told = written(*partitioning);
  });
  told = serverRank_.collective.broadcast(p.at("exchange").get<uint64_t>(), 0, std::move(told));
  agree(ranks, [&] {
    if (!partitioning) partitioning = std::make_shared<const Partitioning>(readPartitioning(told));
  });
  return partitioning;
}

json Datasets::importHere(const json& p) {
  const auto exchange = p.at("exchange").get<uint64_t>();
  const ReadScope inside = serverRank_.folders.reading();
  Exchanges::Part part = serverRank_.exchanges.join(exchange);
  RankCollectives& ranks = part.ranks;
  const ReadWatch watch([&] { ranks.check(); });
  Publication publication = join(p.at("items"), ranks);
  std::optional<StoredLike> like;
  if (p.contains("like"))
    like = {{ScalarType::Float32, p.at("like").at(0).get<double>(), p.at("like").at(1).get<double>()},
            p.at("like").at(2).get<bool>()};
  ImportPart import(serverRank_, part, p.at("tenant").get<std::string>(), like);
  import.describe(p.at("datasets"), publication.items());
  import.openVolumes();
  // This takes older data away from whoever still shows them. So files without such data fail before it.
  publication.reserve();
  import.readCells();
  import.takePartitioning(
      agreedPartitioning(p, import.box, import.firstGrid ? &*import.firstGrid : nullptr, ranks));
  import.stage(publication);
  publish(publication, exchange);
  returnFreedMemory();
  return import.warnings;
}

constexpr size_t kAtOnce = 10000;  // datasets: all ranks are told of all of them

std::vector<std::string> Datasets::import(Request& request, const Import& what) {
  const auto exchange = serverRank_.exchanges.begin(request);
  notifyOnCancel(request);
  return importAs(request.session().tenant(), askerOf(request), *exchange, what).warnings;
}

Datasets::Imported Datasets::import(const std::string& tenant, const Asker& asker,
                                    const std::function<void(uint64_t)>& begun, const Import& what) {
  const auto exchange = serverRank_.exchanges.begin(asker);
  begun(*exchange);
  return importAs(tenant, asker, *exchange, what);
}

Datasets::Imported Datasets::importAs(const std::string& tenant, const Asker& asker, uint64_t exchange,
                                      const Import& what) {
  if (what.specs.empty()) throw Error("import: there is no dataset in `Datasets`, expected one or more");
  if (what.specs.size() > kAtOnce)
    throw Error("import: there are " + std::to_string(what.specs.size()) + " datasets, expected at most " +
                std::to_string(kAtOnce) + " in one request");
  const auto wanted = std::make_shared<Names>();
  wanted->operation_ = "import";
  wanted->tenant_ = tenant;
  wanted->scope_ = what.scope;
  wanted->exchange_ = exchange;
  wanted->ofGraph_ = what.ofGraph;
  for (const DatasetSpec& d : what.specs) wanted->drafts_.push_back({d.name, d.type});
  const auto names = begin(asker, wanted, what.onlyMissing);
  if (names->drafts().empty()) return {};
  json parameters{
      {"exchange", exchange}, {"tenant", tenant}, {"new", what.newPartitioning}, {"items", names->items()}};
  std::map<std::string, const DatasetSpec*> specs;
  for (const DatasetSpec& d : what.specs) specs[d.name] = &d;
  for (const DatasetDraft& d : names->drafts())
    parameters["datasets"].push_back(specToJson(*specs.at(d.name)));
  if (!what.like.empty()) {
    const auto like = getPinned(tenant, what.like).second.get<Dataset>();
    if (like->volume && like->volume->stored == ScalarType::Float32)
      parameters["like"] = {like->volume->shift, like->volume->scale, like->volume->rangesOfStored};
    const std::lock_guard lock(mutex_);
    like_[exchange] = like->partitioning;
  }
  const std::shared_ptr<void> forget(nullptr, [&](void*) {
    const std::lock_guard lock(mutex_);
    like_.erase(exchange);
  });
  std::vector<std::string> warnings;
  try {
    warnings = serverRank_.callAll("datasets.import", parameters).at(0).get<std::vector<std::string>>();
  } catch (const Error&) {
    check(*names);  // if a name is why, this says more
    throw;
  }
  const auto all = int64_t(names->drafts().size()) * Exchanges::kUnits;
  asker.progress(all, all, "done", true);
  return {names->drafts(), std::move(warnings)};
}

}  // namespace gxy
