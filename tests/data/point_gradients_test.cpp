// SPDX-License-Identifier: Apache-2.0
#include "core/data/point_gradients.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "tests/support/cell_meshes.h"
#include "tests/support/meshes.h"

namespace gxy::point_gradients {
namespace {

const auto kStill = [](glm::dvec3) { return glm::dvec3(0); };
glm::dvec3 shaken(glm::dvec3 p) {
  return 0.025 * glm::dvec3(std::sin(91 * p.x + 57 * p.y), std::sin(33 * p.y + 71 * p.z + 1),
                            std::sin(83 * p.z + 44 * p.x + 2));
}
double slope(glm::dvec3 p) { return 3 + 0.5 * p.x - 2 * p.y + 1.25 * p.z; }

/// The gradient at each point of a mesh in one piece, per unit of length.
std::vector<glm::dvec3> gradientsIn(const Mesh& mesh, std::optional<int> component = {}) {
  const PointGradients gradients = localGradients(mesh, component);
  const glm::dvec3 size = mesh.box.hi - mesh.box.lo;
  const double side = std::max({size.x, size.y, size.z});
  std::vector<glm::dvec3> out;
  const std::vector<float>& all = gradients.at(0);
  for (size_t i = 0; i < all.size(); i += 3) out.push_back(glm::dvec3(all[i], all[i + 1], all[i + 2]) / side);
  return out;
}

void expectNear(glm::dvec3 a, glm::dvec3 b, double most, const std::string& what) {
  for (int i = 0; i < 3; i++) EXPECT_NEAR(a[i], b[i], most) << what << ", axis " << i;
}

TEST(PointGradients, LinearFunctionsAreExactInCellsOfAllKinds) {
  for (const MeshPiece& piece :
       {test::cubeOfTets(5, shaken, slope), test::cubeOfHexes(5, shaken, slope),
        test::cubeOfWedges(5, shaken, slope), test::cubeOfPyramids(5, shaken, slope)}) {
    const auto mesh = test::meshInOnePiece(piece);
    const auto gradients = gradientsIn(*mesh);
    ASSERT_EQ(gradients.size(), mesh->blocks.at(0).points.size());
    for (size_t p = 0; p < gradients.size(); p++)
      expectNear(gradients[p], {0.5, -2, 1.25}, 2e-5, "point " + std::to_string(p));
  }
}

// As the normals of isosurfaces in a uniform grid (docs/numerics.md).
TEST(PointGradients, AreCentralDifferencesInAUniformGrid) {
  const auto f = [](glm::dvec3 p) { return std::sin(3 * p.x) * p.y + p.z * p.z * p.x; };
  const auto mesh = test::meshInOnePiece(test::cubeOfHexes(8, kStill, f));
  const auto gradients = gradientsIn(*mesh);
  const double h = 1 / 8.0;
  for (size_t i = 0; i < gradients.size(); i++) {
    const glm::dvec3 p = mesh->blocks.at(0).points[i];
    glm::dvec3 expected;
    for (int a = 0; a < 3; a++) {
      glm::dvec3 before = p, after = p;
      before[a] = std::max(0.0, p[a] - h), after[a] = std::min(1.0, p[a] + h);
      expected[a] = (double(float(f(after))) - double(float(f(before)))) / (after[a] - before[a]);
    }
    expectNear(gradients[i], expected, 3e-5, "point " + std::to_string(i));
  }
}

TEST(PointGradients, CellsWithoutDataDoNotCount) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  MeshPiece piece = test::cubeOfHexes(4, kStill, slope);
  for (size_t p = 0; p < piece.points.size(); p++)
    if (piece.points[p].x == 1) piece.values[p] = kNan;
  const auto mesh = test::meshInOnePiece(piece);
  const auto gradients = gradientsIn(*mesh);
  for (size_t i = 0; i < gradients.size(); i++)
    expectNear(gradients[i], mesh->blocks.at(0).points[i].x == 1 ? glm::dvec3(0) : glm::dvec3(0.5, -2, 1.25),
               2e-5, "point " + std::to_string(i));
}

TEST(PointGradients, OfAComponentAndOfTheMagnitude) {
  MeshPiece piece = test::cubeOfTets(3, kStill, slope);
  piece.components = 2;
  piece.values.clear();
  for (const glm::dvec3& p : piece.points)
    piece.values.insert(piece.values.end(), {float(3 * (p.x + 1)), float(4 * (p.x + 1))});
  const auto mesh = test::meshInOnePiece(piece);
  for (const auto& [component, expected] : {std::pair(std::optional(0), 3.0), {1, 4.0}, {std::nullopt, 5.0}})
    for (const glm::dvec3& g : gradientsIn(*mesh, component))
      expectNear(g, {expected, 0, 0}, 1e-5, "gradient");
}

}  // namespace
}  // namespace gxy::point_gradients
