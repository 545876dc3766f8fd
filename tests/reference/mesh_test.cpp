// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "core/comm/error.h"
#include "tests/reference/mesh_samples.h"

namespace gxy::reference {
namespace {

double chord(const MeshPiece& piece, const Ray& ray) {
  return lengthOf(MeshField(*meshOf(piece), std::nullopt).along(ray, {}));
}

/// The length of a ray in a box, by slabs.
double chordOfBox(const Ray& ray, glm::dvec3 lo = glm::dvec3(0), glm::dvec3 hi = glm::dvec3(1)) {
  double in = 0, out = kInfinity;
  for (int a = 0; a < 3; a++) {
    const double s = (lo[a] - ray.origin[a]) / ray.direction[a],
                 e = (hi[a] - ray.origin[a]) / ray.direction[a];
    in = std::max(in, std::min(s, e)), out = std::min(out, std::max(s, e));
  }
  return std::max(0.0, out - in);
}

TEST(MeshReference, ChordsOfAConvexMeshAreThoseOfItsBox) {
  const MeshField field(*meshOf(cubeOfTets(6, inside(0.03, 1), kOne)), std::nullopt);
  Uniform random(5);
  for (int i = 0; i < 2000; i++) {
    const Ray ray = towards(0.5 + random.inCube(i % 2 ? 3 : 0.5), 0.5 + random.inCube(0.5));
    const auto spans = field.along(ray, {});
    double inBox = lengthOf(spans);
    if (!spans.empty()) inBox -= std::max(0.0, -spans.front().t0);
    EXPECT_NEAR(inBox, chordOfBox(ray), 1e-13);
    for (size_t k = 1; k < spans.size(); k++) EXPECT_NEAR(spans[k - 1].t1, spans[k].t0, 1e-14);
  }
}

TEST(MeshReference, RaysThroughVerticesEdgesAndFacesMeetEachStretchOnce) {
  const MeshField field(*meshOf(cubeOfTets(4, kStill, kOne)), std::nullopt);
  int met = 0;
  for (int dx = -2; dx <= 2; dx++)
    for (int dy = -2; dy <= 2; dy++)
      for (int dz = -2; dz <= 2; dz++) {
        if (dx == 0 && dy == 0 && dz == 0) continue;
        const glm::dvec3 d(dx, dy, dz);
        for (int i = 1; i < 8; i++) {
          const glm::dvec3 at = glm::dvec3(i, 3 * i % 8, 5 * i % 8) / 8.0;
          if (std::min({at.x, at.y, at.z}) == 0) continue;
          const Ray ray{at - 8.0 * d, glm::normalize(d)};
          const auto spans = field.along(ray, {});
          EXPECT_NEAR(lengthOf(spans), chordOfBox({at - 8.0 * d, glm::normalize(d)}), 1e-12)
              << dx << ' ' << dy << ' ' << dz << " at " << i;
          for (size_t k = 1; k < spans.size(); k++) EXPECT_NEAR(spans[k - 1].t1, spans[k].t0, 1e-12);
          met++;
        }
      }
  EXPECT_GT(met, 500);
}

TEST(MeshReference, OneCellInAnyOrderOfItsPointsHasItsChordAndIsLinear) {
  const std::array<glm::dvec3, 4> corners{glm::dvec3(0), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const auto value = [](glm::dvec3 p) { return 0.25 + 0.5 * p.x - 0.25 * p.y + p.z; };
  std::array<size_t, 4> order{0, 1, 2, 3};
  do {
    MeshPiece piece =
        oneCell({corners[order[0]], corners[order[1]], corners[order[2]], corners[order[3]]}, {});
    for (size_t k = 0; k < 4; k++) piece.values[k] = float(value(piece.points[k]));
    const Ray ray = towards({-1, 0.2, 0.3}, {1, 0.25, 0.1});
    const auto spans = MeshField(*meshOf(piece), std::nullopt).along(ray, {});
    ASSERT_EQ(spans.size(), 1u);
    // in through x = 0, out through x + y + z = 1
    const double in = 1 / ray.direction.x, out = 1.5 / (ray.direction.x + ray.direction.y + ray.direction.z);
    EXPECT_NEAR(spans[0].t0, in, 1e-15);
    EXPECT_NEAR(spans[0].t1, out, 1e-15);
    EXPECT_NEAR(spans[0].value.b[0], value(ray.at(in)), 1e-15);
    EXPECT_NEAR(spans[0].value.b[3], value(ray.at(out)), 1e-15);
    EXPECT_TRUE(MeshField(*meshOf(piece), std::nullopt).along({{-1, 0.2, 0.9}, {1, 0, 0}}, {}).empty());
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(MeshReference, SliversHaveTheirThinChordAndFlatCellsHaveNone) {
  for (const double h : {1e-3, 1e-6, 1e-9, 1e-12}) {
    const MeshPiece piece = oneCell({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, h}}}, {0, 0, 0, 1});
    const Ray ray = towards({0.3, 0.3, 5}, {0.3, 0.3, 0});
    EXPECT_NEAR(chord(piece, ray) / h, 1, 1e-3 + 2e-15 / h);
    EXPECT_NEAR(chord(piece, towards({0.1, 0.2, 5}, {0.9, 0.8, -5})), 0, 2 * h)
        << "almost edge-on to nothing";
    // lengthwise: in at the edge x = 0, out over the plane of the tip
    EXPECT_LE(chord(piece, towards({-1, 0.3, h / 2}, {1, 0.3, h / 2})), 1.0);
    EXPECT_GT(chord(piece, towards({-1, 0.3, h / 2}, {1, 0.3, h / 2})), 0.1);
  }
  for (const glm::dvec3 last : {glm::dvec3(1, 1, 0), glm::dvec3(0.3, 0.3, 0), glm::dvec3(0.5, 0.5, 0)}) {
    const MeshPiece flat = oneCell({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, last}}, {1, 1, 1, 1});
    for (const glm::dvec3 at : {glm::dvec3(0.2, 0.1, 0), glm::dvec3(0.5, 0.5, 0), glm::dvec3(0.1, 0.6, 0)}) {
      EXPECT_NEAR(chord(flat, towards({0.4, 0.3, 5}, at)), 0, 1e-14);
      EXPECT_EQ(chord(flat, towards({0, 0, 0}, at)), 0) << "in its plane";
    }
  }
}

TEST(MeshReference, AGapInAConcaveOutlineIsEmpty) {
  // a horseshoe: open at the top
  const Box gap{{0.25, 0.25, -1}, {0.75, 2, 2}};
  const MeshPiece piece = without(cubeOfTets(4, kStill, kOne), gap);
  Uniform random(11);
  int through = 0;
  for (int i = 0; i < 300; i++) {
    const Ray ray = towards(glm::dvec3(-2, random.in(0, 1), random.in(0, 1)),
                            glm::dvec3(3, random.in(0, 1), random.in(0, 1)));
    const double empty = chordOfBox(ray, {0.25, 0.25, 0}, {0.75, 1, 1});
    EXPECT_NEAR(chord(piece, ray), chordOfBox(ray) - empty, 1e-13);
    through += empty > 0;
  }
  EXPECT_GT(through, 100);
}

TEST(MeshReference, AHoleOfOneCellIsEmpty) {
  const MeshPiece whole = cubeOfTets(3, inside(0.05, 2), kOne);
  MeshPiece holed = whole, hole = whole;
  const size_t taken = 4 * (6 * 13 + 2);  // in the middle cube
  auto& cells = holed.cells.points[kTets];
  hole.cells.points[kTets].assign(cells.begin() + taken, cells.begin() + taken + 4);
  cells.erase(cells.begin() + taken, cells.begin() + taken + 4);
  Uniform random(3);
  int through = 0;
  for (int i = 0; i < 300; i++) {
    const Ray ray = towards(glm::dvec3(0.5) + glm::dvec3(3, 1, 2) + random.inCube(0.5),
                            glm::dvec3(0.5) + random.inCube(0.2));
    EXPECT_NEAR(chord(holed, ray) + chord(hole, ray), chord(whole, ray), 1e-13);
    through += chord(hole, ray) > 0;
  }
  EXPECT_GT(through, 30);
}

TEST(MeshReference, CellsWithAPointWithoutDataAreTransparent) {
  for (const float none : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    MeshPiece piece = cubeOfTets(2, kStill, kOne);
    piece.values[13] = none;  // the middle, which is in cells of every cube
    MeshPiece left = cubeOfTets(2, kStill, kOne);
    auto& cells = left.cells.points[kTets];
    std::vector<uint32_t> kept;
    for (size_t i = 0; i < cells.size(); i += 4)
      if (std::count(&cells[i], &cells[i] + 4, 13u) == 0) kept.insert(kept.end(), &cells[i], &cells[i] + 4);
    ASSERT_LT(kept.size(), cells.size());
    cells = kept;
    Uniform random(4);
    for (int i = 0; i < 100; i++) {
      const Ray ray = towards({-2, 0.3, 0.1}, 0.5 + random.inCube(0.5));
      EXPECT_EQ(chord(piece, ray), chord(left, ray));
    }
  }
}

TEST(MeshReference, CellsThatSeveralBlocksHaveCountOnce) {
  const MeshPiece whole = cubeOfTets(3, inside(0.05, 2), [](glm::dvec3 p) { return p.x; });
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
  const MeshField one(*meshOf(whole), std::nullopt), several(*cut, std::nullopt);
  EXPECT_EQ(several.cells(), one.cells());
  Uniform random(8);
  for (int i = 0; i < 100; i++) {
    const Ray ray = towards({-1, 0.2, 2}, 0.5 + random.inCube(0.5));
    EXPECT_NEAR(lengthOf(several.along(ray, {})), lengthOf(one.along(ray, {})), 1e-14);
  }
}

TEST(MeshReference, ComponentsAndMagnitudesAreTrueValuesAtThePoints) {
  MeshPiece piece = oneCell({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {});
  piece.components = 2;
  piece.values = {3, 4, 6, 8, 3, 4, 3, 4};
  auto mesh = meshOf(piece);
  mesh->shift = 0, mesh->scale = 2;
  const Ray alongEdge = towards({-1, 1e-9, 1e-9}, {1, 1e-9, 1e-9});
  const auto ends = [&](std::optional<int> component) {
    const auto spans = MeshField(*mesh, component).along(alongEdge, {});
    return spans.size() == 1 ? std::array{spans[0].value.b[0], spans[0].value.b[3]} : std::array{-1.0, -1.0};
  };
  EXPECT_NEAR(ends(0)[0], 6, 1e-7);
  EXPECT_NEAR(ends(0)[1], 12, 1e-7);
  EXPECT_NEAR(ends(1)[0], 8, 1e-7);
  EXPECT_NEAR(ends(1)[1], 16, 1e-7);
  EXPECT_NEAR(ends(std::nullopt)[0], 10, 1e-7);
  EXPECT_NEAR(ends(std::nullopt)[1], 20, 1e-7);
  EXPECT_THROW(MeshField(*mesh, 2), Error);
}

TEST(MeshReference, TheTypicalLengthIsTheSideOfACubeAsLargeAsACell) {
  auto mesh = meshOf(cubeOfTets(4, kStill, kOne));
  EXPECT_NEAR(typicalLength(*mesh), 1 / std::cbrt(384.0), 1e-15);
  mesh->box = {{0, 0, 0}, {1e-30, 1e-30, 1e-30}};
  EXPECT_NEAR(typicalLength(*mesh) * 1e30, 1 / std::cbrt(384.0), 1e-12);
  mesh->box = {{0, 0, 0}, {2, 1, 0}};
  EXPECT_NEAR(typicalLength(*mesh), 2 / std::cbrt(384.0), 1e-15);
  EXPECT_EQ(typicalLength(Mesh()), 1);
}

}  // namespace
}  // namespace gxy::reference
