// SPDX-License-Identifier: Apache-2.0
// Walks of rays from face to face through tetrahedra.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <numeric>
#include <set>
#include <vector>

#include "core/data/connect.h"
#include "core/kernels/single.h"
#include "tests/kernels/random.h"
#include "tests/support/meshes.h"
#include "tests/support/seeds.h"

namespace gxy {
namespace {

using test::Random;

struct TetMesh {
  std::vector<glm::vec3> points;
  MeshCells cells;
  Connectivity connectivity;

  void connectAll() { connectivity = connect(cells, points.size()); }
  size_t size() const { return cells.size(); }
  FaceId neighbour(FaceId id) const {
    return connectivity.neighbours[0][4 * cellOf(id) + size_t(faceOf(id))];
  }
};

/// test::cubeOfTets() with points as floats.
template <class Move>
TetMesh cubeOfTets(uint32_t n, Move&& move) {
  const MeshPiece piece = test::cubeOfTets(n, move, [](glm::dvec3) { return 0.0; });
  TetMesh mesh;
  for (const glm::dvec3& p : piece.points) mesh.points.emplace_back(p);
  mesh.cells = piece.cells;
  mesh.connectAll();
  return mesh;
}

/// The face of a tetrahedron that is paired with face `from`, given the signs of the four faces and where the ray passes them.
int pairedFace(const glm::vec4& signs, const glm::vec4& ts, int from) {
  std::array<int, 3> others{};
  int n = 0, passed = 0, paired = -1;
  for (int i = 0; i < 4; i++) {
    if (i != from) others[size_t(n++)] = i;
    passed += signs[i] != 0;
    if (signs[i] == -signs[from]) paired = i;
  }
  if (passed < 4) return paired;
  const auto [a, b, c] = others;
  const auto number = [](int i) { return unsigned(i) + 7; };
  return others[size_t(single::cornerLeft(int(signs[from]), int(signs[a]), int(signs[b]), ts[from], ts[a],
                                          ts[b], ts[c], number(a), number(b), number(c), number(from)))];
}

class Walker {
 public:
  Walker(const TetMesh& mesh, glm::vec3 origin, glm::vec3 direction) : mesh_(mesh) {
    const single::RayFrame f = single::frameOf(direction);
    forward_ = f.perDepth > 0 ? 1.0f : -1.0f;
    perDepth_ = f.perDepth;
    for (const glm::vec3& p : mesh.points) {
      const glm::vec3 q = single::turned(p - origin, f.last);
      points_.emplace_back(single::sheared(q.x, f.shearX, q.z), single::sheared(q.y, f.shearY, q.z), q.z);
    }
  }

  /// 1: the ray enters the cell by this face; -1: it leaves it.
  int sign(FaceId id) const {
    const auto c = corners(id);
    return int(-forward_) * single::triangleSign(points_[c[0]], points_[c[1]], points_[c[2]]);
  }
  float t(FaceId id) const {
    const auto c = corners(id);
    const glm::vec3 &p = points_[c[0]], &q = points_[c[1]], &r = points_[c[2]];
    float a, b, w;
    single::triangleShares(p, q, r, single::sideOf(q, r), single::sideOf(r, p), single::sideOf(p, q), a, b,
                           w);
    const float depth = single::meanOf(a, b, w, p.z, q.z, r.z);
    return depth * perDepth_;
  }
  std::vector<FaceId> entries() const {
    std::vector<FaceId> found;
    for (const FaceId id : mesh_.connectivity.shell)
      if (sign(id) > 0) found.push_back(id);
    std::sort(found.begin(), found.end(),
              [&](FaceId a, FaceId b) { return std::pair(t(a), a) < std::pair(t(b), b); });
    return found;
  }

