// SPDX-License-Identifier: Apache-2.0
// Values of unstructured volumes at points: Interpolate and Resample.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>

#include "core/analysis/interpolate_filter.h"
#include "core/analysis/mesh_reader.h"
#include "core/analysis/resample_filter.h"
#include "core/analysis/seeds_filter.h"
#include "core/data/bricks.h"
#include "tests/analysis/filter_setup.h"
#include "tests/support/cell_meshes.h"
#include "tests/support/meshes.h"

namespace gxy::test {
namespace {

double linear(glm::dvec3 p) { return 3 + 2 * p.x - p.y + 0.5 * p.z; }

/// Cells of all types in [0, 1]^3, whose points inside are moved, so that faces of four corners are bent.
WholeMesh bentMesh(uint32_t n) {
  WholeMesh whole;
  const auto bend = [](glm::dvec3 p) {
    const double in = 64 * p.x * (1 - p.x) * p.y * (1 - p.y) * p.z * (1 - p.z);
    return 0.07 * in * glm::dvec3(std::sin(40 * p.y), std::cos(31 * p.z), std::sin(27 * p.x));
  };
  whole.cells = cubeOfAllCells(n, bend, linear);
  return whole;
}

std::shared_ptr<Dataset> datasetOf(const WholeMesh& whole, const Cut& cut, int rank) {
  const auto made = std::make_shared<Dataset>();
  made->partitioning = std::make_shared<const Partitioning>(cut.partitioning);
  made->mesh = test::cut(whole, cut.partitioning, cut.ranks)[size_t(rank)];
  return made;
}

Box unitBox() { return {{0, 0, 0}, {1, 1, 1}}; }

MadePoints interpolated(const WholeMesh& whole, const Cut& cut, const std::string& seeds) {
  return made<Interpolate>(
      cut,
      [&](Collectives& ranks) {
        const auto mesh = datasetOf(whole, cut, ranks.rank());
        FilterRun run(ranks, {{"domain", {{"v", {}, 1, mesh}}}}, freeServices());
        return FilterRun::Inputs{
            {"points", {{"p", {}, 1, evaluate(*makeFilter<Seeds>(), run, seeds).dataset}}},
            {"fields", {{"f", {}, 1, mesh}}}};
      },
      "{}");
}

TEST(MeshValues, OfALinearFieldAreTheFieldInCellsOfAllTypes) {
  const MadePoints made = interpolated(bentMesh(6), lattice(unitBox(), {2, 2, 2}, 3),
                                       R"({"shape": "box", "count": 5000, "seed": 4})");
  ASSERT_EQ(made.points.size(), 5000u) << made.error;
  EXPECT_EQ(made.told.at("outside"), 0);
  EXPECT_EQ(made.told.at("no data"), 0);
  for (const auto& [id, p] : made.points) ASSERT_NEAR(p.value, linear(p.point), 2e-6);
}

TEST(MeshValues, AreTheSameOnAnyRanksAndCuts) {
  WholeMesh whole = bentMesh(5);
  for (size_t i = 0; i < whole.cells.values.size(); i++) whole.cells.values[i] = float(i * 7919 % 101);
  // Among these are points of the mesh, and points on edges and faces of cells, so that several cells have them.
  const std::string seeds = R"({"shape": "grid", "dimensions": [15, 10, 10]})";
  const auto one = interpolated(whole, test::whole(unitBox()), seeds).points;
  ASSERT_EQ(one.size(), 1500u);
  for (const Cut& cut : manyCuts(unitBox(), 3))
    EXPECT_EQ(interpolated(whole, cut, seeds).points, one) << cut.name;
}

TEST(MeshValues, AtPointsOfTheMeshAreThoseOfThePoints) {
  WholeMesh whole;
  const auto stays = [](glm::dvec3) { return glm::dvec3(0); };
  whole.cells = cubeOfAllCells(4, stays, [](glm::dvec3 p) { return std::sin(9 * p.x) + p.y * p.z; });
  const MadePoints made = interpolated(
      whole, lattice(unitBox(), {3, 1, 1}, 2),
      R"({"shape": "points", "points": [[0, 0, 0], [1, 1, 1], [0.25, 0.5, 0.75], [1, 0, 0.5]]})");
  ASSERT_EQ(made.points.size(), 4u) << made.error;
  for (const auto& [id, p] : made.points)
    EXPECT_NEAR(p.value, std::sin(9 * p.point.x) + p.point.y * p.point.z, 1e-6);
}

TEST(MeshValues, InHolesAndWithoutDataAreNothingAndAreCounted) {
  WholeMesh whole;
  const auto stays = [](glm::dvec3) { return glm::dvec3(0); };
  whole.cells = cubeOfHexes(4, stays, linear);
  auto& hexes = whole.cells.cells.points[size_t(CellType::Hexahedron)];
  hexes.erase(hexes.begin() + 8 * 21, hexes.begin() + 8 * 22);  // the cell (1, 1, 1)
  whole.cells.values[0] = std::numeric_limits<float>::quiet_NaN();
  const MadePoints made = interpolated(
      whole, lattice(unitBox(), {2, 2, 1}, 3),
      R"({"shape": "points", "points": [[0.3, 0.4, 0.4], [0.1, 0.1, 0.1], [0.6, 0.4, 0.4], [1.1, 0, 0], [0.5, 0.4, 0.4]]})");
  ASSERT_EQ(made.points.size(), 5u) << made.error;
  for (const uint64_t i : {0, 1, 3}) EXPECT_TRUE(std::isnan(made.points.at(i).value)) << i;
  EXPECT_FLOAT_EQ(made.points.at(2).value, float(linear({0.6, 0.4, 0.4})));
  EXPECT_FLOAT_EQ(made.points.at(4).value, float(linear({0.5, 0.4, 0.4}))) << "the hole's face has a cell";
  EXPECT_EQ(made.told.at("outside"), 2);
  EXPECT_EQ(made.told.at("no data"), 1);
}

TEST(MeshValues, OfCellsAreAveragesButNotInACellWithoutAValue) {
  WholeMesh whole = bentMesh(4);
  whole.cells = withCellValues(std::move(whole.cells), linear);
  const MadePoints made =
      interpolated(whole, lattice(unitBox(), {2, 2, 2}, 3), R"({"shape": "box", "count": 500, "seed": 7})");
  ASSERT_EQ(made.points.size(), 500u) << made.error;
  for (const auto& [id, p] : made.points) {
    const glm::dvec3 at = glm::abs(p.point - 0.5);
    if (std::max({at.x, at.y, at.z}) < 0.2) {
      EXPECT_NEAR(p.value, linear(p.point), 1e-4);
    }
  }
  EXPECT_EQ(made.told.at("no data"), 0);
  for (auto& values : whole.cells.cellValues)
    for (float& value : values) value = std::numeric_limits<float>::quiet_NaN();
  const MadePoints none =
      interpolated(whole, lattice(unitBox(), {2, 1, 1}, 2), R"({"shape": "box", "count": 50, "seed": 7})");
  EXPECT_EQ(none.told.at("no data"), 50);
}

// The last points of a grid are outside of its box by a rounding.
TEST(MeshValues, AtTheEndsOfAnyBoxAreInside) {
  for (const double side : {0.1, 0.7, 1.9997782}) {
    WholeMesh whole = bentMesh(2);
    const glm::dvec3 lo(-1.1592917432800351, -0.70628847280417872, 0.3);
    for (glm::dvec3& p : whole.cells.points) p = lo + side * p;
    const Cut cut = test::whole({lo, lo + side});
    ThreadRanks world(1);
    const auto errors = world.run([&](Collectives& ranks) {
      for (const char* dimensions : {R"({"dimensions": [7, 11, 14]})", R"({"dimensions": [24, 48, 50]})"}) {
        FilterRun run(ranks, {{"field", {{"f", {}, 1, datasetOf(whole, cut, 0)}}}}, freeServices());
        EXPECT_EQ(evaluate(*makeFilter<Resample>(), run, dimensions).told.at("outside"), 0) << side;
      }
    });
    EXPECT_EQ(errors[0], "");
  }
}

TEST(MeshValues, OfAFlatMeshAreNotResampledWithoutABox) {
  WholeMesh whole = bentMesh(2);
  for (glm::dvec3& p : whole.cells.points) p.z = 0.5;
  const Cut cut = test::whole(unitBox());
  ThreadRanks world(1);
  const auto errors = world.run([&](Collectives& ranks) {
    FilterRun run(ranks, {{"field", {{"f", {}, 1, datasetOf(whole, cut, 0)}}}}, freeServices());
    evaluate(*makeFilter<Resample>(), run, "{}");
  });
  EXPECT_NE(errors[0].find("\"f\" has no cells or is flat"), std::string::npos) << errors[0];
}

TEST(MeshValues, OnAGridAreWhatResampleMakes) {
  const WholeMesh whole = bentMesh(5);
  for (const Cut& cut : {lattice(unitBox(), {2, 2, 2}, 3), kdCut(unitBox(), 5, 4, 9)}) {
    ThreadRanks world(cut.ranks);
    std::mutex mutex;
    uint64_t points = 0;
    const auto errors = world.run([&](Collectives& ranks) {
      FilterRun run(ranks, {{"field", {{"f", {}, 1, datasetOf(whole, cut, ranks.rank())}}}}, freeServices());
      const FilterResult result = evaluate(*makeFilter<Resample>(), run, R"({"dimensions": [12, 9, 7]})");
      const Volume& v = *result.dataset->volume;
      const std::lock_guard lock(mutex);
      EXPECT_EQ(result.told.at("outside"), 0);
      for (const auto& [partition, block] : v.blocks) {
        const Bricks bricks(block.extent.points);
        for (int64_t i = 0; i < block.extent.count(); i++) {
          const Index3& n = block.extent.points;
          const Index3 at{i % n[0], i / n[0] % n[1], i / n[0] / n[1]};
          float value;
          std::memcpy(&value, &block.samples[bricks(at[0], at[1], at[2]) * sizeof value], sizeof value);
          const Index3& first = block.extent.first;
          const glm::dvec3 p =
              v.grid.origin + v.grid.spacing * glm::dvec3(double(first[0] + at[0]), double(first[1] + at[1]),
                                                          double(first[2] + at[2]));
          EXPECT_NEAR(value, linear(p), 2e-6);
          points++;
        }
      }
    });
    for (const std::string& error : errors) EXPECT_EQ(error, "");
    EXPECT_GE(points, 12u * 9 * 7) << cut.name;
  }
}

TEST(MeshValues, AreRefusedWhereAGridIsNeeded) {
  const Cut cut = test::whole(unitBox());
  ThreadRanks world(1);
  const auto errors = world.run([&](Collectives& ranks) {
    FilterRun run(ranks,
                  {{"field", {{"f", {}, 1, datasetOf(bentMesh(2), cut, 0)}}},
                   {"like", {{"l", {}, 1, datasetOf(bentMesh(2), cut, 0)}}}},
                  freeServices());
    evaluate(*makeFilter<Resample>(), run, "{}");
  });
  EXPECT_NE(errors[0].find("\"l\" is an unstructured volume"), std::string::npos) << errors[0];
}

}  // namespace
}  // namespace gxy::test
