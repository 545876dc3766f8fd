// SPDX-License-Identifier: Apache-2.0
// Every point travels once, to the rank that owns its partition.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "core/comm/error.h"
#include "core/data/partitioning.h"
#include "insitu/plan/redistribution.h"
#include "tests/insitu/random_blocks.h"

namespace gxy::insitu {
namespace {

struct Case {
  explicit Case(uint64_t seed) : random(seed) {
    grid.points = randomPoints(random);
    grid.origin = {double(random.below(100)) - 50, 0.1, -3};
    grid.spacing = {0.5, 1 / 3.0, 7};
    ranks = 1 + int(random.below(64));
    owners = 1 + int(random.below(8));
    blocks = randomBlocks(random, grid.points, ranks);
  }
  Partitioning partitioning() {
    const auto cells = grid.cells();
    const int64_t most = std::min<int64_t>(12, cells[0] * cells[1] * cells[2]);
    for (;;) try {
        return decomposed(grid, 1 + int(random.below(uint64_t(most))), owners);
      } catch (const Error&) {
        // not as many blocks along the axes
      }
  }
  Random random;
  Grid grid;
  int ranks, owners;
  std::vector<Block> blocks;
};

TEST(Redistribution, NothingGoesToOtherRanksWhereBlocksBecomePartitions) {
  size_t thin = 0;
  for (uint64_t seed = 1; seed <= 200; seed++) {
    Case c(seed);
    c.grid.rim = c.grid.points[0] > 2 && c.grid.points[1] > 2 && c.grid.points[2] > 2 && c.random.oneIn(2);
    const Partitioning partitioning = partitionsOf(c.grid, c.blocks, c.ranks, c.owners).value();
    EXPECT_EQ(partitioning.domain(), c.grid.box());
    const auto hasCells = [&](const Extent& block) {
      for (size_t a = 0; a < 3; a++)
        if (block.first[a] + 1 == c.grid.points[a] || (c.grid.rim && block.first[a] + block.points[a] == 1))
          return false;
      return true;
    };
    const BlockSearch search(c.blocks);
    int64_t points = 0;
    for (int owner = 0; owner < c.owners; owner++)
      for (const Piece& piece : piecesFor(owner, c.grid, partitioning, search)) {
        points += piece.points.count();
        const auto block = std::find_if(c.blocks.begin(), c.blocks.end(), [&](const Block& b) {
          return b.rank == piece.rank && b.index == piece.block;
        });
        ASSERT_NE(block, c.blocks.end());
        if (hasCells(block->extent)) {
          EXPECT_EQ(owner, piece.rank * c.owners / c.ranks) << "seed " << seed;
          EXPECT_EQ(piece.points, block->extent) << "seed " << seed;
        } else {
          thin++;
        }
      }
    EXPECT_EQ(points, c.grid.points[0] * c.grid.points[1] * c.grid.points[2]) << "seed " << seed;
  }
  EXPECT_GT(thin, 50u) << "pieces of blocks without cells";
}

TEST(Redistribution, BlocksThatCutEachOthersBoxesAreNoPartitions) {
  Grid grid;
  grid.points = {400, 400, 400};
  std::vector<Block> blocks;  // each cut along all axes at a place of its own
  for (int r = 0; r < 400; r++) blocks.push_back({r, 0, {{r, r, r}, {1, 1, 1}}});
  EXPECT_FALSE(partitionsOf(grid, blocks, 400, 4));
}

TEST(Redistribution, BringsEachPointToItsOwnerOnce) {
  for (uint64_t seed = 1; seed <= 200; seed++) {
    Case c(seed);
    const Partitioning partitioning = c.partitioning();
    const BlockSearch search(c.blocks);
    std::map<Index3, int> times;
    for (int owner = 0; owner < c.owners; owner++)
      for (const Piece& piece : piecesFor(owner, c.grid, partitioning, search)) {
        EXPECT_EQ(partitioning.owner(piece.partition), owner);
        const Extent owned = ownedPoints(c.grid, partitioning, piece.partition);
        EXPECT_EQ(intersection(piece.points, owned), piece.points);
        for (int64_t k = 0; k < piece.points.points[2]; k++)
          for (int64_t j = 0; j < piece.points.points[1]; j++)
            for (int64_t i = 0; i < piece.points.points[0]; i++)
              times[{piece.points.first[0] + i, piece.points.first[1] + j, piece.points.first[2] + k}]++;
      }
    EXPECT_EQ(int64_t(times.size()), c.grid.points[0] * c.grid.points[1] * c.grid.points[2]) << seed;
    for (const auto& [point, n] : times) EXPECT_EQ(n, 1) << seed;
  }
}

TEST(Redistribution, TellsBothEndsTheSamePieces) {
  for (uint64_t seed = 1; seed <= 100; seed++) {
    Case c(seed);
    const Partitioning partitioning = c.partitioning();
    const BlockSearch search(c.blocks);
    std::vector<int> homes;
    for (int r = 0; r < c.ranks; r++) homes.push_back(int(c.random.below(uint64_t(c.owners))));
    Mesh grid, particles;
    grid.grid = c.grid;
    particles.kind = Mesh::Kind::Points;
    const std::vector<Mesh> meshes{particles, grid, grid};
    const std::vector<BlockSearch> searches{BlockSearch({}), search, search};
    const Layout layout{meshes, searches, homes, partitioning};
    const auto all = destinations(c.ranks, c.owners, layout);
    std::map<int, int> homesFound;
    for (int owner = 0; owner < c.owners; owner++) {
      std::vector<Piece> sent, received = piecesFor(owner, layout);
      for (const auto& list : all)
        for (const Destination& d : list)
          if (d.owner == owner) sent.insert(sent.end(), d.pieces.begin(), d.pieces.end());
      std::stable_sort(received.begin(), received.end(),
                       [](const Piece& a, const Piece& b) { return a.rank < b.rank; });
      EXPECT_EQ(sent, received) << seed;
      for (const Piece& piece : sent)
        if (piece.mesh == 0) homesFound[piece.rank] += 1 + owner;
    }
    for (int r = 0; r < c.ranks; r++) EXPECT_EQ(homesFound[r], 1 + homes[size_t(r)]) << seed;
  }
}

TEST(Redistribution, DoesNotDependOnTheOrderInWhichBlocksAreTold) {
  for (uint64_t seed = 1; seed <= 50; seed++) {
    Case c(seed);
    const Partitioning partitioning = c.partitioning();
    auto shuffled = c.blocks;
    for (size_t i = shuffled.size(); i > 1; i--) std::swap(shuffled[i - 1], shuffled[c.random.below(i)]);
    EXPECT_EQ(piecesFor(0, c.grid, partitioning, BlockSearch(c.blocks)),
              piecesFor(0, c.grid, partitioning, BlockSearch(shuffled)));
  }
}

}  // namespace
}  // namespace gxy::insitu
