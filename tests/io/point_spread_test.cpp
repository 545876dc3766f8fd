// SPDX-License-Identifier: Apache-2.0
// How points are spread, on any number of ranks.
#include "core/io/point_spread.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/io/fixtures.h"

namespace gxy {
namespace {

/// Points (i + 0.5) / side of a cube, and one far away; every `of`th of them.
LoadedGeometry cube(int side, glm::dvec3 far, int part = 0, int of = 1) {
  LoadedGeometry g;
  for (int n = 0; n <= side * side * side; n++) {
    const bool last = n == side * side * side;
    const glm::dvec3 p =
        last ? far : (glm::dvec3(n % side, n / side % side, n / side / side) + 0.5) / double(side);
    g.geometry.box.extend(p);
    if (n % of != part) continue;
    g.geometry.block.points.push_back(p);
    g.geometry.block.ids.push_back(uint64_t(n));
  }
  g.geometry.primitives = uint64_t(side * side * side + 1);
  return g;
}

TEST(PointSpread, OutliersDoNotCount) {
  SingleRank one;
  for (const double far : {0.5, 10.0, 1e6, 1e12}) {
    const PointSpread spread = spreadOf(cube(20, glm::dvec3(far)), one);
    EXPECT_NEAR(spread.spacing, 1.0 / 20, 0.1 / 20 + far * 1e-9) << far;
    for (int a = 0; a < 3; a++) {
      EXPECT_LE(spread.middle.lo[a], 0.025) << far;
      EXPECT_GE(spread.middle.hi[a], 0.975) << far;
      EXPECT_LE(spread.middle.hi[a], 1.3 + far * 1e-8) << far;
    }
  }
}

TEST(PointSpread, FlatAndSinglePoints) {
  SingleRank one;
  LoadedGeometry g;
  for (uint64_t n = 0; n < 400; n++) {
    g.geometry.block.points.push_back({double(n % 20), double(n / 20), 3});
    g.geometry.block.ids.push_back(n);
    g.geometry.box.extend(g.geometry.block.points.back());
  }
  g.geometry.primitives = 400;
  EXPECT_NEAR(spreadOf(g, one).spacing, 19.0 / 20, 0.05);  // of a plane
  EXPECT_EQ(spreadOf(g, one).middle, g.geometry.box);
  LoadedGeometry point;
  point.geometry.block.points = {{1, 2, 3}};
  point.geometry.block.ids = {0};
  point.geometry.box.extend(glm::dvec3(1, 2, 3));
  point.geometry.primitives = 1;
  EXPECT_EQ(spreadOf(point, one).spacing, 0);
  EXPECT_EQ(spreadOf(LoadedGeometry(), one).spacing, 0);
}

TEST(PointSpread, IsTheSameOnAnyNumberOfRanks) {
  SingleRank one;
  const PointSpread expected = spreadOf(cube(10, glm::dvec3(5000)), one);
  testing::ThreadRanks three(3);
  const auto errors = three.run([&](Collectives& ranks) {
    const PointSpread spread = spreadOf(cube(10, glm::dvec3(5000), ranks.rank(), 3), ranks);
    EXPECT_EQ(spread.middle, expected.middle);
    EXPECT_EQ(spread.spacing, expected.spacing);
  });
  for (const std::string& error : errors) EXPECT_EQ(error, "");
}

}  // namespace
}  // namespace gxy
