// SPDX-License-Identifier: Apache-2.0
// Isosurfaces and slices of unstructured volumes.
#include <gtest/gtest.h>

#include "core/reference/world.h"
#include "tests/reference/mesh_samples.h"

namespace gxy::reference {
namespace {

const glm::dvec3 kRise(0.5, 0.25, -0.125);
/// Exact in float at all points that inside() makes.
double linearAt(glm::dvec3 p) { return 0.125 + glm::dot(kRise, p); }

bool inBox(glm::dvec3 p, double margin) {
  return std::min({p.x, p.y, p.z}) > margin && std::max({p.x, p.y, p.z}) < 1 - margin;
}

MeshSurface isosurfaceOf(const MeshPiece& piece, double isovalue) {
  return MeshField(*meshOf(piece), std::nullopt).isosurface(isovalue);
}

MeshSurface sliceOf(const MeshPiece& piece, const Plane& plane) {
  return MeshField(*meshOf(piece), std::nullopt).slice(plane);
}

/// Rays through points, along edges and in faces of cubes of 1/4, with the place in [0, 1]^3 from which they were made.
std::vector<std::pair<Ray, glm::dvec3>> raysAlongCells() {
  std::vector<std::pair<Ray, glm::dvec3>> rays;
  for (int dx = -2; dx <= 2; dx++)
    for (int dy = -2; dy <= 2; dy++)
      for (int dz = -2; dz <= 2; dz++) {
        if (dx == 0 && dy == 0 && dz == 0) continue;
        const glm::dvec3 d(dx, dy, dz);
        for (int i = 1; i < 8; i++) {
          const glm::dvec3 at = glm::dvec3(i, 3 * i % 8, 5 * i % 8) / 8.0;
          if (std::min({at.x, at.y, at.z}) > 0) rays.push_back({{at - 8.0 * d, glm::normalize(d)}, at});
        }
      }
  return rays;
}

TEST(MeshIsosurface, OfALinearFieldIsAPlane) {
  const MeshPiece piece = cubeOfTets(8, inside(0.03, 1), linearAt);
  Uniform random(5);
  int hits = 0, misses = 0;
  for (const double isovalue : {0.125, 0.3, 0.4375, 0.61}) {
    const MeshSurface surface = isosurfaceOf(piece, isovalue);
    for (int i = 0; i < 1000; i++) {
      const Ray ray = towards(0.5 + random.inCube(i % 2 ? 3 : 0.5), 0.5 + random.inCube(0.5));
      const double t = (isovalue - linearAt(ray.origin)) / glm::dot(kRise, ray.direction);
      const auto found = surface.along(ray);
      if (t > 0 && inBox(ray.at(t), 1e-9)) {
        ASSERT_EQ(found.size(), 1u);
        EXPECT_NEAR(found[0].t, t, 1e-12 + 1e-15 / std::abs(glm::dot(kRise, ray.direction)));
        EXPECT_NEAR(found[0].value, isovalue, 1e-14);
        EXPECT_LT(glm::length(surface.upwards(found[0], {}) - glm::normalize(kRise)), 1e-10);
        hits++;
      } else if (t < 0 || !inBox(ray.at(t), -1e-9)) {
        EXPECT_EQ(found.size(), 0u);
        misses++;
      }
    }
  }
  EXPECT_GT(hits, 500);
  EXPECT_GT(misses, 500);
}

// The isovalue is that at a point through which the ray goes; often it is a value at points of the mesh, too.
TEST(MeshIsosurface, IsMetOnceByRaysThroughVerticesEdgesAndFaces) {
  for (const glm::dvec3 rise : {kRise, glm::dvec3(1, 0, 0), glm::dvec3(0, 0, -1), glm::dvec3(1, -1, 0),
                                glm::dvec3(1, 1, 1), glm::dvec3(1, 1, -2)}) {
    const auto field = [&](glm::dvec3 p) { return glm::dot(rise, p); };
    const MeshPiece piece = cubeOfTets(4, kStill, field);
    int met = 0;
    for (const auto& [ray, at] : raysAlongCells()) {
      if (std::abs(glm::dot(rise, ray.direction)) < 1e-9) continue;  // in the plane
      const auto found = isosurfaceOf(piece, field(at)).along(ray);
      ASSERT_EQ(found.size(), 1u) << rise.x << ' ' << rise.y << ' ' << rise.z;
      EXPECT_LT(glm::distance(ray.at(found[0].t), at), 1e-12);
      met++;
    }
    EXPECT_GT(met, 300);
  }
}

// With -1 on the border all rays that come from outside leave what is higher as often as they enter it. Half of the values are those
// of the isovalue.
TEST(MeshIsosurface, ClosesWhateverTheValuesAtItsPointsAre) {
  Uniform random(17);
  const auto border = [](glm::dvec3 p) { return !inBox(p, 0); };
  for (const double far : {0.0, 0.03}) {
    const MeshPiece piece = cubeOfTets(5, inside(far, 3), [&](glm::dvec3 p) {
      if (border(p)) return -1.0;
      const double r = random();
      return r < 0.5 ? 0.0 : r < 0.75 ? 1.0 : -1.0;
    });
    const MeshSurface surface = isosurfaceOf(piece, 0);
    size_t crossings = 0;
    for (int i = 0; i < 3000; i++) {
      const glm::dvec3 from = piece.points[size_t(random() * double(piece.points.size()))],
                       to = piece.points[size_t(random() * double(piece.points.size()))];
      const glm::dvec3 end = i % 3 ? to : to + random.inCube(0.1);
      if (from == end || (border(from) && border(end))) continue;
      Ray ray = towards(from, end);
      ray.origin -= 2.0 * ray.direction;
      const auto found = surface.along(ray);
      EXPECT_EQ(found.size() % 2, 0u);
      crossings += found.size();
    }
    EXPECT_GT(crossings, 1000u);
    for (size_t p = 0; p < piece.points.size(); p++) {
      if (piece.values[p] != 1) continue;
      for (int i = 0; i < 20; i++) {
        const glm::dvec3 to = piece.points[size_t(random() * double(piece.points.size()))];
        if (to == piece.points[p]) continue;
        EXPECT_EQ(surface.along(towards(piece.points[p], to)).size() % 2, 1u) << "from a higher place";
      }
    }
  }
}

// The rays go to where the surface crosses edges and faces of cells, as far as rounding lets them.
TEST(MeshIsosurface, ClosesForRaysToWhereItLeavesACell) {
  Uniform random(23);
  const MeshPiece piece =
      cubeOfTets(5, inside(0.03, 4), [&](glm::dvec3 p) { return inBox(p, 0) ? random.in(-1, 1.5) : -1.0; });
  const MeshSurface surface = isosurfaceOf(piece, 0.1);
  const auto& corners = piece.cells.points[kTets];
  const auto root = [&](uint32_t a, uint32_t b) {
    const double la = piece.values[a] - 0.1, lb = piece.values[b] - 0.1;
    return mix(piece.points[a], piece.points[b], la / (la - lb));
  };
  int rays = 0;
  for (size_t i = 0; i < corners.size(); i += 4) {
    const auto higher = [&](size_t k) { return piece.values[corners[i + k]] > 0.1; };
    if (higher(0) == higher(1) || higher(0) == higher(2)) continue;
    const glm::dvec3 one = root(corners[i], corners[i + 1]), other = root(corners[i], corners[i + 2]);
    for (const glm::dvec3 at : {one, other, mix(one, other, 0.3), mix(one, other, 0.5)})
      for (int k = 0; k < 8; k++) {
        const glm::dvec3 out = glm::normalize(random.inCube(1));
        EXPECT_EQ(surface.along(towards(at + 3.0 * out, at)).size() % 2, 0u);
        rays++;
      }
  }
  EXPECT_GT(rays, 1000);
}

TEST(MeshIsosurface, OfADistanceConvergesToASphere) {
  const glm::dvec3 centre(0.5);
  double before = 0;
  for (const uint32_t n : {6u, 12u, 24u}) {
    const MeshPiece piece =
        cubeOfTets(n, inside(0.1 / n, 2), [&](glm::dvec3 p) { return glm::dot(p - centre, p - centre); });
    const MeshSurface surface = isosurfaceOf(piece, 0.16);
    Uniform random(9);
    double largest = 0;
    for (int i = 0; i < 1000; i++) {
      const Ray inward = towards(centre + glm::normalize(random.inCube(1)) * 2.0, centre);
      const auto found = surface.along(inward);
      ASSERT_EQ(found.size(), 2u);
      for (const MeshCrossing& hit : found) {
        const glm::dvec3 out = inward.at(hit.t) - centre;
        largest = std::max(largest, std::abs(glm::length(out) - 0.4));
        EXPECT_GT(glm::dot(surface.upwards(hit, {}), glm::normalize(out)), 1 - 3.0 / n);
      }
      EXPECT_EQ(surface.along({centre, inward.direction}).size(), 1u);
    }
    if (before > 0) {
      EXPECT_LT(largest, before / 3) << "of second order";
    }
    before = largest;
  }
  EXPECT_LT(before, 2e-3);
}

TEST(MeshIsosurface, OnPlateausIsTheirBorderToHigherValues) {
  const auto crossings = [](auto field, double x) {
    const MeshSurface surface = isosurfaceOf(cubeOfTets(4, kStill, field), 0);
    std::vector<double> places;
    for (const glm::dvec3 side : {glm::dvec3(-1, 0.3, 0.4), glm::dvec3(2, 0.3, 0.4)}) {
      const Ray ray = towards(side, {x, 0.6, 0.55});
      for (const MeshCrossing& hit : surface.along(ray)) places.push_back(ray.at(hit.t).x);
    }
    return places;
  };
  using Places = std::vector<double>;
  EXPECT_EQ(crossings([](glm::dvec3 p) { return std::max(0.0, p.x - 0.5); }, 0.5), Places({0.5, 0.5}));
  EXPECT_EQ(crossings([](glm::dvec3 p) { return std::clamp(p.x - 0.5, 0.0, 0.125); }, 0.5),
            Places({0.5, 0.5}));
  EXPECT_EQ(crossings([](glm::dvec3 p) { return p.x < 0.4 ? -1.0 : std::max(0.0, p.x - 0.75); }, 0.75),
            Places({0.75, 0.75}))
      << "nothing on the lower side";
  EXPECT_EQ(crossings([](glm::dvec3 p) { return std::min(0.0, p.x - 0.5); }, 0.5), Places());
  EXPECT_EQ(crossings([](glm::dvec3) { return 0.0; }, 0.5), Places());
  EXPECT_EQ(crossings([](glm::dvec3 p) { return std::abs(p.x - 0.5); }, 0.5), Places({0.5, 0.5, 0.5, 0.5}))
      << "two where both sides are higher";
}

TEST(MeshIsosurface, HasHolesWhereTheMeshHasThem) {
  const Box hole{{0.3, 0.3, -1}, {0.7, 0.7, 2}};
  const auto field = [](glm::dvec3 p) { return p.z; };
  MeshPiece piece = without(cubeOfTets(6, kStill, field), hole);
  MeshPiece island = cubeOfTets(2, kStill, field);
  for (glm::dvec3& p : island.points) p += glm::dvec3(1.5, 0, 0);
  const auto first = uint32_t(piece.points.size());
  piece.points.insert(piece.points.end(), island.points.begin(), island.points.end());
  piece.values.insert(piece.values.end(), island.values.begin(), island.values.end());
  for (const uint32_t corner : island.cells.points[kTets])
    piece.cells.points[kTets].push_back(first + corner);
  const MeshSurface surface = isosurfaceOf(piece, 0.45);
  const MeshSurface slice = sliceOf(piece, {{0, 0, -2}, -0.9});
  Uniform random(12);
  int through = 0;
  for (int i = 0; i < 1000; i++) {
    const glm::dvec3 at(random.in(-0.1, 2.7), random.in(-0.1, 1.1), 0.45);
    const bool solid = at.y > 0 && at.y < 1 && ((at.x > 0 && at.x < 1) || (at.x > 1.5 && at.x < 2.5)) &&
                       !(at.x > 1 / 3.0 && at.x < 2 / 3.0 && at.y > 1 / 3.0 && at.y < 2 / 3.0);
    const Ray ray = towards(at + random.inCube(0.3) + glm::dvec3(0, 0, 2), at);
    EXPECT_EQ(surface.along(ray).size(), size_t(solid)) << at.x << ' ' << at.y;
    EXPECT_EQ(slice.along(ray).size(), size_t(solid)) << at.x << ' ' << at.y;
    through += !solid;
  }
  EXPECT_GT(through, 200);
}

TEST(MeshIsosurface, AndSlicesHaveNothingInCellsWithoutData) {
  for (const float none : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                           -std::numeric_limits<float>::infinity()}) {
    MeshPiece piece = cubeOfTets(2, inside(0.05, 6), linearAt);
    piece.values[13] = none;  // the middle, which is in cells of every cube
    MeshPiece left = cubeOfTets(2, inside(0.05, 6), linearAt);
    auto& cells = left.cells.points[kTets];
    std::vector<uint32_t> kept;
    for (size_t i = 0; i < cells.size(); i += 4)
      if (std::count(&cells[i], &cells[i] + 4, 13u) == 0) kept.insert(kept.end(), &cells[i], &cells[i] + 4);
    cells = kept;
    const Plane plane{{1, 0.5, 0.25}, 0.9};
    const MeshSurface one = isosurfaceOf(piece, 0.4), other = isosurfaceOf(left, 0.4);
    const MeshSurface oneSlice = sliceOf(piece, plane), otherSlice = sliceOf(left, plane);
    Uniform random(4);
    size_t hits = 0;
    for (int i = 0; i < 300; i++) {
      const Ray ray = towards({-2, 0.3, 0.1}, 0.5 + random.inCube(0.5));
      EXPECT_EQ(one.along(ray).size(), other.along(ray).size());
      EXPECT_EQ(oneSlice.along(ray).size(), otherSlice.along(ray).size());
      hits += one.along(ray).size() + oneSlice.along(ray).size();
    }
    EXPECT_GT(hits, 30u);
  }
}

TEST(MeshIsosurface, IsFoundInSliversAndCellsOfBothOrientations) {
  for (const double h : {1e-3, 1e-6, 1e-9, 1e-12}) {
    for (const bool inverted : {false, true}) {
      MeshPiece piece = oneCell({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, h}}}, {0, 0, 0, 1});
      if (inverted) {
        std::swap(piece.points[0], piece.points[1]);
      }
      const MeshSurface surface = isosurfaceOf(piece, 0.25);
      const auto found = surface.along(towards({0.3, 0.3, 5}, {0.3, 0.3, 0}));
      ASSERT_EQ(found.size(), 1u);
      EXPECT_NEAR(found[0].t, 5 - 0.25 * h, 2e-15);
      EXPECT_LT(glm::length(surface.upwards(found[0], {}) - glm::dvec3(0, 0, 1)), 1e-9);
      EXPECT_EQ(surface.along(towards({0.3, 0.3, 5}, {0.9, 0.9, 0})).size(), 0u);
    }
  }
}

