// SPDX-License-Identifier: Apache-2.0
// Pieces of meshes of all types of cells, dealt out among ranks.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <mutex>
#include <random>
#include <vector>

#include "core/data/mesh_blocks.h"
#include "tests/support/thread_ranks.h"

namespace gxy::test {

inline std::array<double, 3> placeOf(const glm::dvec3& p) { return {p.x, p.y, p.z}; }

/// Cells `first` to `last` of a mesh, with their points in any order.
inline MeshPiece someOf(const MeshPiece& all, size_t first, size_t last, std::mt19937& random) {
  MeshPiece some;
  some.components = all.components;
  some.ofCells = all.ofCells;
  std::vector<uint32_t> points;
  for (size_t cell = first; cell < last; cell++) {
    const auto ids = all.cells.pointsOf(uint32_t(cell));
    const CellType type = all.cells.typeOf(uint32_t(cell));
    auto& to = some.cells.points[size_t(type)];
    to.insert(to.end(), ids.begin(), ids.end());
    if (all.ofCells) {
      const size_t place = cell - all.cells.first(type), each = size_t(all.components);
      const auto values = all.cellValues[size_t(type)].begin() + std::ptrdiff_t(place * each);
      auto& own = some.cellValues[size_t(type)];
      own.insert(own.end(), values, values + std::ptrdiff_t(each));
      some.duplicates[size_t(type)].push_back(all.duplicates[size_t(type)][place]);
    }
    points.insert(points.end(), ids.begin(), ids.end());
  }
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  std::shuffle(points.begin(), points.end(), random);
  std::map<uint32_t, uint32_t> numberOf;
  for (const uint32_t p : points) {
    numberOf.emplace(p, uint32_t(some.points.size()));
    some.points.push_back(all.points[p]);
    some.numbers.push_back(all.numbers[p]);
    for (int c = 0; c < all.components && !all.ofCells; c++)
      some.values.push_back(all.values[p * size_t(all.components) + size_t(c)]);
  }
  for (auto& cells : some.cells.points)
    for (uint32_t& corner : cells) corner = numberOf.at(corner);
  return some;
}

/// The same cells in another order, and the points of each tetrahedron, too.
inline MeshPiece shuffled(const MeshPiece& all, std::mt19937& random) {
  MeshPiece mesh = all;
  for (const CellType type : kAllCellTypes) {
    const size_t n = shapeOf(type).points;
    const std::vector<uint32_t>& ids = all.cells.points[size_t(type)];
    struct Cell {
      std::vector<uint32_t> points;
      std::vector<float> values;
      uint8_t duplicate;
    };
    std::vector<Cell> cells;
    const auto each = size_t(all.ofCells ? all.components : 0);
    for (size_t i = 0; i < ids.size() / n; i++) {
      const auto at = ids.begin() + std::ptrdiff_t(i * n);
      const auto values = all.cellValues[size_t(type)].begin() + std::ptrdiff_t(i * each);
      cells.push_back({{at, at + std::ptrdiff_t(n)},
                       {values, values + std::ptrdiff_t(each)},
                       all.ofCells ? all.duplicates[size_t(type)][i] : uint8_t(0)});
      if (type == CellType::Tetrahedron)
        std::shuffle(cells.back().points.begin(), cells.back().points.end(), random);
    }
    std::shuffle(cells.begin(), cells.end(), random);
    std::vector<uint32_t>& to = mesh.cells.points[size_t(type)];
    to.clear();
    mesh.cellValues[size_t(type)].clear();
    mesh.duplicates[size_t(type)].clear();
    for (const Cell& cell : cells) {
      to.insert(to.end(), cell.points.begin(), cell.points.end());
      if (!all.ofCells) continue;
      auto& values = mesh.cellValues[size_t(type)];
      values.insert(values.end(), cell.values.begin(), cell.values.end());
      mesh.duplicates[size_t(type)].push_back(cell.duplicate);
    }
  }
  return mesh;
}

inline bool areEqual(const MeshBlock& a, const MeshBlock& b) {
  return a.points == b.points && a.values == b.values && a.cells.points == b.cells.points &&
         a.cellValues == b.cellValues && a.neighbours == b.neighbours && a.shell == b.shell;
}

/// The cells of a block, as connect() takes them.
inline MeshCells cellsOf(const MeshBlock& block) {
  MeshCells cells;
  for (size_t type = 0; type < kCellTypes; type++)
    cells.points[type].assign(block.cells.points[type].begin(), block.cells.points[type].end());
  return cells;
}

/// The blocks of all ranks, of `mesh` dealt out in as many pieces of cells.
inline std::map<int, MeshBlock> dealtOut(const MeshPiece& mesh, const Partitioning& partitioning, int ranks,
                                         std::mt19937& random, MeshBlockCounts& counts) {
  std::map<int, MeshBlock> blocks;
  std::mutex mutex;
  const size_t cells = mesh.cells.size();
  std::vector<size_t> cuts{0, cells};
  for (int r = 1; r < ranks; r++) cuts.push_back(random() % (cells + 1));
  std::sort(cuts.begin(), cuts.end());
  std::vector<MeshPiece> pieces;
  for (size_t r = 0; r + 1 < cuts.size(); r++) pieces.push_back(someOf(mesh, cuts[r], cuts[r + 1], random));
  std::shuffle(pieces.begin(), pieces.end(), random);
  const auto errors = ThreadRanks(ranks).run([&](Collectives& mine) {
    MeshBlockCounts found;
    auto own = distribute(pieces[size_t(mine.rank())], partitioning, found, mine);
    const std::lock_guard lock(mutex);
    for (auto& [partition, block] : own) {
      EXPECT_EQ(partitioning.owner(partition), mine.rank());
      EXPECT_TRUE(blocks.emplace(partition, std::move(block)).second);
    }
    counts = found;
  });
  EXPECT_EQ(errors, std::vector<std::string>(size_t(ranks)));
  return blocks;
}

}  // namespace gxy::test
