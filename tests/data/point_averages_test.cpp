// SPDX-License-Identifier: Apache-2.0
#include "core/data/point_averages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/cell_meshes.h"
#include "tests/support/meshes.h"

namespace gxy::point_averages {
namespace {

using test::withCellValues;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
const auto kStill = [](glm::dvec3) { return glm::dvec3(0); };
const auto kZero = [](glm::dvec3) { return 0.0; };
double slope(glm::dvec3 p) { return 3 + 0.5 * p.x - 2 * p.y + 1.25 * p.z; }

/// Moves points inside [0, 1]^3 by up to 0.15 of a cube of 1/6; those of the border stay in it.
glm::dvec3 shaken(glm::dvec3 p) {
  glm::dvec3 by(0);
  for (int a = 0; a < 3; a++)
    if (p[a] > 0 && p[a] < 1) by[a] = 0.025 * std::sin(91 * p.x + 57 * p.y + 33 * p.z + 2 * a);
  return by;
}

std::vector<float> valuesOf(const MeshPiece& piece) {
  std::vector<float> all;
  for (const auto& values : piece.cellValues) all.insert(all.end(), values.begin(), values.end());
  return all;
}

std::vector<float> averagesOf(const MeshPiece& piece) {
  return averagesAtPoints(piece.points, piece.cells.view(), valuesOf(piece), piece.components);
}

bool isInside(const glm::dvec3& p) { return p.x > 0 && p.x < 1 && p.y > 0 && p.y < 1 && p.z > 0 && p.z < 1; }

std::vector<MeshPiece> meshes() {
  return {test::cubeOfTets(6, shaken, kZero), test::cubeOfHexes(6, shaken, kZero),
          test::cubeOfWedges(6, shaken, kZero), test::cubeOfAllCells(6, shaken, kZero)};
}

TEST(PointAverages, LinearFunctionsStayLinearInside) {
  for (const MeshPiece& piece : meshes()) {
    const std::vector<float> averages = averagesOf(withCellValues(piece, slope));
    size_t inside = 0;
    for (size_t p = 0; p < piece.points.size(); p++) {
      if (!isInside(piece.points[p]) || std::isnan(averages[p])) continue;
      EXPECT_NEAR(averages[p], slope(piece.points[p]), 2e-6);
      inside++;
    }
    EXPECT_GE(inside, 125u);
  }
}

// Planes at 0, 1, 3, 7, ...: at a point of a face the function that does not change across it is exact, along an edge one along it.
TEST(PointAverages, OnAFlatBorderFunctionsAlongItStayLinear) {
  MeshPiece piece = test::cubeOfHexes(5, kStill, kZero);
  for (glm::dvec3& p : piece.points)
    for (int a = 0; a < 3; a++) p[a] = std::exp2(std::round(5 * p[a])) - 1;
  const std::vector<float> along =
      averagesOf(withCellValues(piece, [](glm::dvec3 p) { return 2 * p.x - p.y; }));
  const std::vector<float> across = averagesOf(withCellValues(piece, [](glm::dvec3 p) { return p.z; }));
  for (size_t i = 0; i < piece.points.size(); i++) {
    const glm::dvec3& p = piece.points[i];
    if (p.x > 0 && p.x < 31 && p.y > 0 && p.y < 31) {
      EXPECT_NEAR(along[i], 2 * p.x - p.y, 1e-5);
    }
    const double expected = p.z == 0 ? 0.5 : (p.z == 31 ? 23 : p.z);  // the centre of the outer layer
    EXPECT_NEAR(across[i], expected, 1e-5);
  }
}

TEST(PointAverages, AreBetweenTheValuesAround) {
  for (const MeshPiece& piece : meshes()) {
    const MeshPiece rough = withCellValues(
        piece, [](glm::dvec3 p) { return std::sin(1e4 * (p.x + 2 * p.y + 3 * p.z)) > 0 ? 1.0 : -1.0; });
    const std::vector<float> averages = averagesOf(rough);
    bool differ = false;
    for (const float v : averages) {
      EXPECT_TRUE(std::isnan(v) || (v >= -1 && v <= 1)) << v;
      differ = differ || (v > -0.9f && v < 0.9f);
    }
    EXPECT_TRUE(differ);
  }
}

TEST(PointAverages, OfEqualValuesAreThat) {
  for (const MeshPiece& piece : meshes())
    for (const float v : averagesOf(withCellValues(piece, [](glm::dvec3) { return 0.1; })))
      EXPECT_TRUE(std::isnan(v) || v == 0.1f);
}

TEST(PointAverages, DoNotDependOnScale) {
  for (const MeshPiece& piece : meshes()) {
    const std::vector<float> expected = averagesOf(withCellValues(piece, slope));
    MeshPiece tiny = piece;
    for (glm::dvec3& p : tiny.points) p *= 0x1p-80;
    const std::vector<float> small =
        averagesOf(withCellValues(tiny, [](glm::dvec3 p) { return slope(0x1p80 * p); }));
    for (size_t i = 0; i < small.size(); i++)
      EXPECT_TRUE(small[i] == expected[i] || (std::isnan(small[i]) && std::isnan(expected[i])));
  }
}

TEST(PointAverages, CellsWithoutDataDoNotCount) {
  const auto field = [](glm::dvec3 p) { return p.x < 0.5 ? double(kNan) : slope(p); };
  const MeshPiece piece = withCellValues(test::cubeOfHexes(6, kStill, kZero), field);
  const std::vector<float> averages = averagesOf(piece);
  for (size_t p = 0; p < piece.points.size(); p++)
    EXPECT_EQ(std::isnan(averages[p]), piece.points[p].x < 0.4);
  MeshPiece two = piece;
  two.components = 2;
  std::vector<float>& values = two.cellValues[size_t(CellType::Hexahedron)];
  values.clear();
  for (const glm::dvec3& centre : test::centresOf(piece, CellType::Hexahedron)) {
    values.push_back(float(field(centre)));  // one component without data is enough
    values.push_back(float(centre.y));
  }
  const std::vector<float> both = averagesOf(two);
  for (size_t p = 0; p < piece.points.size(); p++) {
    EXPECT_EQ(std::isnan(both[2 * p + 1]), piece.points[p].x < 0.4);
    EXPECT_TRUE(std::isnan(averages[p]) ? std::isnan(both[2 * p]) : averages[p] == both[2 * p]);
  }
}

}  // namespace
}  // namespace gxy::point_averages
