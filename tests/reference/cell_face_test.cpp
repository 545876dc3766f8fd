// SPDX-License-Identifier: Apache-2.0
// Where rays go through triangles and bilinear patches.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "core/reference/cell_face.h"
#include "core/reference/tetrahedron.h"
#include "tests/reference/samples.h"

namespace gxy::reference {
namespace {

using Quad = std::array<glm::dvec3, 4>;
constexpr CellFace kQuad{4, {0, 1, 2, 3}};
constexpr std::array<uint32_t, 4> kAscending{0, 1, 2, 3};

/// A place on a patch, with the Jacobian of what a ray along z sees of it.
struct Place {
  double u, v;
  glm::dvec3 point;
  glm::dvec3 alongU, alongV;
  double jacobian() const { return alongU.x * alongV.y - alongU.y * alongV.x; }
};

Place placeAt(const Quad& q, double u, double v) {
  return {u, v, (1 - u) * (1 - v) * q[0] + u * (1 - v) * q[1] + u * v * q[2] + (1 - u) * v * q[3],
          (1 - v) * (q[1] - q[0]) + v * (q[2] - q[3]), (1 - u) * (q[3] - q[0]) + u * (q[2] - q[1])};
}

/// The places in the unit square at which x = y = 0, by Newton's method from all small squares that may hold one.
std::vector<Place> bruteForce(const Quad& q) {
  constexpr int kSquares = 24;
  std::vector<Place> found;
  for (int i = 0; i < kSquares; i++)
    for (int j = 0; j < kSquares; j++) {
      glm::dvec3 lo(kInfinity), hi(-kInfinity);
      for (const int k : {0, 1, 2, 3}) {
        const glm::dvec3 p = placeAt(q, double(i + k % 2) / kSquares, double(j + k / 2) / kSquares).point;
        lo = glm::min(lo, p), hi = glm::max(hi, p);
      }
      if (lo.x > 0 || lo.y > 0 || hi.x < 0 || hi.y < 0) continue;
      Place p = placeAt(q, (i + 0.5) / kSquares, (j + 0.5) / kSquares);
      for (int step = 0; step < 50; step++) {
        const double du = (p.point.x * p.alongV.y - p.point.y * p.alongV.x) / p.jacobian(),
                     dv = (p.alongU.x * p.point.y - p.alongU.y * p.point.x) / p.jacobian();
        p = placeAt(q, p.u - du, p.v - dv);
      }
      if (!(std::abs(p.point.x) + std::abs(p.point.y) < 1e-12)) continue;
      if (std::min({p.u, p.v, 1 - p.u, 1 - p.v}) < 0) continue;
      const auto same = [&](const Place& o) { return std::abs(o.u - p.u) + std::abs(o.v - p.v) < 1e-6; };
      if (std::none_of(found.begin(), found.end(), same)) found.push_back(p);
    }
  std::sort(found.begin(), found.end(), [](const Place& a, const Place& b) { return a.point.z < b.point.z; });
  return found;
}

std::vector<FaceMeeting> meetingsOf(const Quad& q, const CellFace& face = kQuad,
                                    std::span<const uint32_t> numbers = kAscending) {
  const FaceMeetings met = meet(face, q, numbers);
  std::vector<FaceMeeting> sorted(met.begin(), met.end());
  std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  return sorted;
}

TEST(CellFace, BilinearRootsAreThoseOfBruteForce) {
  Uniform random(1);
  std::array<int, 3> count{};
  for (int i = 0; i < 20000; i++) {
    Quad q;
    for (glm::dvec3& p : q) p = random.inCube(1);
    if (i % 4 == 0) q[2] = q[1] + q[3] - q[0];          // a parallelogram
    if (i % 4 == 1) q[2] = q[3] + 0.5 * (q[1] - q[0]);  // a trapezoid
    const auto expected = bruteForce(q);
    const auto met = meetingsOf(q);
    // near a fold the two ways to find roots may differ
    if (std::any_of(expected.begin(), expected.end(),
                    [](const Place& p) { return std::abs(p.jacobian()) < 1e-2; }))
      continue;
    if (expected.empty() && met.size() == 2 && std::abs(met[0].t - met[1].t) < 0.1) continue;
    ASSERT_EQ(met.size(), expected.size()) << i;
    count[met.size()]++;
    for (size_t k = 0; k < met.size(); k++) {
      EXPECT_NEAR(met[k].t, expected[k].point.z, 1e-11);
      EXPECT_EQ(met[k].sign, expected[k].jacobian() > 0 ? 1 : -1);
      const double u = expected[k].u, v = expected[k].v;
      EXPECT_NEAR(met[k].weights[0], (1 - u) * (1 - v), 1e-11);
      EXPECT_NEAR(met[k].weights[2], u * v, 1e-11);
    }
  }
  EXPECT_GT(count[0], 1000);
  EXPECT_GT(count[1], 1000);
  EXPECT_GT(count[2], 100);
}

TEST(CellFace, BothCellsOfAFaceMeetItAtTheSameBits) {
  Uniform random(2);
  int hits = 0;
  for (int i = 0; i < 2000; i++) {
    Quad q;
    for (glm::dvec3& p : q) p = random.inCube(1);
    std::array<uint32_t, 4> numbers{7, 3, 9, 5};
    for (size_t k = 3; k > 0; k--) std::swap(numbers[k], numbers[size_t(random() * double(k + 1))]);
    const uint8_t corners = i % 2 ? 3 : 4;
    CellFace one{corners, {0, 1, 2, 3}}, other{corners, {}};
    const size_t turn = size_t(random() * corners);
    for (size_t k = 0; k < corners; k++) other.corner[k] = uint8_t((turn + corners - k) % corners);
    const auto a = meetingsOf(q, one, numbers), b = meetingsOf(q, other, numbers);
    ASSERT_EQ(a.size(), b.size());
    const OfCorners values{0.3, -1, 2, 0.7};
    for (size_t k = 0; k < a.size(); k++) {
      EXPECT_EQ(a[k].t, b[k].t);
      EXPECT_EQ(a[k].mean(values), b[k].mean(values));
      EXPECT_EQ(a[k].sign, -b[k].sign);
      hits++;
    }
  }
  EXPECT_GT(hits, 200);
}

TEST(CellFace, TrianglesAreThoseOfTetrahedraToTheBit) {
  Uniform random(3);
  int hits = 0;
  for (int i = 0; i < 2000; i++) {
    Tetrahedron corners;
    for (glm::dvec3& p : corners) p = random.inCube(1);
    const auto passage = passageThrough(corners, {});
    size_t met = 0;
    for (const CellFace& face : std::span(shapeOf(CellType::Tetrahedron).face).first(4))
      for (const FaceMeeting& one : meet(face, corners, kAscending)) {
        ASSERT_TRUE(passage);
        EXPECT_TRUE(one.t == (*passage)[0].t || one.t == (*passage)[1].t);
        met++;
      }
    EXPECT_EQ(met, passage ? 2u : 0u);
    hits += met > 0;
  }
  EXPECT_GT(hits, 100);
}

// Around each inner point of a fan, and on each inner edge, exactly one of the faces is met.
TEST(CellFace, FacesAroundAPointAreMetOnceAsAWhole) {
  Uniform random(4);
  for (int i = 0; i < 500; i++) {
    // a 3 x 3 lattice of points, moved, as four quadrilaterals; the ray goes through the middle or through another point's shadow
    std::array<glm::dvec3, 9> p;
    for (int k = 0; k < 9; k++) p[size_t(k)] = glm::dvec3(k % 3 - 1, k / 3 - 1, 0) + random.inCube(0.2);
    const auto shift = [&](glm::dvec3 by) {
      for (glm::dvec3& q : p) q -= glm::dvec3(by.x, by.y, 0);
    };
    shift(i % 2 ? p[4] : 0.5 * (p[4] + p[5]));
    int sum = 0;
    for (const int k : {0, 1, 3, 4}) {
      const auto at = [&](int j) { return size_t(k + j); };
      const Quad q{p[at(0)], p[at(1)], p[at(4)], p[at(3)]};
      const std::array<uint32_t, 4> numbers{uint32_t(k), uint32_t(k + 1), uint32_t(k + 4), uint32_t(k + 3)};
      for (const FaceMeeting& one : meet(kQuad, q, numbers)) sum += one.sign;
    }
    EXPECT_EQ(sum, 1);
  }
}

TEST(CellFace, APlaneFaceSeenEdgeOnIsNotMet) {
  for (const double y : {-0.5, -1.0, 0.0}) {
    const Quad q{glm::dvec3(0, y, 0), {0, y + 1, 0.2}, {0, y + 1, 1}, {0, y, 1}};
    EXPECT_TRUE(meetingsOf(q).empty());
  }
}

}  // namespace
}  // namespace gxy::reference
