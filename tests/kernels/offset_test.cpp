// SPDX-License-Identifier: Apache-2.0
// Secondary rays of convex closed bodies, at scales from 1e-3 to 1e7. Predicate: a ray that leaves outwards, cosine
// distributed around the normal, meets the body nowhere (else it is a self-hit); one that goes inwards meets its far
// side (else it has leaked).
#include <gtest/gtest.h>

#include "tests/kernels/mesh.h"
#include "tests/kernels/random.h"

namespace gxy {
namespace {

using test::Random;

struct Count {
  int rays = 0, selfHits = 0, leaks = 0;
};

glm::vec3 around(Random& random, glm::vec3 side) {
  return single::cosineDirection(side, float(random.below(1 << 24)) * 0x1p-24f,
                                 float(random.below(1 << 24)) * 0x1p-24f);
}

float largest(glm::vec3 p) { return std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)}); }

// One outward and one inward ray; meets(origin, direction): does the ray meet the body?
template <class Meets>
void leave(Random& random, Count& count, glm::vec3 point, glm::vec3 normal, float size, Meets meets) {
  glm::vec3 out = single::offsetOrigin(point, normal, size);
  glm::vec3 in = single::offsetOrigin(point, -normal, size);
  count.rays += 2;
  count.selfHits += meets(out, around(random, normal));
  count.leaks += !meets(in, around(random, -normal));
}

TEST(OffsetOrigin, SpheresNeitherHitThemselvesNorLeak) {
  Random random(41);
  Count count;
  for (int i = 0; i < 100'000; ++i) {
    double scale = random.scale(1e-3, 1e7);
    glm::vec3 centre(random.point(-scale, scale));
    auto radius = float(scale * random.scale(1e-2, 1));
    glm::vec3 origin(glm::dvec3(centre) + 3 * scale * random.direction());
    glm::vec3 direction(
        glm::normalize(glm::dvec3(centre) + 0.9 * radius * random.direction() - glm::dvec3(origin)));
    float t;
    glm::vec3 n;
    ASSERT_TRUE(single::hitSphere(origin, direction, centre, radius, 0, t, n));
    leave(random, count, centre + radius * n, n, largest(centre) + radius,
          [&](glm::vec3 o, glm::vec3 d) { return single::hitSphere(o, d, centre, radius, 0, t, n); });
  }
  EXPECT_EQ(count.selfHits, 0);
  EXPECT_EQ(count.leaks, 0);
}

TEST(OffsetOrigin, RoundConesNeitherHitThemselvesNorLeak) {
  Random random(42);
  Count count;
  for (int i = 0; i < 100'000; ++i) {
    double scale = random.scale(1e-3, 1e7);
    glm::vec3 a(random.point(-scale, scale)), b(random.point(-scale, scale));
    auto ra = float(scale * random.scale(1e-2, 1)), rb = float(scale * random.scale(1e-2, 1));
    glm::vec3 origin(glm::dvec3(a) + 5 * scale * random.direction());
    double s = random.unit();
    glm::dvec3 to =
        glm::mix(glm::dvec3(a), glm::dvec3(b), s) + 0.9 * (ra + s * (rb - ra)) * random.direction();
    glm::vec3 direction(glm::normalize(to - glm::dvec3(origin)));
    float t, axial;
    glm::vec3 n;
    ASSERT_TRUE(single::hitRoundCone(origin, direction, a, b, ra, rb, 0, t, n, axial));
    glm::vec3 point = a + axial * (b - a) + (ra + axial * (rb - ra)) * n;
    float size = std::max(largest(a) + ra, largest(b) + rb);
    leave(random, count, point, n, size, [&](glm::vec3 o, glm::vec3 d) {
      glm::vec3 normal;
      float where;
      return single::hitRoundCone(o, d, a, b, ra, rb, 0, t, normal, where);
    });
  }
  EXPECT_EQ(count.selfHits, 0);
  EXPECT_EQ(count.leaks, 0);
}

TEST(OffsetOrigin, TrianglesNeitherHitThemselvesNorLeak) {
  Random random(43);
  Count count;
  test::Mesh mesh = test::icosphere();
  std::vector<glm::vec3> v(mesh.vertices.size());
  float reach = 0;
  for (int i = 0; i < 50'000; ++i) {
    // A new scale and place now and then.
    if (i % 1000 == 0) {
      double scale = random.scale(1e-3, 1e7);
      glm::dvec3 place = random.point(-scale, scale);
      reach = 0;
      for (std::size_t k = 0; k < v.size(); ++k) {
        v[k] = glm::vec3(place + 0.5 * scale * mesh.vertices[k]);
        reach = std::max(reach, largest(v[k]));
      }
    }
    const auto& tri = mesh.triangles[std::size_t(random.below(int(mesh.triangles.size())))];
    glm::vec3 a = v[tri[0]], b = v[tri[1]], c = v[tri[2]];
    auto wb = float(random.unit());
    auto wc = float((1 - wb) * random.unit());
    glm::vec3 point = (1 - wb - wc) * a + wb * b + wc * c;
    leave(random, count, point, single::triangleNormal(a, b, c), reach, [&](glm::vec3 o, glm::vec3 d) {
      return std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const std::array<int, 3>& t) {
        float distance, x, y;
        return single::hitTriangle(o, d, v[t[0]], v[t[1]], v[t[2]], 0, distance, x, y);
      });
    });
  }
  EXPECT_EQ(count.selfHits, 0);
  EXPECT_EQ(count.leaks, 0);
}

TEST(OffsetOrigin, StepIsAFixedNumberOfUlps) {
  for (float size : {1e-3f, 1.0f, 3.0f, 1e7f}) {
    float step = single::offsetOrigin({0, 0, 0}, {0, 0, 1}, size).z;
    EXPECT_EQ(step, 32 * (std::nextafter(size, INFINITY) - size));
    EXPECT_EQ(twin::offsetOrigin({0, 0, 0}, {0, 0, 1}, size).z, step);
  }
}

}  // namespace
}  // namespace gxy
