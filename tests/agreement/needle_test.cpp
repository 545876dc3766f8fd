// SPDX-License-Identifier: Apache-2.0
// The stress list's grids that are long and thin, with every kind of Vis.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/agreement/backend.h"
#include "tests/agreement/compare.h"

namespace gxy::agreement {
namespace {

/// 2 x 2 x 100,000 points, or the same along another axis, of a box of `thick` x `thick` x `length` around 0.
TestScene needle(const std::string& name, int axis, double thick, double length, glm::dvec3 eye) {
  TestScene scene = sceneFrom(name, eye, 8, 8);  // small: the reference walks every cell
  Grid grid;
  grid.points = {2, 2, 2};
  grid.points[size_t(axis)] = 100'000;
  glm::dvec3 size(thick);
  size[axis] = length;
  grid.origin = -0.5 * size;
  for (int a = 0; a < 3; a++) grid.spacing[a] = size[a] / double(grid.points[size_t(a)] - 1);
  Vis vis = rendered({{-1, 0}, {0, 0.1}, {1, 0.6}}, -1, 1);
  vis.referenceLength = 0.3 * std::min(thick, length);
  vis.isovalues = {0.35, -0.2};
  glm::dvec3 across(0);
  across[axis] = 1, across[(axis + 1) % 3] = 0.2 * length / thick;
  vis.slices = {{across, 0.05 * length}};
  scene.add(vis, makeVolume(grid, [=](glm::dvec3 p) { return waves(p / size * 2.0); }));
  return scene;
}

/// Spheres, a tube and triangles about the needle, as large as it is thick.
void addSolids(TestScene& scene, int axis, double thick, double length) {
  GeometryBlock balls, line, mesh = sphereMesh(8, true, false);
  std::vector<glm::dvec3> joints;
  for (double at : {-0.3, 0.1, 0.4}) {
    glm::dvec3 p(0.2 * thick);
    p[axis] = at * length;
    balls.points.push_back(p);
    p[(axis + 1) % 3] = -0.3 * thick;
    joints.push_back(p);
  }
  addLine(line, joints, {});
  for (glm::dvec3& p : mesh.points) p *= 0.3 * thick;
  Vis vis = surfaces(VisType::Particles);
  vis.radius0 = 0.25 * thick;
  scene.add(vis, makeGeometry(GeometryKind::Particles, balls));
  vis.type = VisType::PathLines;
  vis.radius0 = 0.1 * thick;
  scene.add(vis, makeGeometry(GeometryKind::PathLines, line));
  scene.add(surfaces(VisType::Triangles), makeGeometry(GeometryKind::Triangles, mesh));
  scene.visualization.lighting = lit({kSun}, false);
}

TEST(Needle, FlatCellsOneToTenThousand) {  // a box of 1 x 1 x 10, cells of 1 x 1 x 1e-4
  for (int axis : {0, 1, 2}) {
    glm::dvec3 eye(9, 6, 11);
    TestScene scene = needle("needle_flat_" + std::to_string(axis), axis, 1, 10, eye);
    addSolids(scene, axis, 1, 10);
    expectAgreement(embree(), scene, {}, 2, 5);
  }
}

/// Where float resolves a hundredth of the thickness, every pixel on the needle may be a flip; none is wrong.
void expectNoneWrong(const TestScene& scene) {
  const Comparison c = compare(embree(), scene);
  EXPECT_TRUE(c.finite && c.wrong.empty()) << c.report;
  EXPECT_GE(c.seen, 4) << c.report;
}

TEST(Needle, CubicCellsFromTheSideAndFromItsEnd) {  // a box of 1e-3 x 1e-3 x 100, cells of 1e-3
  TestScene scene = needle("needle_side", 2, 1e-3, 100, {0.004, 0.002, 0});
  scene.camera.viewdirection = {-0.004, -0.002, 0.0005};
  addSolids(scene, 2, 1e-3, 100);
  expectNoneWrong(scene);
  scene = needle("needle_end", 2, 1e-3, 100, {0, 0, 50.01});
  scene.camera.viewdirection = {0, 0, -1};
  scene.camera.aov = 4;
  scene.camera.dimensions = {3, 3};
  expectNoneWrong(scene);
}

}  // namespace
}  // namespace gxy::agreement
