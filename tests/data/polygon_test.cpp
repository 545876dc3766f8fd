// SPDX-License-Identifier: Apache-2.0
#include "core/data/polygon.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace gxy {
namespace {

using Outline = std::vector<glm::dvec3>;
using CutTriangles = std::vector<std::array<uint32_t, 3>>;

CutTriangles trianglesOf(const Outline& corners) {
  CutTriangles triangles;
  triangulate(corners, triangles);
  return triangles;
}

/// The areas of the triangles, each with the sign of its side of z, so that overlaps show in what `size` of them says.
struct Areas {
  double sum = 0, size = 0;
};
Areas areasOf(const Outline& corners) {
  Areas areas;
  for (const auto& [a, b, c] : trianglesOf(corners)) {
    const double z = glm::cross(corners[b] - corners[a], corners[c] - corners[a]).z / 2;
    areas.sum += z;
    areas.size += std::abs(z);
  }
  return areas;
}

TEST(Polygon, ConvexOnesAreFansFromTheFirstCorner) {
  EXPECT_EQ(trianglesOf({{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {0, 1, 0}}), (CutTriangles{{0, 1, 2}, {0, 2, 3}}));
  Outline circle;
  for (int i = 0; i < 12; ++i) circle.push_back({std::cos(i * 0.5), std::sin(i * 0.5), 7});
  const CutTriangles triangles = trianglesOf(circle);
  ASSERT_EQ(triangles.size(), 10u);
  for (uint32_t i = 0; i < 10; ++i) EXPECT_EQ(triangles[i], (std::array<uint32_t, 3>{0, i + 1, i + 2}));
  EXPECT_TRUE(trianglesOf({{0, 0, 0}, {1, 0, 0}}).empty());
}

TEST(Polygon, ConcaveOnesAreCoveredOnceWhicheverCornerComesFirst) {
  const Outline l{{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
  const Outline arrow{{0, 0, 0}, {2, -1, 0}, {0.5, 0, 0}, {2, 1, 0}};
  Outline star;
  for (int i = 0; i < 40; ++i) {
    const double r = i % 2 ? 1 : 3, angle = i * std::acos(-1.) / 20;
    star.push_back({r * std::cos(angle), r * std::sin(angle), 0});
  }
  for (const auto& [polygon, area] :
       {std::pair(l, 3.), std::pair(arrow, 0.5), std::pair(star, 20 * 3 * std::sin(std::acos(-1.) / 20))})
    for (const bool reversed : {false, true})
      for (size_t first = 0; first < polygon.size(); ++first) {
        Outline corners = polygon;
        std::rotate(corners.begin(), corners.begin() + std::ptrdiff_t(first), corners.end());
        if (reversed) std::reverse(corners.begin(), corners.end());
        EXPECT_EQ(trianglesOf(corners).size(), corners.size() - 2);
        EXPECT_NEAR(areasOf(corners).sum, reversed ? -area : area, 1e-12) << first;
        EXPECT_NEAR(areasOf(corners).size, area, 1e-12) << first;
      }
}

TEST(Polygon, ABridgeLeadsToAHole) {
  const Outline frame{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0},
                      {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}};
  EXPECT_NEAR(areasOf(frame).sum, 12, 1e-12);
  EXPECT_NEAR(areasOf(frame).size, 12, 1e-12);
}

TEST(Polygon, QuadsThatAreNotPlanarAreCutAlongTheShorterDiagonal) {
  EXPECT_EQ(trianglesOf({{0, 0, 0}, {1, 0, 1}, {1, 1, 0}, {0, 1, 0}}), (CutTriangles{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(trianglesOf({{0, 0, 1}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}), (CutTriangles{{0, 1, 3}, {1, 2, 3}}));
}

TEST(Polygon, LongOutlinesOfManyNotchesAreCoveredOnce) {
  Outline comb;
  constexpr int kTeeth = 5000;
  for (int i = 0; i < kTeeth; ++i) comb.insert(comb.end(), {{i, 1, 0}, {i + 0.5, 2, 0}});
  comb.insert(comb.end(), {{kTeeth, 1, 0}, {kTeeth, 0, 0}, {0, 0, 0}});
  EXPECT_NEAR(areasOf(comb).size, kTeeth * 1.5, 1e-6);
}

TEST(Polygon, OnesWithoutAnAreaOrThatCrossThemselvesStillBecomeTwoTrianglesFewer) {
  for (const Outline& corners : {Outline{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, Outline(7, {1, 2, 3}),
                                 Outline{{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1.5, 0}, {0.5, 3, 0}},
                                 Outline{{0, 0, 0}, {NAN, 1, 0}, {1, 0, 0}, {0, 1.5, 0}}})
    EXPECT_EQ(trianglesOf(corners).size(), corners.size() - 2);
}

}  // namespace
}  // namespace gxy