TEST(MeshIsosurface, OfACellThatSeveralBlocksHaveIsMetOnce) {
  const MeshPiece whole = cubeOfTets(4, inside(0.05, 2), linearAt);
  auto cut = meshOf(whole);
  cut->blocks.clear();
  for (int part = 0; part < 3; part++) {
    // each has two thirds of the cells, numbered the other way round
    MeshBlock& block = cut->blocks[part];
    block.points = std::vector<glm::dvec3>(whole.points.rbegin(), whole.points.rend());
    block.values.assign(whole.values.rbegin(), whole.values.rend());
    const auto& cells = whole.cells.points[kTets];
    std::vector<uint32_t> some;
    for (size_t i = 0; i < cells.size(); i += 4)
      if (i / 4 % 3 != size_t(part))
        for (size_t k = 0; k < 4; k++)
          some.push_back(uint32_t(whole.points.size()) - 1 - cells[i + (k + part) % 4]);
    block.cells.points[kTets] = std::move(some);
  }
  const MeshField field(*cut, std::nullopt);
  Uniform random(8);
  int hits = 0;
  for (int i = 0; i < 300; i++) {
    const Ray ray = towards({-1, 0.2, 2}, 0.5 + random.inCube(0.5));
    const double t = (0.4 - linearAt(ray.origin)) / glm::dot(kRise, ray.direction);
    const auto found = field.isosurface(0.4).along(ray);
    ASSERT_EQ(found.size(), size_t(t > 0 && inBox(ray.at(t), 0)));
    if (found.empty()) continue;
    EXPECT_NEAR(found[0].t, t, 1e-12);
    hits++;
  }
  EXPECT_GT(hits, 50);
}

