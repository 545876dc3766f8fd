// SPDX-License-Identifier: Apache-2.0
#include "core/data/point_gradients.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "core/comm/parallel_for.h"
#include "core/data/cells_around.h"
#include "core/data/mesh_blocks.h"

namespace gxy {

namespace {

using Tetrahedron = std::array<uint8_t, 4>;  // places among a cell's points

/// What a cell counts as at one of its corners: a tetrahedron, or four at the top of a pyramid.
std::span<const Tetrahedron> tetrahedraAt(CellType type, size_t corner) {
  static constexpr std::array<Tetrahedron, 4> kOfTetrahedron{
      Tetrahedron{0, 1, 2, 3}, {1, 0, 2, 3}, {2, 0, 1, 3}, {3, 0, 1, 2}};
  static constexpr std::array<Tetrahedron, 8> kOfPyramid{Tetrahedron{0, 1, 3, 4},
                                                         {1, 2, 0, 4},
                                                         {2, 3, 1, 4},
                                                         {3, 0, 2, 4},
                                                         {4, 0, 1, 2},
                                                         {4, 1, 2, 3},
                                                         {4, 2, 3, 0},
                                                         {4, 3, 0, 1}};
  static constexpr std::array<Tetrahedron, 6> kOfWedge{
      Tetrahedron{0, 1, 2, 3}, {1, 2, 0, 4}, {2, 0, 1, 5}, {3, 4, 5, 0}, {4, 5, 3, 1}, {5, 3, 4, 2}};
  static constexpr std::array<Tetrahedron, 8> kOfHexahedron{Tetrahedron{0, 1, 3, 4},
                                                            {1, 2, 0, 5},
                                                            {2, 3, 1, 6},
                                                            {3, 0, 2, 7},
                                                            {4, 7, 5, 0},
                                                            {5, 4, 6, 1},
                                                            {6, 5, 7, 2},
                                                            {7, 6, 4, 3}};
  switch (type) {
    case CellType::Tetrahedron:
      return std::span(kOfTetrahedron).subspan(corner, 1);
    case CellType::Pyramid:
      return std::span(kOfPyramid).subspan(corner, corner == 4 ? 4 : 1);
    case CellType::Wedge:
      return std::span(kOfWedge).subspan(corner, 1);
    case CellType::Hexahedron:
      break;
  }
  return std::span(kOfHexahedron).subspan(corner, 1);
}

/// A mean of gradients, weighed by volume.
class MeanGradient {
 public:
  void add(const std::array<glm::dvec3, 4>& at, const std::array<double, 4>& values) {
    const glm::dvec3 b = at[1] - at[0], c = at[2] - at[0], d = at[3] - at[0];
    const glm::dvec3 acrossB = glm::cross(c, d), acrossC = glm::cross(d, b), acrossD = glm::cross(b, c);
    const double volume = glm::dot(b, acrossB);
    const glm::dvec3 scaled = (values[1] - values[0]) * acrossB + (values[2] - values[0]) * acrossC +
                              (values[3] - values[0]) * acrossD;
    volume_ += std::abs(volume);
    sum_ += volume < 0 ? -scaled : scaled;
  }
  glm::dvec3 mean() const { return volume_ > 0 ? sum_ / volume_ : glm::dvec3(0); }

 private:
  glm::dvec3 sum_{0};
  double volume_ = 0;
};

/// One component of a block, with the cells around each of its points. Immutable; safe to use from any thread.
class BlockGradients {
 public:
  BlockGradients(const Mesh& mesh, const MeshBlock& block, std::optional<int> component)
      : block_(block),
        values_(shownValues(block.values, mesh.components, component)),
        cellValues_(shownValues(block.cellValues, mesh.components, component)),
        cells_(block.cells.view()),
        around_(cells_, block.points.size()),
        unit_(largestSideOf(mesh.box)) {}

