// SPDX-License-Identifier: Apache-2.0
#include "core/data/gather_mesh.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <utility>

#include "core/comm/error.h"
#include "core/data/mesh_blocks.h"
#include "core/data/mesh_defects.h"
#include "core/data/mesh_kinds.h"

namespace gxy {

namespace {

// Appends the cells of a block that are counted in its partition (MeshBlockCounts), and their points.
void appendOwn(const Mesh& mesh, const MeshBlock& block, const Partitioning& partitioning, int partition,
               MeshPiece& to) {
  constexpr uint32_t kNone = UINT32_MAX;
  const auto n = size_t(mesh.components);
  std::vector<uint32_t> numberOf(block.points.size(), kNone);
  const auto isHere = [&](uint32_t point) {
    return partitioning.partitions() == 1 || partitioning.nearest(block.points[point]) == partition;
  };
  const auto numberIn = [&](uint32_t point) {
    if (numberOf[point] == kNone) {
      numberOf[point] = uint32_t(to.points.size());
      to.points.push_back(block.points[point]);
      to.numbers.push_back(to.numbers.size());
      if (!mesh.ofCells)
        to.values.insert(to.values.end(), block.values.begin() + std::ptrdiff_t(point * n),
                         block.values.begin() + std::ptrdiff_t((point + 1) * n));
    }
    return numberOf[point];
  };
  size_t cell = 0;
  for (const CellType type : kAllCellTypes) {
    const std::span<const uint32_t> corners = block.cells.view().points[size_t(type)];
    const size_t each = shapeOf(type).points;
    for (size_t at = 0; at < corners.size(); at += each, cell++) {
      const auto own = corners.subspan(at, each);
      if (!isHere(*std::min_element(own.begin(), own.end()))) continue;
      for (const uint32_t point : own) to.cells.points[size_t(type)].push_back(numberIn(point));
      if (!mesh.ofCells) continue;
      std::vector<float>& values = to.cellValues[size_t(type)];
      values.insert(values.end(), block.cellValues.begin() + std::ptrdiff_t(cell * n),
                    block.cellValues.begin() + std::ptrdiff_t((cell + 1) * n));
      to.duplicates[size_t(type)].push_back(0);
    }
  }
}

std::vector<std::byte> decoded(const Mesh& mesh, const std::vector<float>& stored) {
  std::vector<std::byte> values(stored.size() * bytesOf(gatheredType(mesh)));
  if (gatheredType(mesh) == ScalarType::Float32) {
    if (!values.empty()) std::memcpy(values.data(), stored.data(), values.size());
    return values;
  }
  for (size_t i = 0; i < stored.size(); i++) {
    const double value = mesh.shift + mesh.scale * double(stored[i]);
    std::memcpy(values.data() + i * sizeof value, &value, sizeof value);
  }
  return values;
}

GatheredMesh asFile(const Mesh& mesh, MeshBlock block) {
  constexpr std::array<uint8_t, kCellTypes> kTypes{10, 14, 13, 12};
  GatheredMesh all;
  all.values = decoded(mesh, mesh.ofCells ? block.cellValues : block.values);
  all.points.assign(block.points.begin(), block.points.end());
  all.offsets.push_back(0);
  for (const CellType type : kAllCellTypes) {
    const std::span<const uint32_t> corners = block.cells.view().points[size_t(type)];
    const size_t each = shapeOf(type).points, first = all.connectivity.size();
    all.connectivity.insert(all.connectivity.end(), corners.begin(), corners.end());
    for (size_t at = first; at < all.connectivity.size(); at += each) {
      const std::span<uint32_t> cell(all.connectivity.data() + at, each);
      // A block knows a tetrahedron's points in ascending order only.
      if (type == CellType::Tetrahedron && isInverted(all.points, type, cell)) std::swap(cell[0], cell[1]);
      all.types.push_back(kTypes[size_t(type)]);
      all.offsets.push_back(at + each);
    }
  }
  return all;
}

}  // namespace

ScalarType gatheredType(const Mesh& mesh) {
  return mesh.shift == 0 && mesh.scale == 1 ? ScalarType::Float32 : ScalarType::Float64;
}

int64_t gatheringBytes(const Mesh& mesh, bool root) {
  const int64_t own = 2 * bytesOf(mesh);  // the piece, and its message
  if (!root) return own;
  constexpr int64_t kPoint = 64,
                    kCorner = 64;  // of messages, the block in the making (distribute()), and the result
  int64_t corners = 0, cells = 0;
  for (const CellType type : kAllCellTypes) {
    const auto count = int64_t(mesh.report.cells[size_t(type)]);
    cells += count;
    corners += count * shapeOf(type).points;
  }
  const int64_t values =
      24 * int64_t(mesh.components) * (int64_t(mesh.report.points) + (mesh.ofCells ? cells : 0));
  return own + 2 * kPoint * int64_t(mesh.report.points) + kCorner * corners + values;
}

GatheredMesh gatherMesh(const Mesh& mesh, const Partitioning& partitioning, Collectives& ranks) {
  MeshPiece piece;
  piece.components = mesh.components;
  piece.ofCells = mesh.ofCells;
  agree(ranks, [&] {
    ranks.check();
    uint64_t cells = 0;
    for (const uint64_t ofType : mesh.report.cells) cells += ofType;
    if (mesh.report.points >= kMostMeshPoints || cells >= kMostMeshCells)
      throw Error("a mesh of " + std::to_string(mesh.report.points) + " points and " + std::to_string(cells) +
                  " cells, expected fewer than 2^30 points and 2^29 cells, as one rank gets all of it");
    for (const auto& [partition, block] : mesh.blocks) appendOwn(mesh, block, partitioning, partition, piece);
  });
  MeshBlockCounts counts;
  std::map<int, MeshBlock> whole =
      distribute(std::move(piece), Partitioning::single(partitioning.domain()), counts, ranks);
  GatheredMesh all;
  agree(ranks, [&] {
    if (ranks.rank() == 0) all = asFile(mesh, whole.empty() ? MeshBlock() : std::move(whole.begin()->second));
  });
  return all;
}

}  // namespace gxy
