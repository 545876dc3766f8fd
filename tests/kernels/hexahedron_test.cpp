// SPDX-License-Identifier: Apache-2.0
// Hexahedra with bilinear sides: where rays pass them, and what is between.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <utility>

#include "core/kernels/single.h"
#include "core/kernels/twin.h"
#include "tests/kernels/random.h"

namespace gxy {
namespace {

using test::Random;

constexpr uint32_t kSides = 6;

/// A cube about the ray whose corners are moved by up to `far` of its side; sides begin anywhere and go around either way.
template <class Hexahedron, class Vec4>
Hexahedron drawn(Random& random, double far) {
  std::array<Vec4, 8> c;
  for (int k = 0; k < 8; k++) {
    const double x = ((k ^ k >> 1) & 1) - 0.5, y = (k >> 1 & 1) - 0.5, z = (k >> 2 & 1) - 0.5;
    c[size_t(k)] =
        Vec4(x + random.in(-far, far), y + random.in(-far, far), z + random.in(-far, far), random.in(-1, 1));
  }
  const glm::dvec2 by(random.in(-0.5, 0.5), random.in(-0.5, 0.5));
  for (Vec4& corner : c) corner.x += by.x, corner.y += by.y;
  return {c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7]};
}

TEST(Hexahedron, PointsOfSidesAreOnTheRayAndInTheSide) {
  Random random(1);
  int passed = 0;
  for (int i = 0; i < 20000; i++) {
    const auto h = drawn<twin::Hexahedron, glm::dvec4>(random, 0.3);
    const auto orders = uint32_t(random.bits()) & 0x777777u;
    const uint32_t signs = twin::sideSigns(h);
    for (uint32_t side = 0; side < kSides; side++) {
      if (twin::signOf(signs, side) == 0) continue;
      passed++;
      const auto p = twin::sidePoint(h, side, orders);
      const glm::dvec4 there =
          twin::trilinearIn(h, twin::referencePlace(twin::orderedCorners(side, orders), p.u, p.v));
      ASSERT_LT(std::abs(there.x) + std::abs(there.y), 1e-7) << i << ", side " << side;
      ASSERT_NEAR(there.z, p.z, 1e-12);
      ASSERT_NEAR(there.w, p.value, 1e-12);
    }
  }
  EXPECT_GT(passed, 30000);
}

TEST(Hexahedron, SignsOfSidesAddUpToNothing) {
  Random random(2);
  for (int i = 0; i < 50000; i++) {
    const uint32_t signs = single::sideSigns(drawn<single::Hexahedron, glm::vec4>(random, i % 2 ? 0.3 : 1.5));
    int sum = 0;
    for (uint32_t side = 0; side < kSides; side++) sum += single::signOf(signs, side);
    ASSERT_EQ(sum, 0);
  }
}

// So a walk from cell to cell is a path, and ends.
TEST(Hexahedron, EachPassageIsPairedWithOneOtherAndBack) {
  Random random(3);
  int many = 0;
  for (int i = 0; i < 50000; i++) {
    const auto h = drawn<single::Hexahedron, glm::vec4>(random, i % 2 ? 0.6 : 1.5);
    const auto orders = uint32_t(random.bits()) & 0x777777u;
    const uint32_t signs = single::sideSigns(h);
    many += single::timesPassed(signs) > 2;
    for (uint32_t side = 0; side < kSides; side++) {
      const int sign = single::signOf(signs, side);
      for (int turn = 0; turn < std::abs(sign); turn++) {
        int passage = turn;
        const uint32_t to = single::pairedSide(h, orders, signs, side, passage);
        ASSERT_NE(to, side);
        ASSERT_LT(single::signOf(signs, to) * sign, 0);
        if (single::timesPassed(signs) == 2) {
          ASSERT_EQ(to, single::sideOfSign(signs, -sign));
        }
        ASSERT_EQ(single::pairedSide(h, orders, signs, to, passage), side);
        ASSERT_EQ(passage, turn);
      }
    }
  }
  EXPECT_GT(many, 2000);
}

// Two cells have the corners of their common side in other places and the other way around, but take them in the same order.
TEST(Hexahedron, BothCellsOfASideFindTheSameBits) {
  Random random(4);
  int passed = 0;
  for (int i = 0; i < 20000; i++) {
    const auto h = drawn<single::Hexahedron, glm::vec4>(random, 0.6);
    const auto g = drawn<single::Hexahedron, glm::vec4>(random, 0.6);
    const std::array<glm::vec4, 8> corners{h.c0, h.c1, h.c2, h.c3, h.c4, h.c5, h.c6, h.c7};
    std::array<glm::vec4, 8> others{g.c0, g.c1, g.c2, g.c3, g.c4, g.c5, g.c6, g.c7};
    const uint32_t side = uint32_t(random.below(6)), other = uint32_t(random.below(6));
    const uint32_t begin = uint32_t(random.below(4));
    const uint32_t own = single::sideCorners(side), its = single::sideCorners(other);
    // corner k of the side is corner begin - k of the other one
    for (uint32_t k = 0; k < 4; k++) others[its >> 4 * ((begin + 4 - k) % 4) & 7] = corners[own >> 4 * k & 7];
    const single::Hexahedron next{others[0], others[1], others[2], others[3],
                                  others[4], others[5], others[6], others[7]};
    const int sign = single::signOf(single::sideSigns(h), side);
    ASSERT_EQ(single::signOf(single::sideSigns(next), other), -sign);
    if (sign == 0) continue;
    passed++;
    const uint32_t first = uint32_t(random.below(4)), way = uint32_t(random.below(2));
    const auto p = single::sidePoint(h, side, (first | way << 2) << 4 * side);
    const auto q = single::sidePoint(next, other, ((begin + 4 - first) % 4 | (1 - way) << 2) << 4 * other);
    ASSERT_EQ(p.z, q.z);
    ASSERT_EQ(p.value, q.value);
    ASSERT_EQ(p.u, q.u);
    ASSERT_EQ(p.v, q.v);
  }
  EXPECT_GT(passed, 4000);
}

TEST(Hexahedron, CubicsAreExactInParallelepipeds) {
  Random random(5);
  int checked = 0;
  for (int i = 0; i < 5000; i++) {
    auto h = drawn<twin::Hexahedron, glm::dvec4>(random, 0);
    const glm::dmat3 shear(random.in(0.8, 1.2), random.in(-0.3, 0.3), random.in(-0.3, 0.3),
                           random.in(-0.3, 0.3), random.in(0.8, 1.2), random.in(-0.3, 0.3),
                           random.in(-0.3, 0.3), random.in(-0.3, 0.3), random.in(0.8, 1.2));
    for (glm::dvec4* c : {&h.c0, &h.c1, &h.c2, &h.c3, &h.c4, &h.c5, &h.c6, &h.c7})
      *c = glm::dvec4(shear * glm::dvec3(*c), c->w);
    const uint32_t signs = twin::sideSigns(h);
    if (twin::timesPassed(signs) != 2) continue;
    const uint32_t from = twin::sideOfSign(signs, 1), to = twin::sideOfSign(signs, -1);
    const auto p = twin::sidePoint(h, from, 0), q = twin::sidePoint(h, to, 0);
    if (std::abs(q.z - p.z) < 0.01) continue;
    checked++;
    const glm::dvec4 cubic =
        twin::cubicBetween(h, p, twin::referencePlace(twin::orderedCorners(from, 0), p.u, p.v), q,
                           twin::referencePlace(twin::orderedCorners(to, 0), q.u, q.v), q.z - p.z, -10, 10);
    for (const double u : {0.2, 0.5, 0.9}) {
      auto moved = h;
      for (glm::dvec4* c :
           {&moved.c0, &moved.c1, &moved.c2, &moved.c3, &moved.c4, &moved.c5, &moved.c6, &moved.c7})
        c->z -= p.z + u * (q.z - p.z);
      const double expected = twin::trilinearIn(moved, twin::coordinatesOfOrigin(moved)).w;
      ASSERT_NEAR(twin::bernsteinValue(cubic, u), expected, 1e-9) << i;
    }
  }
  EXPECT_GT(checked, 2000);
}

// A side that the ray runs in: the place is on the ray, so that nothing lies beside what it meets.
TEST(Hexahedron, SidesSeenEdgeOnAreMetOnTheRay) {
  Random random(7);
  int met = 0;
  for (int i = 0; i < 20000; i++) {
    std::array<glm::vec4, 4> c;
    const double angle = random.in(0, 7);
    for (glm::vec4& p : c) {
      const double along = random.below(5) == 0 ? 0 : random.in(-1, 1);
      p = glm::vec4(along * std::cos(angle), along * std::sin(angle), random.in(-1, 1), random.in(-1, 1));
    }
    const auto beside = [&](const glm::vec4& p) { return p.x * std::cos(angle) + p.y * std::sin(angle); };
    double low = 1, high = -1;
    const size_t corners = i % 2 ? 4 : 3;
    for (size_t k = 0; k < corners; k++)
      low = std::min(low, beside(c[k])), high = std::max(high, beside(c[k]));
    if (low > 0 || high < 0) continue;
    met++;
    const auto p =
        corners == 4 ? single::patchPoint(c[0], c[1], c[2], c[3]) : single::trianglePoint(c[0], c[1], c[2]);
    const glm::vec4 last = corners == 4 ? c[3] : c[2];
    const glm::vec4 there =
        single::lerp4(single::lerp4(c[0], c[1], p.u), single::lerp4(last, c[2], p.u), p.v);
    ASSERT_LT(std::abs(there.x) + std::abs(there.y), 1e-5) << i;
    ASSERT_NEAR(there.z, p.z, 1e-5);
    ASSERT_NEAR(there.w, p.value, 1e-5);
    if (corners == 4) continue;
    const auto q = single::trianglePoint(c[2], c[0], c[1]), r = single::trianglePoint(c[1], c[0], c[2]);
    ASSERT_TRUE(p.z == q.z && p.value == q.value && p.z == r.z && p.value == r.value) << i;
  }
  EXPECT_GT(met, 8000);
}

// Wedges, pyramids and tetrahedra: what is linear in space is linear along the ray.
TEST(Hexahedron, LinearNumbersAreLinearAlongRaysWithRepeatedCorners) {
  Random random(6);
  constexpr std::array<std::array<int, 8>, 3> kRepeated{
      {{0, 1, 2, 2, 4, 5, 6, 6}, {0, 1, 2, 3, 4, 4, 4, 4}, {0, 1, 2, 2, 4, 4, 4, 4}}};
  int checked = 0;
  for (int i = 0; i < 20000; i++) {
    const auto h = drawn<twin::Hexahedron, glm::dvec4>(random, 0.2);
    std::array<glm::dvec4, 8> c{h.c0, h.c1, h.c2, h.c3, h.c4, h.c5, h.c6, h.c7};
    for (glm::dvec4& p : c) p.w = 0.3 * p.x - 0.2 * p.y + 0.5 * p.z;
    const auto& is = kRepeated[size_t(i) % 3];
    const auto at = [&](size_t k) { return c[size_t(is[k])]; };
    const twin::Hexahedron cell{at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7)};
    uint32_t orders = 0;
    for (uint32_t side = 0; side < kSides; side++) {
      const uint32_t corners = twin::sideCorners(side);
      for (uint32_t k = 0; k < 4; k++)
        if (is[corners >> 4 * k & 7] == is[corners >> 4 * ((k + 1) % 4) & 7]) {
          orders |= ((k + 2) % 4 | 8) << 4 * side;
          break;
        }
    }
    const uint32_t signs = twin::sideSigns(cell);
    if (twin::timesPassed(signs) != 2) continue;
    const uint32_t from = twin::sideOfSign(signs, 1), to = twin::sideOfSign(signs, -1);
    const auto p = twin::sidePoint(cell, from, orders), q = twin::sidePoint(cell, to, orders);
    const double length = q.z - p.z;
    ASSERT_NEAR(p.value, 0.5 * p.z, 1e-12);
    if (std::abs(length) < 0.05) continue;
    checked++;
    const glm::dvec4 cubic =
        twin::cubicBetween(cell, p, twin::referencePlace(twin::orderedCorners(from, orders), p.u, p.v), q,
                           twin::referencePlace(twin::orderedCorners(to, orders), q.u, q.v), length, -10, 10);
    ASSERT_NEAR(cubic.y, p.value + 0.5 * length / 3, 1e-7) << i;
    ASSERT_NEAR(cubic.z, q.value - 0.5 * length / 3, 1e-7) << i;
  }
  EXPECT_GT(checked, 4000);
}

}  // namespace
}  // namespace gxy
