// SPDX-License-Identifier: Apache-2.0
// Isosurfaces and slices of hexahedra, wedges and pyramids.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/reference/cell_samples.h"

namespace gxy::reference {
namespace {

const glm::dvec3 kSlope(0.5, 0.25, -0.125);
/// Exact in float at all points that inside() makes.
double onSlope(glm::dvec3 p) { return 0.125 + glm::dot(kSlope, p); }

bool inCube(glm::dvec3 p, double margin) {
  return std::min({p.x, p.y, p.z}) > margin && std::max({p.x, p.y, p.z}) < 1 - margin;
}

MeshField fieldOf(const MeshPiece& piece) { return MeshField(*meshOf(piece), std::nullopt); }

TEST(CellIsosurface, OfALinearFieldIsAPlane) {
  for (const CellFilling& filling : kFillings) {
    const MeshField field = fieldOf(filling.make(4, inside(0.075, 2), onSlope));
    Uniform random(5);
    int hits = 0, misses = 0;
    for (const double isovalue : {0.125, 0.3, 0.4375, 0.61}) {
      const MeshSurface surface = field.isosurface(isovalue);
      for (int i = 0; i < 500; i++) {
        const Ray ray = towards(0.5 + random.inCube(i % 2 ? 3 : 0.5), 0.5 + random.inCube(0.5));
        const double rise = glm::dot(kSlope, ray.direction), t = (isovalue - onSlope(ray.origin)) / rise;
        const auto found = surface.along(ray);
        if (t > 0 && inCube(ray.at(t), 1e-9)) {
          ASSERT_EQ(found.size(), 1u) << filling.name;
          EXPECT_NEAR(found[0].t, t, 1e-12 + 2e-15 / std::abs(rise));
          EXPECT_NEAR(found[0].value, isovalue, 1e-14);
          EXPECT_LT(glm::length(surface.upwards(found[0], {}) - glm::normalize(kSlope)), 1e-9);
          hits++;
        } else if (t < 0 || !inCube(ray.at(t), -1e-9)) {
          EXPECT_EQ(found.size(), 0u);
          misses++;
        }
      }
    }
    EXPECT_GT(hits, 250);
    EXPECT_GT(misses, 250);
  }
}

TEST(CellSlice, IsThePlaneWithTheValuesThere) {
  for (const CellFilling& filling : kFillings) {
    const MeshField field = fieldOf(filling.make(4, inside(0.075, 2), onSlope));
    Uniform random(5);
    int hits = 0;
    for (const Plane& plane : {Plane{{1, 0, 0}, 0.5}, Plane{{0, -3, 0}, -1}, Plane{{1, 2, -1}, 0.7}}) {
      const MeshSurface surface = field.slice(plane);
      for (int i = 0; i < 300; i++) {
        const Ray ray = towards(0.5 + random.inCube(3), 0.5 + random.inCube(0.5));
        const double along = glm::dot(plane.normal, ray.direction);
        const double t = (plane.offset - glm::dot(plane.normal, ray.origin)) / along;
        const auto found = surface.along(ray);
        if (t > 0 && inCube(ray.at(t), 1e-9)) {
          ASSERT_EQ(found.size(), 1u) << filling.name;
          EXPECT_NEAR(found[0].t, t, 1e-12 + 2e-15 * glm::length(plane.normal) / std::abs(along));
          EXPECT_NEAR(found[0].value, onSlope(ray.at(found[0].t)), 1e-13);
          const glm::dvec3 aside(1e-6, -2e-6, 1e-6);
          EXPECT_NEAR(surface.valueNear(found[0], aside) - found[0].value, glm::dot(kSlope, aside), 1e-6);
          hits++;
        } else if (t < 0 || !inCube(ray.at(t), -1e-9)) {
          EXPECT_EQ(found.size(), 0u);
        }
      }
    }
    EXPECT_GT(hits, 200);
  }
}

TEST(CellIsosurface, IsMetByOneRayAsOftenAsItPassesAHexahedron) {
  // x y z is a cubic along the diagonal, and (x - 1/2) (y - 1/2) + (z - 1/2) / 8 one with up to two roots on others
  const auto saddle = [](glm::dvec3 p) { return (p.x - 0.5) * (p.y - 0.5) + (p.z - 0.5) / 8; };
  const MeshPiece piece = test::cubeOfHexes(1, kStill, saddle);
  const MeshSurface surface = fieldOf(piece).isosurface(0);
  Uniform random(7);
  int twice = 0;
  for (int i = 0; i < 1000; i++) {
    const Ray ray = towards(glm::dvec3(0.5) + 2.0 * glm::normalize(random.inCube(1)),
                            glm::dvec3(0.5) + random.inCube(0.5));
    std::vector<double> roots;  // of the quadratic along the ray, inside the cube
    const glm::dvec3 o = ray.origin - 0.5, d = ray.direction;
    const double a = d.x * d.y, b = o.x * d.y + o.y * d.x + d.z / 8, c = o.x * o.y + o.z / 8,
                 disc = b * b - 4 * a * c;
    if (std::abs(disc) < 1e-6) continue;
    bool near = false;
    for (const double sign : {-1.0, 1.0}) {
      if (disc < 0) continue;
      const double t = (-b + sign * std::sqrt(disc)) / (2 * a);
      if (inCube(ray.at(t), 0)) roots.push_back(t);
      near = near || inCube(ray.at(t), -1e-9) != inCube(ray.at(t), 1e-9);
    }
    if (near) continue;
    std::sort(roots.begin(), roots.end());
    const auto found = surface.along(ray);
    ASSERT_EQ(found.size(), roots.size());
    for (size_t k = 0; k < roots.size(); k++) EXPECT_NEAR(found[k].t, roots[k], 1e-12);
    twice += roots.size() == 2;
  }
  EXPECT_GT(twice, 30);
}

TEST(CellIsosurface, ThreeRootsAlongTheDiagonalOfAHexahedron) {
  // on the diagonal x = y = z = s: (s - 1/4) (s - 1/2) (s - 3/4), as a trilinear function
  const auto f = [](glm::dvec3 p) { return (p.x - 0.25) * (p.y - 0.5) * (p.z - 0.75); };
  const MeshSurface surface = fieldOf(test::cubeOfHexes(1, kStill, f)).isosurface(0);
  const auto found = surface.along(towards({-1, -1, -1}, {1, 1, 1}));
  ASSERT_EQ(found.size(), 3u);
  for (size_t k = 0; k < 3; k++) EXPECT_NEAR(found[k].t, std::sqrt(3.0) * (1.25 + 0.25 * double(k)), 1e-14);
}

/// The gradient of what the shape functions make of values at a place, by central differences in space.
glm::dvec3 differences(CellType type, const MeshPiece& piece, glm::dvec3 at, glm::dvec3 guess) {
  constexpr double h = 1e-5;
  OfCorners values{};
  std::copy(piece.values.begin(), piece.values.end(), values.begin());
  glm::dvec3 gradient(0);
  for (int a = 0; a < 3; a++)
    for (const double sign : {-1.0, 1.0}) {
      glm::dvec3 aside(0);
      aside[a] = sign * h;
      const auto inverse = invert(type, piece.points, at + aside, guess);
      if (!inverse) return glm::dvec3(0);
      gradient[a] += sign * shapeAt(type, inverse->place).mean(values) / (2 * h);
    }
  return gradient;
}

TEST(CellIsosurface, NormalsAreTheGradientAtTheCrossing) {
  for (const CellType type : {CellType::Pyramid, CellType::Wedge, CellType::Hexahedron}) {
    Uniform random(19);
    int checked = 0;
    for (int i = 0; i < 300; i++) {
      const MeshPiece piece = oneBentCell(type, 0.1, random);
      const MeshSurface surface = fieldOf(piece).isosurface(0.5);
      const Ray ray = towards(glm::dvec3(0.4) + 3.0 * glm::normalize(random.inCube(1)),
                              glm::dvec3(0.4) + random.inCube(0.2));
      for (const MeshCrossing& hit : surface.along(ray)) {
        EXPECT_NEAR(hit.value, 0.5, 1e-12);
        const glm::dvec3 rise = differences(type, piece, ray.at(hit.t), hit.place);
        if (glm::length(rise) < 0.05) continue;
        EXPECT_LT(glm::distance(surface.upwards(hit, {}), glm::normalize(rise)), 1e-6);
        const glm::dvec3 aside = 1e-4 * random.inCube(1);
        EXPECT_NEAR(surface.valueNear(hit, aside), 0.5 + glm::dot(rise, aside), 1e-6);
        checked++;
      }
    }
    EXPECT_GT(checked, 100);
  }
}

// With -1 on the border all rays that come from outside leave what is higher as often as they enter it. Where faces have the isovalue
// at all their corners, two sheets may touch.
TEST(CellIsosurface, ClosesAcrossFacesOfAllCells) {
  for (const CellFilling& filling : kFillings) {
    Uniform random(17);
    for (const auto& [far, sheetsTouch] : {std::pair{0.0, true}, {0.04, true}, {0.04, false}}) {
      const bool touch = sheetsTouch;
      const MeshPiece piece = filling.make(4, inside(far, 3), [&](glm::dvec3 p) {
        const double r = random();
        return !inCube(p, 0) ? -1.0 : touch && r < 0.3 ? 0.0 : random.in(-1, 1.5);
      });
      const MeshSurface surface = fieldOf(piece).isosurface(0);
      const auto anyPoint = [&] { return piece.points[size_t(random() * double(piece.points.size()))]; };
      size_t crossings = 0;
      for (int i = 0; i < 1500; i++) {
        // a third of the rays from point to point, a third through points, a third anywhere
        const glm::dvec3 from = i % 3 == 2 ? 0.5 + random.inCube(0.5) : anyPoint(),
                         to = i % 3 == 0 ? anyPoint() : 0.5 + random.inCube(0.5);
        if (from == to || (!inCube(from, 0) && !inCube(to, 0))) continue;
        Ray ray = towards(from, to);
        ray.origin -= 2.0 * ray.direction;
        const auto found = surface.along(ray);
        ASSERT_EQ(found.size() % 2, 0u) << filling.name << ' ' << i;
        for (size_t k = 1; k < found.size() && i % 3 == 2 && !touch; k++)
          EXPECT_GT(found[k].t, found[k - 1].t) << "hit twice";
        crossings += found.size();
      }
      EXPECT_GT(crossings, 400u) << filling.name;
    }
  }
}

TEST(CellIsosurface, ClosesForRaysToWhereItCrossesEdges) {
  for (const CellFilling& filling : kFillings) {
    Uniform random(23);
    const MeshPiece piece = filling.make(
        4, inside(0.04, 4), [&](glm::dvec3 p) { return inCube(p, 0) ? random.in(-1, 1.5) : -1.0; });
    const MeshSurface surface = fieldOf(piece).isosurface(0.1);
    int rays = 0;
    for (uint32_t cell = 0; cell < piece.cells.size(); cell++) {
      const CellFace& face = shapeOf(piece.cells.typeOf(cell)).face[0];
      const uint32_t a = piece.cells.pointsOf(cell)[face.corner[0]],
                     b = piece.cells.pointsOf(cell)[face.corner[1]];
      const double la = piece.values[a] - 0.1, lb = piece.values[b] - 0.1;
      if ((la > 0) == (lb > 0)) continue;
      const glm::dvec3 at = glm::mix(piece.points[a], piece.points[b], la / (la - lb));
      for (int k = 0; k < 8; k++) {
        EXPECT_EQ(surface.along(towards(at + 3.0 * glm::normalize(random.inCube(1)), at)).size() % 2, 0u);
        rays++;
      }
    }
    EXPECT_GT(rays, 100) << filling.name;
  }
}

TEST(CellIsosurface, OfADistanceConvergesToASphere) {
  const glm::dvec3 centre(0.5);
  for (const CellFilling& filling : kFillings) {
    double before = 0;
    for (const uint32_t n : {5u, 10u}) {
      const MeshPiece piece =
          filling.make(n, inside(0.1 / n, 2), [&](glm::dvec3 p) { return glm::dot(p - centre, p - centre); });
      const MeshSurface surface = fieldOf(piece).isosurface(0.16);
      Uniform random(9);
      double largest = 0;
      for (int i = 0; i < 500; i++) {
        const Ray inward = towards(centre + glm::normalize(random.inCube(1)) * 2.0, centre);
        const auto found = surface.along(inward);
        ASSERT_EQ(found.size(), 2u) << filling.name;
        for (const MeshCrossing& hit : found)
          largest = std::max(largest, std::abs(glm::length(inward.at(hit.t) - centre) - 0.4));
        EXPECT_EQ(surface.along({centre, inward.direction}).size(), 1u);
      }
      if (before > 0) {
        EXPECT_LT(largest, before / 2.5) << "of second order: " << filling.name;
      }
      before = largest;
    }
  }
}

TEST(CellSlice, IsMetOnceWhereItGoesThroughVerticesEdgesAndFaces) {
  for (const CellFilling& filling : kFillings) {
    const MeshField field = fieldOf(filling.make(4, kStill, onSlope));
    Uniform random(3);
    for (const glm::dvec3 normal :
         {glm::dvec3(1, 0, 0), glm::dvec3(0, 0, -1), glm::dvec3(1, -1, 0), glm::dvec3(1, 1, -2)})
      for (int i = 0; i < 60; i++) {
        const auto eighth = [&](int least, int most) { return double(int(random.in(least, most + 1))) / 8; };
        const glm::dvec3 at(eighth(1, 7), eighth(1, 7), eighth(1, 7)),
            d(eighth(-8, 8), eighth(-8, 8), eighth(-8, 8));
        if (std::abs(glm::dot(normal, d)) < 1e-9) continue;
        const Ray ray{at - 8.0 * d, glm::normalize(d)};
        for (const MeshSurface& surface :
             {field.slice({normal, glm::dot(normal, at)}), field.isosurface(onSlope(at))}) {
          const auto found = surface.along(ray);
          if (std::abs(glm::dot(kSlope, d)) < 1e-9) continue;
          ASSERT_EQ(found.size(), 1u) << filling.name;
          EXPECT_LT(glm::distance(ray.at(found[0].t), at), 1e-12);
          EXPECT_NEAR(found[0].value, onSlope(at), 1e-13);
        }
      }
  }
}

}  // namespace
}  // namespace gxy::reference