  struct Walk {
    FaceId end = kNoFace;  ///< the face of the shell through which it leaves
    size_t cells = 0;      ///< one more than there are: it does not end
    double length = 0;     ///< the sum of what T grows by
    double within = 0;     ///< the same, from this T on
  };
  Walk from(FaceId face, float tMin = -1e30f) const {
    Walk walk;
    float T = t(face);
    for (FaceId at = face; walk.cells++ <= mesh_.size();) {
      const uint32_t cell = cellOf(at);
      glm::vec4 signs, ts;
      for (int i = 0; i < 4; i++) {
        signs[i] = float(sign(faceId(cell, i)));
        ts[i] = t(faceId(cell, i));
      }
      const int exit = pairedFace(signs, ts, faceOf(at));
      EXPECT_GE(exit, 0);
      if (exit < 0) return walk;
      const float next = std::max(T, ts[exit]);
      walk.length += double(next) - T;
      walk.within += std::max(0.0, double(next) - std::max(T, tMin));
      T = next;
      walk.end = faceId(cell, exit);
      at = mesh_.neighbour(walk.end);
      if (at == kNoFace) return walk;
    }
    return walk;
  }

 private:
  std::array<uint32_t, 3> corners(FaceId id) const {
    const CellFace& face = shapeOf(CellType::Tetrahedron).face[size_t(faceOf(id))];
    const auto cell = mesh_.cells.pointsOf(cellOf(id));
    return {cell[face.corner[0]], cell[face.corner[1]], cell[face.corner[2]]};
  }

