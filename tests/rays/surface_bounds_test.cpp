// SPDX-License-Identifier: Apache-2.0
// The boxes of surfaces in tetrahedra: small, and no hit is outside of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/rays/primitive_bounds.h"
#include "tests/agreement/scene_single.h"
#include "tests/kernels/random.h"

namespace gxy {
namespace {

using test::Random;

/// Four corners, x y z level each.
using Cell = std::array<glm::vec4, 4>;

PrimitiveBounds boundsOf(const Cell& cell) { return surfaceBounds(&cell[0].x); }

/// Whether a ray meets a box between t = 0 and `far`, as the trees of the backends test it.
bool meets(const PrimitiveBounds& box, const glm::vec3& o, const glm::vec3& d, float far) {
  float enter = 0, leave = far;
  for (int k = 0; k < 3; k++) {
    const float per = single::parallelTo(d[k]) ? (d[k] < 0 ? -1e37f : 1e37f) : 1 / d[k];
    const bool back = d[k] < 0;
    enter = std::max(enter, ((back ? box.hi[k] : box.lo[k]) - o[k]) * per);
    leave = std::min(leave, ((back ? box.lo[k] : box.hi[k]) - o[k]) * per);
  }
  return enter <= leave + 1e-6f * std::abs(leave);
}

/// A cell of any shape, some of them slivers, some far from the origin; with levels of any size, some nearly 0 or 0.
Cell drawn(Random& random) {
  const glm::dvec3 middle = random.direction() * random.scale(1e-3, 1e3);
  const double size = random.scale(1e-2, 1), steep = random.scale(1e-6, 1e3);
  const glm::dvec3 flat = random.below(3) ? glm::dvec3(1) : glm::dvec3(1, random.scale(1e-6, 1), 1);
  Cell cell;
  for (glm::vec4& corner : cell) {
    const glm::dvec3 place = middle + size * flat * random.point(-1, 1);
    const double level = steep * random.in(-1, 1) * (random.below(2) ? 1 : random.scale(1e-9, 1));
    corner = glm::vec4(place, random.below(20) ? level : 0.0);
  }
  return cell;
}

TEST(SurfaceBounds, HoldEveryHit) {
  Random random(7);
  int hits = 0;
  for (int i = 0; i < 400'000; i++) {
    const Cell cell = drawn(random);
    const PrimitiveBounds box = boundsOf(cell);
    // The ray aims at a place near the surface, or in a face, an edge or a corner of the cell.
    std::array<double, 4> share{};
    for (double& s : share) s = random.below(3) ? random.unit() : 0;
    share[size_t(random.below(4))] += 1e-3;
    const double sum = share[0] + share[1] + share[2] + share[3];
    glm::dvec3 aim(0);
    for (size_t k = 0; k < 4; k++) aim += glm::dvec3(cell[k]) * (share[k] / sum);
    glm::dvec3 from = random.direction();
    if (random.below(4) == 0) from = glm::dvec3(0, 0, 1);
    const glm::vec3 d(-from), o(aim + from * random.scale(1e-2, 1e4));
    float t;
    if (!single::hitCell(single::frameRay(o, d), cell[0], cell[1], cell[2], cell[3], 0, t)) continue;
    hits++;
    ASSERT_TRUE(meets(box, o, d, t)) << i << ", t " << t;
  }
  EXPECT_GT(hits, 50'000);
}

TEST(SurfaceBounds, AreThoseOfThePolygon) {
  // Level 0 is at x + y + z = 0.25.
  const Cell cell{glm::vec4(0, 0, 0, -0.25f), glm::vec4(1, 0, 0, 0.75f), glm::vec4(0, 1, 0, 0.75f),
                  glm::vec4(0, 0, 1, 0.75f)};
  const PrimitiveBounds box = boundsOf(cell);
  for (int k = 0; k < 3; k++) {
    EXPECT_LE(box.lo[k], 0);
    EXPECT_GT(box.lo[k], -1e-5f);
    EXPECT_GE(box.hi[k], 0.25f);
    EXPECT_LT(box.hi[k], 0.25001f);
  }
}

TEST(SurfaceBounds, HoldAFaceThatIsInTheSurface) {
  const Cell cell{glm::vec4(0, 0, 0, 0), glm::vec4(2, 0, 0, 0), glm::vec4(0, 3, 0, 0), glm::vec4(0, 0, 4, 1)};
  const PrimitiveBounds box = boundsOf(cell);
  EXPECT_LE(box.lo[0], 0);
  EXPECT_GE(box.hi[0], 2);
  EXPECT_GE(box.hi[1], 3);
  EXPECT_LT(box.hi[2], 1e-4f);
}

}  // namespace
}  // namespace gxy
