// SPDX-License-Identifier: Apache-2.0
#include "core/look/file_facts.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>

#include "core/comm/error.h"
#include "core/io/file.h"
#include "core/io/import_geometry.h"
#include "core/io/import_mesh.h"
#include "core/io/mesh_file.h"
#include "core/io/volume_file.h"
#include "core/look/loaded_facts.h"

namespace gxy {
namespace {

constexpr int64_t kWhole = 256 << 20;  // Volumes with at most this many bytes are read completely.
constexpr int64_t kAtOnce = 16 << 20;  // bytes read at a time

struct VolumeSampler {
  const VolumeFile& file;
  const Index3 stride = samplingStride(file.grid);
  FieldStatistics statistics;
  std::vector<float> values;

  explicit VolumeSampler(const VolumeFile& f) : file(f) {
    statistics.ranges.resize(size_t(file.array.components > 1 ? file.array.components + 1 : 1));
  }
  void take(const Extent& slab, std::span<const std::byte> samples) {
    statistics.merge(statisticsOf(samples, file.array.type, file.array.components));
    const size_t each = file.bytesPerPoint();
    for (int64_t k = 0; k < slab.points[2]; k++) {
      if ((slab.first[2] + k) % stride[2] != 0) continue;
      for (int64_t j = 0; j < slab.points[1]; j += stride[1])
        for (int64_t i = 0; i < slab.points[0]; i += stride[0]) {
          const size_t point = size_t((k * slab.points[1] + j) * slab.points[0] + i);
          const double value =
              shownValue(samples.data() + point * each, file.array.type, file.array.components);
          if (std::isfinite(value)) values.push_back(float(value));
        }
    }
  }
  void readSlabs(const TakeMemory& toTake) {
    const Index3& points = file.grid.points;
    const int64_t layer = points[0] * points[1] * int64_t(file.bytesPerPoint());
    const bool whole = layer * points[2] <= kWhole;
    const int64_t depth = whole ? std::max<int64_t>(1, kAtOnce / layer) : 1;
    if (toTake) toTake(layer * std::min(depth, points[2]));
    std::vector<std::byte> samples;
    for (int64_t k = 0; k < points[2]; k += whole ? depth : stride[2]) {
      const Extent slab{{0, 0, k}, {points[0], points[1], std::min(depth, points[2] - k)}};
      samples.resize(size_t(slab.count()) * file.bytesPerPoint());
      readVolume(file, slab, samples);
      take(slab, samples);
    }
  }
};

LookFacts factsOfVolume(const std::string& path, const std::string& array, const TakeMemory& toTake) {
  const VolumeFile file = openVolume(path, array);
  VolumeSampler sampler(file);
  sampler.readSlabs(toTake);
  LookFacts facts;
  facts.dataset.type = DatasetType::Volume;
  const Box box = file.grid.box();
  facts.data = {box, box, sampler.statistics.ranges, 0};
  facts.values = std::move(sampler.values);
  facts.thin = thinAxis(file.grid);
  return facts;
}

LookFacts factsOfGeometry(const std::string& path, const std::string& array, const TakeMemory& toTake) {
  const GeometryKind kind = likelyKind(tellingPiece(path, toTake).second);
  SingleRank alone;
  std::vector<std::string> warnings;  // They are not shown here, but again when the file is loaded.
  const OwnedGeometry geometry = loadGeometry(path, kind, array, alone, toTake, &warnings).geometry;
  LookFacts facts;
  facts.dataset.type = kind == GeometryKind::Particles   ? DatasetType::Particles
                       : kind == GeometryKind::PathLines ? DatasetType::PathLines
                                                         : DatasetType::Triangles;
  facts.data = factsOf(geometry);
  if (valuesCount(path, array)) facts.values = sampleOf(geometry);
  return facts;
}

LookFacts factsOfMesh(const std::string& path, const std::string& array, const TakeMemory& toTake) {
  SingleRank alone;
  std::vector<std::string> warnings;  // They are shown when the file is loaded.
  LoadedMesh loaded = loadMesh(path, array, alone, toTake, &warnings);
  const Partitioning whole = Partitioning::single(loaded.box);
  const std::shared_ptr<const Mesh> mesh = meshOf(std::move(loaded), whole, alone, toTake, &warnings);
  LookFacts facts;
  facts.dataset.type = DatasetType::Volume;
  facts.data = factsOf(*mesh);
  facts.values = sampleOf(*mesh, whole);
  return facts;
}

}  // namespace

bool valuesCount(const std::string& path, const std::string& array) {
  return extensionOf(path) != ".ply" || !array.empty();
}

std::pair<std::string, GeometrySummary> tellingPiece(const std::string& path, const TakeMemory& toTake) {
  const std::vector<std::string> pieces = geometryPieces(path);
  if (pieces.empty()) throw Error(path + ": it lists no pieces, expected one or more");
  std::optional<std::pair<std::string, GeometrySummary>> best;
  for (const std::string& piece : pieces) {
    GeometrySummary summary = summariseGeometry(piece, toTake);
    if (summary.triangles || summary.solids || summary.segments || summary.vertices)
      return {piece, std::move(summary)};
    if (!best || (best->second.points == 0 && summary.points > 0)) best = {piece, std::move(summary)};
  }
  return *best;
}

LookFacts factsOfFile(const std::string& path, const std::string& array, bool inside,
                      const TakeMemory& toTake) {
  LookFacts facts = isVolumeFile(path) ? factsOfVolume(path, array, toTake)
                    : inside && isMeshFile(path) && tellingPiece(path, toTake).second.solids > 0
                        ? factsOfMesh(path, array, toTake)
                        : factsOfGeometry(path, array, toTake);
  facts.dataset.name = std::filesystem::path(path).stem().string();
  facts.dataset.filename = path;
  facts.dataset.array = array;
  completeSample(facts);
  return facts;
}

std::vector<LookFacts> factsOfFiles(std::span<const std::string> paths, const std::string& array,
                                    bool inside) {
  std::vector<LookFacts> all;
  std::set<std::string> names;
  for (const std::string& path : paths) {
    LookFacts facts = factsOfFile(path, array, inside);
    const std::string name = facts.dataset.name;
    for (int n = 2; !names.insert(facts.dataset.name).second; n++)
      facts.dataset.name = name + "-" + std::to_string(n);
    all.push_back(std::move(facts));
  }
  return all;
}

}  // namespace gxy
