// SPDX-License-Identifier: Apache-2.0
#include "tests/support/data_sets.h"

#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "core/comm/error.h"
#include "core/data/complete_volume.h"
#include "core/data/distribute.h"
#include "core/data/mesh_blocks.h"
#include "tests/support/thread_ranks.h"

namespace gxy::test {

namespace {

template <class T>
WholeVolume sampledAs(ScalarType type, const Grid& grid, const std::function<T(glm::dvec3)>& f) {
  WholeVolume whole{grid, type, 1, {}};
  std::vector<T> values;
  for (int64_t z = 0; z < grid.points[2]; z++)
    for (int64_t y = 0; y < grid.points[1]; y++)
      for (int64_t x = 0; x < grid.points[0]; x++)
        values.push_back(f(grid.origin + grid.spacing * glm::dvec3(double(x), double(y), double(z))));
  whole.samples.resize(values.size() * sizeof(T));
  std::memcpy(whole.samples.data(), values.data(), whole.samples.size());
  return whole;
}

Samples samplesOf(const WholeVolume& whole, const Extent& e) {
  const size_t point = bytesOf(whole.stored) * size_t(whole.components);
  const size_t row = size_t(e.points[0]) * point;
  Samples out(size_t(e.count()) * point);
  std::byte* to = out.data();
  for (int64_t z = e.first[2]; z < e.first[2] + e.points[2]; z++)
    for (int64_t y = e.first[1]; y < e.first[1] + e.points[1]; y++, to += row) {
      const size_t at = size_t((z * whole.grid.points[1] + y) * whole.grid.points[0] + e.first[0]);
      std::memcpy(to, whole.samples.data() + at * point, row);
    }
  return out;
}

/// Runs work(ranks) on so many ranks, and throws the error of the first that failed.
template <class Work>
void onRanks(int ranks, Work work) {
  for (const std::string& error : ThreadRanks(ranks).run(work))
    if (!error.empty()) throw Error(error);
}

}  // namespace

WholeVolume sampled(const Grid& grid, const std::function<double(glm::dvec3)>& f) {
  return sampledAs<float>(ScalarType::Float32, grid, [&](glm::dvec3 p) { return float(f(p)); });
}

WholeVolume sampledAsBytes(const Grid& grid, const std::function<double(glm::dvec3)>& f) {
  return sampledAs<uint8_t>(ScalarType::UInt8, grid,
                            [&](glm::dvec3 p) { return uint8_t(std::lround(255 * f(p))); });
}

std::vector<std::shared_ptr<const Volume>> cut(const WholeVolume& whole, const Partitioning& partitioning,
                                               int ranks) {
  std::vector<std::shared_ptr<const Volume>> volumes(static_cast<size_t>(ranks));
  onRanks(ranks, [&](Collectives& mine) {
    const auto volume = std::make_shared<Volume>();
    volume->name = "volume";
    volume->grid = whole.grid;
    volume->stored = whole.stored;
    volume->components = whole.components;
    volume->shift = whole.shift, volume->scale = whole.scale;
    for (int partition : partitioning.owned(mine.rank())) {
      VolumeBlock block;
      block.extent = extentOf(whole.grid, partitioning.box(partition), kGhostLayers);
      if (block.extent.count() == 0) continue;
      block.samples = samplesOf(whole, block.extent);
      volume->blocks.emplace(partition, std::move(block));
    }
    completeVolume(*volume, partitioning, mine);
    volumes[size_t(mine.rank())] = volume;
  });
  return volumes;
}

std::vector<std::shared_ptr<const Mesh>> cut(const WholeMesh& whole, const Partitioning& partitioning,
                                             int ranks) {
  std::vector<std::shared_ptr<const Mesh>> meshes(static_cast<size_t>(ranks));
  onRanks(ranks, [&](Collectives& mine) {
    MeshPiece read = whole.cells;
    for (const CellType type : kAllCellTypes) {
      std::vector<uint32_t> kept;
      std::vector<float> values;
      const auto each = size_t(whole.cells.components);
      const auto& cells = whole.cells.cells.points[size_t(type)];
      const size_t corners = shapeOf(type).points, step = corners * size_t(ranks);
      for (size_t first = corners * size_t(mine.rank()); first < cells.size(); first += step) {
        kept.insert(kept.end(), cells.begin() + ptrdiff_t(first), cells.begin() + ptrdiff_t(first + corners));
        if (!read.ofCells) continue;
        const auto own = whole.cells.cellValues[size_t(type)].begin() + ptrdiff_t(first / corners * each);
        values.insert(values.end(), own, own + ptrdiff_t(each));
      }
      read.duplicates[size_t(type)].assign(read.ofCells ? kept.size() / corners : 0, 0);
      read.cells.points[size_t(type)] = std::move(kept);
      read.cellValues[size_t(type)] = std::move(values);
    }
    const auto mesh = std::make_shared<Mesh>(describedMesh(whole.cells, whole.shift, whole.scale));
    MeshBlockCounts counts;
    mesh->blocks = distribute(std::move(read), partitioning, counts, mine);
    mesh->report.cells = counts.cells;
    mesh->report.points = counts.points;
    mesh->report.foldedFaces = sumOfCounts(mine, counts.foldedFaces);
    mesh->report.crowdedFaces = sumOfCounts(mine, counts.crowdedFaces);
    meshes[size_t(mine.rank())] = mesh;
  });
  return meshes;
}

std::vector<std::shared_ptr<const PointGradients>> gradientsOf(
    const std::vector<std::shared_ptr<const Mesh>>& meshes, const Vis& vis,
    const Partitioning& partitioning) {
  std::vector<std::shared_ptr<const PointGradients>> gradients(meshes.size());
  if (vis.isovalues.empty()) return gradients;
  onRanks(int(meshes.size()), [&](Collectives& mine) {
    const auto rank = size_t(mine.rank());
    gradients[rank] = std::make_shared<const PointGradients>(
        pointGradients(*meshes[rank], vis.component, partitioning, mine));
  });
  return gradients;
}

std::vector<std::shared_ptr<const Geometry>> distributed(const WholeGeometry& whole,
                                                         const Partitioning& partitioning,
                                                         const RadiusOf& radius, int ranks) {
  std::vector<std::shared_ptr<const Geometry>> all(static_cast<size_t>(ranks));
  onRanks(ranks, [&](Collectives& mine) {
    std::vector<uint32_t> members;
    for (auto p = size_t(mine.rank()); p < whole.block.ids.size(); p += size_t(ranks))
      members.push_back(uint32_t(p));
    OwnedGeometry owned;
    owned.kind = whole.kind;
    owned.block = subset(whole.block, whole.kind, members);
    owned.box = boxOf(whole.block);
    owned.range = rangeOf(whole.block);
    owned.radiusRange = radiusRangeOf(whole.block);
    owned.colored = !whole.block.colors.empty();
    owned.primitives = whole.block.ids.size();
    all[size_t(mine.rank())] = distribute(owned, partitioning, radius, mine);
  });
  return all;
}

}  // namespace gxy::test
