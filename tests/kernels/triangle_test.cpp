// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/kernels/mesh.h"
#include "tests/kernels/random.h"
#include "tests/support/seeds.h"

namespace gxy {
namespace {

using test::Random;

// Rays from inside the mesh (scaled, then shifted, then rounded to float), a third aimed at vertices, a third at points
// of edges. Returns how many of them meet no triangle.
int leaks(double scale, double shift, int rays, std::uint64_t seed) {
  test::Mesh mesh = test::icosphere();
  std::vector<glm::vec3> v;
  for (glm::dvec3 p : mesh.vertices) v.emplace_back(p * scale + shift);
  Random random(seed);
  int leaks = 0;
  for (int i = 0; i < rays; ++i) {
    glm::vec3 origin(scale * random.point(-0.3, 0.3) + shift);
    const auto& aim = mesh.triangles[std::size_t(random.below(int(mesh.triangles.size())))];
    glm::dvec3 a(v[aim[0]]), b(v[aim[1]]), c(v[aim[2]]);
    double along = random.unit();
    int kind = random.below(3);
    glm::dvec3 to = kind == 0   ? a
                    : kind == 1 ? glm::mix(a, b, along)
                                : glm::mix(glm::mix(a, b, along), c, random.unit());
    glm::vec3 direction(to - glm::dvec3(origin));
    auto met = [&](const std::array<int, 3>& t) {
      float distance, wb, wc;
      return single::hitTriangle(origin, direction, v[t[0]], v[t[1]], v[t[2]], 0, distance, wb, wc);
    };
    if (!met(aim) && std::none_of(mesh.triangles.begin(), mesh.triangles.end(), met)) ++leaks;
  }
  return leaks;
}

TEST(Triangle, NoRayLeaksFromAClosedMesh) { EXPECT_EQ(leaks(1, 0, test::sweep(1'000'000), 31), 0); }
TEST(Triangle, NoRayLeaksFromAClosedMeshFarFromTheOrigin) {
  EXPECT_EQ(leaks(1, 1e5, test::sweep(1'000'000), 32), 0);
}
TEST(Triangle, NoRayLeaksAtAnyScale) {
  for (double scale : {1e-3, 1e3, 1e7}) EXPECT_EQ(leaks(scale, 0, test::sweep(100'000), 33), 0) << scale;
}

TEST(Triangle, AxisParallelRaysThroughAGridsVerticesAndEdgesMeetItOnce) {
  // Each ray goes exactly through a vertex or along an edge's projection of a 4 x 4 grid of squares.
  for (int axis = 0; axis < 3; ++axis) {
    for (int x = 1; x < 8; ++x) {
      for (int y = 1; y < 8; ++y) {
        auto place = [&](float px, float py, float pz) {
          glm::vec3 p(0);
          p[axis] = pz;
          p[(axis + 1) % 3] = px;
          p[(axis + 2) % 3] = py;
          return p;
        };
        int met = 0;
        for (int i = 0; i < 16; ++i) {
          auto qx = float(i % 4), qy = float(i / 4);
          float t, wb, wc;
          glm::vec3 origin = place(float(x) * 0.5f, float(y) * 0.5f, 1), down = place(0, 0, -1);
          met += single::hitTriangle(origin, down, place(qx, qy, 0), place(qx + 1, qy, 0),
                                     place(qx + 1, qy + 1, 0), 0, t, wb, wc);
          met += single::hitTriangle(origin, down, place(qx, qy, 0), place(qx + 1, qy + 1, 0),
                                     place(qx, qy + 1, 0), 0, t, wb, wc);
        }
        ASSERT_EQ(met, 1) << axis << " " << x << " " << y;
      }
    }
  }
}

TEST(Triangle, FloatMatchesTheTwin) {
  Random random(34);
  int hits = 0;
  for (int i = 0; i < 300'000; ++i) {
    glm::vec3 a(random.point(-1, 1)), b(random.point(-1, 1)), c(random.point(-1, 1)), o(random.point(-3, 3));
    glm::vec3 d(glm::normalize(random.point(-1, 1) - glm::dvec3(o)));
    float t, wb, wc;
    double tTwin, wbTwin, wcTwin;
    glm::dvec3 n = twin::triangleNormal(a, b, c);
    if (std::fabs(glm::dot(n, glm::dvec3(d))) < 0.1) continue;
    bool hit = single::hitTriangle(o, d, a, b, c, 0, t, wb, wc);
    bool truth = twin::hitTriangle(o, d, a, b, c, 0, tTwin, wbTwin, wcTwin);
    double inside = std::min({wbTwin, wcTwin, 1 - wbTwin - wcTwin});
    if (hit != truth) {
      ASSERT_LE(std::fabs(inside), 1e-4);
      continue;
    }
    if (!hit) continue;
    ++hits;
    double edge = std::sqrt(glm::length(glm::cross(glm::dvec3(b - a), glm::dvec3(c - a))));
    if (edge < 0.1) continue;
    ASSERT_NEAR(t, tTwin, 3e-5);
    ASSERT_NEAR(wb, wbTwin, 1e-6 / (edge * edge * 0.1));
    ASSERT_NEAR(wc, wcTwin, 1e-6 / (edge * edge * 0.1));
    ASSERT_LE(glm::distance(glm::dvec3(single::triangleNormal(a, b, c)), n), 1e-5 / (edge * edge));
  }
  EXPECT_GT(hits, 5'000);
}

TEST(Triangle, WeightsNameTheCorners) {
  float t, wb, wc;
  glm::vec3 a(0, 0, 5), b(4, 0, 5), c(0, 4, 5);
  ASSERT_TRUE(single::hitTriangle({1, 2, 0}, {0, 0, 1}, a, b, c, 0, t, wb, wc));
  EXPECT_EQ(t, 5.0f);
  EXPECT_EQ(wb, 0.25f);
  EXPECT_EQ(wc, 0.5f);
  EXPECT_EQ(single::triangleNormal(a, b, c), glm::vec3(0, 0, 1));
  EXPECT_FALSE(single::hitTriangle({1, 2, 0}, {0, 0, 1}, a, b, c, 5, t, wb, wc));
  EXPECT_FALSE(single::hitTriangle({1, 2, 0}, {0, 0, -1}, a, b, c, 0, t, wb, wc));
  EXPECT_TRUE(single::hitTriangle({1, 2, 9}, {0, 0, -1}, a, b, c, 0, t, wb, wc));
}

TEST(Triangle, DegenerateOnesAreNotHit) {
  float t, wb, wc;
  glm::vec3 a(0, 0, 5), b(4, 0, 5);
  EXPECT_FALSE(single::hitTriangle({0, 0, 0}, {0, 0, 1}, a, a, a, 0, t, wb, wc));
  EXPECT_FALSE(single::hitTriangle({1, 0, 0}, {0, 0, 1}, a, b, b, 0, t, wb, wc));
  EXPECT_FALSE(single::hitTriangle({0, 1, 5}, {0, -1, 0}, a, b, {4, 4, 5}, 0, t, wb, wc));
  EXPECT_EQ(single::triangleNormal(a, b, b), glm::vec3(0));
}

}  // namespace
}  // namespace gxy
