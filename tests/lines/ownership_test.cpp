// SPDX-License-Identifier: Apache-2.0
// Which partition owns a cell, which cell a seed is in, and which volumes lines can read.
#include <gtest/gtest.h>

#include "core/comm/error.h"
#include "tests/kernels/random.h"
#include "tests/lines/flow_fields.h"
#include "tests/support/partitionings.h"

namespace gxy::test {
namespace {

const FieldFunction kOnes = [](glm::dvec3) { return std::vector<double>{1, 1, 1}; };

std::shared_ptr<const CompiledFields> compiledOn(const Grid& grid, const Partitioning& cut) {
  return std::make_shared<const CompiledFields>(std::vector{volumeOf(grid, cut, 3, kOnes)},
                                                std::make_shared<const Partitioning>(cut));
}

Grid gridWithCells(Index3 cells) {
  return gridOver({-2, 1, 0}, {3, 2, 4}, {cells[0] + 1, cells[1] + 1, cells[2] + 1});
}

std::vector<Cut> cutsOf(const Box& domain) {
  std::vector<Cut> cuts = manyCuts(domain, 5);
  cuts.push_back(kdCut(domain, 64, 1, 9));
  cuts.push_back(lattice(domain, {16, 2, 2}, 3));
  return cuts;
}

// A partition may be thinner than a cell, and own none.
TEST(CellOwners, TheOwnerOfACellContainsItsCentreAndHasAllOfItsPoints) {
  for (const Index3 cells : {Index3{7, 5, 6}, Index3{1, 1, 1}, Index3{1, 1, 20}}) {
    const Grid grid = gridWithCells(cells);
    for (const Cut& cut : cutsOf(grid.box())) {
      const auto fields = compiledOn(grid, cut.partitioning);
      for (int64_t k = 0; k < cells[2]; k++)
        for (int64_t j = 0; j < cells[1]; j++)
          for (int64_t i = 0; i < cells[0]; i++) {
            const int owner = fields->partitionOf({i, j, k});
            const glm::dvec3 centre = grid.origin + grid.spacing * (glm::dvec3(i, j, k) + 0.5);
            ASSERT_EQ(owner, cut.partitioning.locate(centre)) << cut.name;
            const Extent* block = fields->extentOf(owner);
            ASSERT_NE(block, nullptr) << cut.name;
            const Index3 cell{i, j, k};
            for (size_t a = 0; a < 3; a++) {
              ASSERT_LE(block->first[a], cell[a]) << cut.name;
              ASSERT_GE(block->first[a] + block->points[a], cell[a] + 2) << cut.name;
            }
          }
    }
  }
}

TEST(CellOwners, CellsOfARimWhoseCentresLieOnTheEndOfTheDomainHaveOwners) {
  Grid grid = gridWithCells({6, 6, 6});
  grid.rim = true;
  const Cut cut = lattice(grid.box(), {2, 2, 2}, 1);
  const auto fields = compiledOn(grid, cut.partitioning);
  for (int64_t i = 0; i < 6; i++) {
    const int owner = fields->partitionOf({i, 0, 5});
    ASSERT_GE(owner, 0);
    const Extent* block = fields->extentOf(owner);
    EXPECT_LE(block->first[0], i);
    EXPECT_GE(block->first[0] + block->points[0], i + 2);
  }
}

TEST(Seeds, APointOnAFaceIsInTheUpperCellAndTheUpperEndInTheLast) {
  const Grid grid = gridWithCells({5, 4, 8});
  const auto fields = compiledOn(grid, Partitioning::single(grid.box()));
  CompiledFields::Place place;
  for (int64_t i = 0; i <= 5; i++) {
    ASSERT_TRUE(fields->locate(grid.origin + grid.spacing * glm::dvec3(i, 0, 8), place));
    EXPECT_EQ(place.cell, (Index3{std::min<int64_t>(i, 4), 0, 7}));
    EXPECT_EQ(place.fraction[0], i == 5 ? 1 : 0);
    EXPECT_EQ(place.fraction[1], 0);
    EXPECT_EQ(place.fraction[2], 1);
  }
}

TEST(Seeds, TheClosedDomainIsInsideWhereverItLies) {
  Random random(4);
  for (const double shift : {0.0, 1e6, -3e7})
    for (const double scale : {1.0, 1e-30, 1e30}) {
      const glm::dvec3 lo = glm::dvec3(shift) * scale, hi = (glm::dvec3(shift) + glm::dvec3(1, 2, 3)) * scale;
      const Grid grid = gridOver(lo, hi, {7, 12, 3});
      const auto fields = compiledOn(grid, Partitioning::single(grid.box()));
      const Box box = grid.box();
      CompiledFields::Place place;
      for (int corner = 0; corner < 8; corner++) {
        const glm::dvec3 p(corner & 1 ? box.hi.x : box.lo.x, corner & 2 ? box.hi.y : box.lo.y,
                           corner & 4 ? box.hi.z : box.lo.z);
        EXPECT_TRUE(fields->locate(p, place)) << shift << " " << scale;
        EXPECT_FALSE(fields->locate(p + (p - (box.lo + box.hi) / 2.0) * 1e-3, place))
            << shift << " " << scale;
      }
      for (int i = 0; i < 100; i++) {
        const glm::dvec3 p = box.lo + (box.hi - box.lo) * random.point(0, 1);
        ASSERT_TRUE(fields->locate(p, place));
        const glm::dvec3 back =
            fields->worldOf(place.cell, {place.fraction[0], place.fraction[1], place.fraction[2]});
        for (int a = 0; a < 3; a++)
          EXPECT_NEAR(back[a], p[a], 1e-7 * grid.spacing[a] + 1e-15 * std::abs(p[a]));
      }
    }
}

TEST(Seeds, PointsThatAreNotFiniteOrOutsideEndAsOutsideInEachDirection) {
  const Grid grid = gridWithCells({5, 4, 8});
  const auto fields = compiledOn(grid, Partitioning::single(grid.box()));
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<glm::dvec3> seeds{{NAN, 1.5, 1}, {0, inf, 1}, {0, 1.5, -inf}, {0, 1.5, 4.1}, {0, 1.5, 4}};
  const std::vector<uint64_t> ids{10, 11, 12, 13, 14};
  const SeedHeads both = fields->seeds(seeds, ids, TraceDirection::Both);
  ASSERT_EQ(both.ends.size(), 8u);
  for (size_t i = 0; i < 8; i++) {
    EXPECT_EQ(both.ends[i].line, 10 + i / 2);
    EXPECT_EQ(both.ends[i].backward, i % 2 == 1);
    EXPECT_EQ(both.ends[i].reason, EndReason::Outside);
    EXPECT_EQ(both.ends[i].points, 0);
  }
  ASSERT_EQ(both.heads.size(), 1u);
  EXPECT_EQ(both.heads[0].size(), 2);
  EXPECT_EQ(fields->seeds(seeds, ids, TraceDirection::Backward).heads[0].size(), 1);
  EXPECT_EQ(fields->seeds({}, {}, TraceDirection::Forward).heads.size(), 0u);
  EXPECT_THROW(fields->seeds(seeds, std::vector<uint64_t>{1}, TraceDirection::Forward), Error);
  const std::vector<uint64_t> large(5, kLastLine + 1);
  EXPECT_THROW(fields->seeds(seeds, large, TraceDirection::Forward), Error);
}

std::string errorOf(const std::function<void()>& f) {
  try {
    f();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(CompiledFields, VolumesThatLinesCannotReadAreRefusedWithWhatToDo) {
  const Grid grid = gridWithCells({5, 4, 8});
  const auto cut = std::make_shared<const Partitioning>(Partitioning::single(grid.box()));
  const auto vectors = volumeOf(grid, *cut, 3, kOnes);
  const auto compile = [&](std::vector<std::shared_ptr<const Volume>> volumes) {
    return errorOf([&] { CompiledFields(std::move(volumes), cut); });
  };
  const auto scalar = volumeOf(grid, *cut, 1, [](glm::dvec3) { return std::vector<double>{1}; });
  EXPECT_NE(compile({scalar}).find("[u, v, w]"), std::string::npos);
  EXPECT_NE(compile({}).find("1 to 8"), std::string::npos);
  EXPECT_NE(compile(std::vector(9, vectors)).find("1 to 8"), std::string::npos);
  const Grid finer = gridWithCells({10, 8, 16});
  const auto other = volumeOf(finer, *cut, 1, [](glm::dvec3) { return std::vector<double>{1}; });
  EXPECT_NE(compile({vectors, other}).find("resample"), std::string::npos);
  EXPECT_EQ(compile({vectors, scalar, vectors}), "");
}

TEST(TraceOptions, WrongOptionsAreRefusedByName) {
  const Grid grid = gridWithCells({5, 4, 8});
  const auto fields = compiledOn(grid, Partitioning::single(grid.box()));
  const auto error = [&](const TraceOptions& o) { return errorOf([&] { checkOptions(o, *fields); }); };
  EXPECT_EQ(error({}), "");
  EXPECT_NE(error({.tolerance = 0}).find("tolerance"), std::string::npos);
  EXPECT_NE(error({.tolerance = NAN}).find("tolerance"), std::string::npos);
  EXPECT_NE(error({.time = -1}).find("time"), std::string::npos);
  EXPECT_NE(error({.length = NAN}).find("length"), std::string::npos);
  EXPECT_NE(error({.steps = -1}).find("steps"), std::string::npos);
  EXPECT_NE(error({.minimumSpeed = -1}).find("minimum speed"), std::string::npos);
  EXPECT_NE(error({.points = PointsMode::EqualTime}).find("interval"), std::string::npos);
  EXPECT_NE(error({.condition = TraceCondition{0, 0, 1}}).find("condition"), std::string::npos);
}

}  // namespace
}  // namespace gxy::test