TEST(MeshSlice, IsThePlaneWithTheValuesThere) {
  const MeshPiece piece = cubeOfTets(8, inside(0.03, 1), linearAt);
  Uniform random(5);
  int hits = 0;
  for (const Plane& plane : {Plane{{1, 0, 0}, 0.5}, Plane{{0, -3, 0}, -1}, Plane{{1, 2, -1}, 0.7},
                             Plane{{1e-3, 0, 2e-3}, 1.4e-3}}) {
    const MeshSurface surface = sliceOf(piece, plane);
    for (int i = 0; i < 1000; i++) {
      const Ray ray = towards(0.5 + random.inCube(3), 0.5 + random.inCube(0.5));
      const double along = glm::dot(plane.normal, ray.direction);
      const double t = (plane.offset - glm::dot(plane.normal, ray.origin)) / along;
      const auto found = surface.along(ray);
      if (t > 0 && inBox(ray.at(t), 1e-9)) {
        ASSERT_EQ(found.size(), 1u);
        EXPECT_NEAR(found[0].t, t, 1e-12 + 1e-15 * glm::length(plane.normal) / std::abs(along));
        EXPECT_NEAR(found[0].value, linearAt(ray.at(found[0].t)), 1e-14);
        const glm::dvec3 aside(1e-6, -2e-6, 1e-6);
        EXPECT_NEAR(surface.valueNear(found[0], aside) - found[0].value, glm::dot(kRise, aside), 1e-6);
        hits++;
      } else if (t < 0 || !inBox(ray.at(t), -1e-9)) {
        EXPECT_EQ(found.size(), 0u);
      }
    }
  }
  EXPECT_GT(hits, 1000);
}

TEST(MeshSlice, IsMetOnceWhereItGoesThroughVerticesEdgesAndFaces) {
  const MeshPiece piece = cubeOfTets(4, kStill, linearAt);
  for (const glm::dvec3 normal : {glm::dvec3(1, 0, 0), glm::dvec3(0, 0, -1), glm::dvec3(1, -1, 0),
                                  glm::dvec3(1, 1, 1), glm::dvec3(1, 1, -2)}) {
    int met = 0;
    for (const auto& [ray, at] : raysAlongCells()) {
      if (std::abs(glm::dot(normal, ray.direction)) < 1e-9) continue;  // in the plane
      const auto found = sliceOf(piece, {normal, glm::dot(normal, at)}).along(ray);
      ASSERT_EQ(found.size(), 1u);
      EXPECT_LT(glm::distance(ray.at(found[0].t), at), 1e-12);
      EXPECT_NEAR(found[0].value, linearAt(at), 1e-14);
      met++;
    }
    EXPECT_GT(met, 300);
  }
}

}  // namespace
}  // namespace gxy::reference