  const TetMesh& mesh_;
  std::vector<glm::vec3> points_;
  float forward_ = 1, perDepth_ = 1;
};

struct Ray {
  glm::vec3 origin, direction;
};
/// From around the cube towards a point of it.
Ray rayTo(Random& random, glm::dvec3 to) {
  for (;;) {
    const glm::dvec3 from = random.point(-3, 4);
    if (glm::all(glm::lessThan(glm::abs(from - 0.5), glm::dvec3(1)))) continue;
    return {glm::vec3(from), glm::vec3(glm::normalize(to - from))};
  }
}

struct Ends {
  size_t rays = 0, walks = 0, endless = 0, wrongEnds = 0, mostWalks = 0;
  double worstLength = 0;
};
/// All walks of rays; `lengthOf` says how long their way through the mesh is, or < 0 if nobody knows.
template <class LengthOf>
Ends walk(const TetMesh& mesh, int rays, uint64_t seed, LengthOf&& lengthOf, bool atPoints = false) {
  Random random(seed);
  Ends ends;
  for (int i = 0; i < rays; i++) {
    glm::dvec3 to = random.point(0.02, 0.98);
    if (atPoints) to = glm::dvec3(mesh.points[size_t(random.below(int(mesh.points.size())))]);
    const Ray ray = rayTo(random, to);
    const Walker walker(mesh, ray.origin, ray.direction);
    std::set<FaceId> left;
    double length = 0;
    const auto entries = walker.entries();
    for (const FaceId entry : entries) {
      const auto w = walker.from(entry);
      ends.endless += w.cells > mesh.size();
      ends.wrongEnds += walker.sign(w.end) >= 0 || !left.insert(w.end).second;
      length += w.length;
    }
    ends.rays++;
    ends.walks += entries.size();
    ends.mostWalks = std::max(ends.mostWalks, entries.size());
    const double expected = lengthOf(ray);
    if (expected >= 0) ends.worstLength = std::max(ends.worstLength, std::abs(length - expected));
  }
  return ends;
}

double throughUnitCube(const Ray& ray) {
  double in = -1e30, out = 1e30;
  for (int a = 0; a < 3; a++) {
    const double d = ray.direction[a], o = ray.origin[a];
    if (d == 0) {
      if (o < 0 || o > 1) return 0;
      continue;
    }
    in = std::max(in, std::min(-o / d, (1 - o) / d));
    out = std::min(out, std::max(-o / d, (1 - o) / d));
  }
  return std::max(0.0, out - in);
}
double nobodyKnows(const Ray&) { return -1; }

TEST(Face, CrossingsOfAnEdgeAreOppositeInBothDirections) {
  Random random(5);
  const float values[] = {0, -0.0f, 1, -1, 1e-12f, -3, 1e12f, 0.1f, 0.3f};
  for (int i = 0; i < test::sweep(100'000); i++) {
    const auto some = [&] { return values[random.below(9)]; };
    const glm::vec3 p(some(), some(), some()), q(some(), some(), some());
    ASSERT_EQ(single::edgeCrossing(p, q), -single::edgeCrossing(q, p));
  }
}

// Slivers whose edges rounding takes to the wrong side have two faces that enter and two that leave: all crossings of the six edges.
TEST(Face, FacesAreInPairsWhateverTheEdgesSay) {
  Random random(6);
  int fours = 0;
  for (int i = 0; i < 729; i++)
    for (int draw = 0; draw < 20; draw++) {
      const auto crossing = [&](int a, int b) {  // of the edge from point a to b
        const int lo = std::min(a, b), hi = std::max(a, b);
        const int edge = lo == 0 ? hi - 1 : lo + hi;  // 01 02 03 12 13 23
        const int bits = i / int(std::pow(3, edge) + 0.5) % 3 - 1;
        return a < b ? bits : -bits;
      };
      glm::vec4 signs, ts;
      int pierced = 0;
      for (int f = 0; f < 4; f++) {
        const auto& c = shapeOf(CellType::Tetrahedron).face[size_t(f)].corner;
        signs[f] = float(crossing(c[0], c[1]) + crossing(c[1], c[2]) + crossing(c[2], c[0]));
        ts[f] = float(random.below(3));
        pierced += signs[f] != 0;
      }
      ASSERT_EQ(signs.x + signs.y + signs.z + signs.w, 0);
      // Points are above or below the half-line, so the crossings of a triangle's edges never add up to more.
      if (glm::any(glm::greaterThan(glm::abs(signs), glm::vec4(1)))) continue;
      fours += pierced == 4;
      for (int f = 0; f < 4; f++) {
        if (signs[f] == 0) continue;
        const int other = pairedFace(signs, ts, f);
        ASSERT_GE(other, 0);
        ASSERT_EQ(signs[other], -signs[f]);
        ASSERT_EQ(pairedFace(signs, ts, other), f);
      }
    }
  EXPECT_GT(fours, 100);
}

TEST(Face, WalksThroughACubeAreAsLongAsTheCubeIs) {
  const TetMesh mesh = cubeOfTets(4, [](glm::dvec3) { return glm::dvec3(0); });
  const Ends ends = walk(mesh, test::sweep(2000), 1, throughUnitCube);
  EXPECT_EQ(ends.walks, ends.rays);
  EXPECT_EQ(ends.endless + ends.wrongEnds, 0u);
  EXPECT_LT(ends.worstLength, 2e-6);
}

TEST(Face, RaysThroughPointsPassBesideThem) {
  const TetMesh mesh = cubeOfTets(4, [](glm::dvec3) { return glm::dvec3(0); });
  const Ends ends = walk(mesh, test::sweep(2000), 2, nobodyKnows, true);
  EXPECT_LE(ends.mostWalks, 1u);
  EXPECT_EQ(ends.endless + ends.wrongEnds, 0u);
}

// Exactly through points, edges and faces, along the axes and along diagonals: the length is that of the cube, or 0 on its sides.
TEST(Face, RaysExactlyThroughPointsEdgesAndFacesAreNotLost) {
  constexpr int n = 4;
  const TetMesh mesh = cubeOfTets(n, [](glm::dvec3) { return glm::dvec3(0); });
  size_t rays = 0, endless = 0, wrongEnds = 0, wrongLengths = 0;
  for (const glm::vec3 d : {glm::vec3(1, 0, 0),
                            {0, 1, 0},
                            {0, 0, 1},
                            {-1, 0, 0},
                            {0, -1, 0},
                            {0, 0, -1},
                            {1, 1, 0},
                            {1, 0, -1},
                            {0, -1, 1},
                            {1, 1, 1},
                            {-1, 1, 1},
                            {2, 1, 0},
                            {1, -2, 1}})
    for (int i = 0; i < 2 * n + 1; i++)
      for (int j = 0; j < 2 * n + 1; j++)
        for (int k = 0; k < 2 * n + 1; k++) {
          const glm::vec3 through = glm::vec3(i, j, k) / float(2 * n);
          const Ray ray{through - 4.0f * d, d};  // exact
          const Walker walker(mesh, ray.origin, ray.direction);
          const auto entries = walker.entries();
          double length = 0;
          for (const FaceId entry : entries) {
            const auto w = walker.from(entry);
            endless += w.cells > mesh.size();
            wrongEnds += walker.sign(w.end) >= 0;
            length += w.length;
          }
          rays++;
          const double expected = throughUnitCube(ray);
          const bool onASide = [&] {
            for (int a = 0; a < 3; a++)
              if (d[a] == 0 && (through[a] == 0 || through[a] == 1)) return true;
            return false;
          }();
          if (onASide)
            wrongLengths += std::min(std::abs(length - expected), length) > 1e-6;
          else
            wrongLengths += std::abs(length - expected) > 1e-6 || entries.size() > 1;
        }
  EXPECT_EQ(rays, 13u * 729u);
  EXPECT_EQ(endless, 0u);
  EXPECT_EQ(wrongEnds, 0u);
  EXPECT_EQ(wrongLengths, 0u);
}

/// Moves points inside the cube by up to so many cells: beyond about 0.2, cells are inverted.
TetMesh tangled(uint32_t n, double by, uint64_t seed) {
  Random random(seed);
  return cubeOfTets(n, [&](glm::dvec3 p) {
    const bool inside =
        glm::all(glm::greaterThan(p, glm::dvec3(0))) && glm::all(glm::lessThan(p, glm::dvec3(1)));
    return inside ? random.point(-by, by) / double(n) : glm::dvec3(0);
  });
}

TEST(Face, WalksThroughTangledCellsEnd) {
  for (const double by : {0.1, 0.4, 0.8, 1.5, 30.0})
    for (int seed = 0; seed < test::sweep(40); seed++) {
      const TetMesh mesh = tangled(4, by, uint64_t(seed));
      const Ends ends = walk(mesh, 40, uint64_t(seed), nobodyKnows);
      EXPECT_EQ(ends.endless, 0u) << by << " " << seed;
      EXPECT_EQ(ends.wrongEnds, 0u) << by << " " << seed;
    }
}

// Points that no cube orders, many of them equal, on lines or in planes: the cells are slivers, flat, or inverted.
TEST(Face, WalksThroughRandomCellsEnd) {
  size_t walks = 0;
  for (int seed = 0; seed < test::sweep(3000); seed++) {
    Random random{uint64_t(seed)};
    TetMesh mesh = tangled(1 + uint32_t(random.below(3)), 0, 0);
    const int kind = random.below(4);
    for (glm::vec3& p : mesh.points) {
      p = glm::vec3(random.point(0, 1));
      if (kind == 1) p = glm::round(p * 3.0f) / 3.0f;
      if (kind == 2) p.z = 0.5f;
      if (kind == 3) p *= glm::vec3(1e-6f, 1, 1e6f);
    }
    mesh.connectAll();
    for (int i = 0; i < 10; i++) {
      glm::dvec3 to = random.point(0.1, 0.9);
      if (random.below(2) == 0) to = glm::dvec3(mesh.points[size_t(random.below(int(mesh.points.size())))]);
      Ray ray = rayTo(random, to);
      if (random.below(2) == 0)
        ray = {glm::vec3(to.x, to.y, -1.5), glm::vec3(0, 0, 1)};  // all flat cells at t = 2
      const Walker walker(mesh, ray.origin, ray.direction);
      std::set<FaceId> left;
      for (const FaceId entry : walker.entries()) {
        const auto w = walker.from(entry);
        ASSERT_LE(w.cells, mesh.size()) << seed;
        ASSERT_LT(walker.sign(w.end), 0) << seed;
        ASSERT_TRUE(left.insert(w.end).second) << seed;
        walks++;
      }
    }
  }
  EXPECT_GT(walks, 1000u);
}

}  // namespace
}  // namespace gxy