  glm::dvec3 at(uint32_t point) const {
    MeanGradient mean;
    for (const uint32_t cell : around_.of(point)) {
      const std::span<const uint32_t> corners = cells_.pointsOf(cell);
      if (!holdsData(cell, corners)) continue;
      const auto corner = size_t(std::find(corners.begin(), corners.end(), point) - corners.begin());
      for (const Tetrahedron& part : tetrahedraAt(cells_.typeOf(cell), corner)) {
        std::array<glm::dvec3, 4> places;
        std::array<double, 4> values;
        for (size_t k = 0; k < 4; k++) {
          const uint32_t p = corners[part[k]];
          places[k] = (block_.points[p] - block_.points[point]) / unit_;
          values[k] = double(values_[p]);
        }
        mean.add(places, values);
      }
    }
    return mean.mean();
  }

 private:
  static double largestSideOf(const Box& box) {
    if (box.empty()) return 1;
    const glm::dvec3 size = box.hi - box.lo;
    const double largest = std::max({size.x, size.y, size.z});
    return largest > 0 ? largest : 1;
  }
  bool holdsData(uint32_t cell, std::span<const uint32_t> corners) const {
    return (cellValues_.empty() || std::isfinite(cellValues_[cell])) &&
           std::all_of(corners.begin(), corners.end(), [&](uint32_t p) { return std::isfinite(values_[p]); });
  }

  const MeshBlock& block_;
  const std::vector<float> values_, cellValues_;
  const MeshCellsView cells_;
  const CellsAround around_;
  const double unit_;
};

/// The blocks of a mesh with these values at their points.
std::map<int, MeshBlock> blocksWith(const Mesh& mesh, PointGradients gradients) {
  std::map<int, MeshBlock> blocks;
  for (const auto& [partition, block] : mesh.blocks) {
    MeshBlock& with = blocks[partition];
    with.points = block.points;
    with.cells = block.cells;
    with.values = std::move(gradients.at(partition));
  }
  return blocks;
}

}  // namespace

int64_t bytesOf(const PointGradients& gradients) {
  int64_t bytes = 0;
  for (const auto& entry : gradients) bytes += int64_t(entry.second.size() * sizeof(float));
  return bytes;
}

PointGradients localGradients(const Mesh& mesh, std::optional<int> component, const Advance& advance) {
  PointGradients gradients;
  for (const auto& [partition, block] : mesh.blocks) {
    const BlockGradients of(mesh, block, component);
    std::vector<float>& made = gradients[partition];
    made.resize(block.points.size() * 3);
    parallelFor(
        size_t(0), block.points.size(),
        [&of, &made](size_t p) {
          const glm::dvec3 gradient = of.at(uint32_t(p));
          for (int a = 0; a < 3; a++) made[3 * p + size_t(a)] = float(gradient[a]);
        },
        advance);
  }
  return gradients;
}

std::vector<Bytes> packGradients(const Mesh& mesh, const PointGradients& gradients,
                                 const Partitioning& partitioning, int ranks) {
  MeshBlockCounts here;
  for (const auto& [partition, block] : mesh.blocks)
    for (uint32_t p = 0; p < block.points.size() && partitioning.partitions() > 1; p++)
      if (partitioning.nearest(block.points[p]) == partition) here.differing[partition].push_back(p);
  return packSettledValues(blocksWith(mesh, gradients), here, partitioning, ranks);
}

void takeGradients(const Mesh& mesh, PointGradients& gradients, const Partitioning& partitioning,
                   std::span<const Bytes> received) {
  std::map<int, MeshBlock> blocks = blocksWith(mesh, std::move(gradients));
  gradients.clear();
  takeSettledValues(blocks, partitioning, received);
  for (auto& [partition, block] : blocks) gradients[partition] = std::move(block.values);
}

PointGradients pointGradients(const Mesh& mesh, std::optional<int> component,
                              const Partitioning& partitioning, Collectives& ranks) {
  PointGradients gradients;
  std::vector<Bytes> messages;
  agree(ranks, [&] {
    gradients = localGradients(mesh, component, advanceOf(ranks));
    messages = packGradients(mesh, gradients, partitioning, ranks.size());
  });
  const std::vector<Bytes> received = ranks.allToAll(std::move(messages));
  agree(ranks, [&] { takeGradients(mesh, gradients, partitioning, received); });
  return gradients;
}

}  // namespace gxy
