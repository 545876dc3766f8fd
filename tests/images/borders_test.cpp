// SPDX-License-Identifier: Apache-2.0
// Cuts that run exactly where something is: nothing is lost or seen twice on a partition's face.
#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <tuple>

#include "tests/support/backends.h"
#include "tests/support/frames.h"

namespace gxy::test {
namespace {

const Box kCube{{-1, -1, -1}, {1, 1, 1}};

/// Whether pictures are as large as on Embree: most pixels are beside what these tests are about.
bool large() { return onReference() || allIsAsked(); }

// Rays that run exactly in the planes x = 0, y = 0, and for two of the axes along lattice lines.
Camera alongAxis(int axis, bool backwards, int pixels = large() ? 41 : 9) {
  Camera camera;
  camera.aov = 0;
  camera.height = large() ? 2.05 : 2.25;  // a pixel is 0.05 or 0.25 wide and the middle one is centred on 0
  camera.dimensions = {pixels, pixels};
  camera.viewpoint = {0, 0, 0};
  camera.viewpoint[axis] = backwards ? 4 : -4;
  camera.viewdirection = {0, 0, 0};
  camera.viewdirection[axis] = backwards ? -1 : 1;
  camera.viewup = axis == 1 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
  return camera;
}

TestScene cubeScene(const char* name) {
  const glm::ivec2 size(large() ? 48 : 16);
  TestScene s = emptyScene(name, size);
  s.domain = kCube;
  s.camera = cameraOutside(kCube, size);
  s.camera.aov = 44;
  return s;
}

Grid cubeGrid(int64_t points) {
  return {{-1, -1, -1}, glm::dvec3(2.0 / double(points - 1)), {points, points, points}};
}

void addField(TestScene& s, const Grid& grid, const std::function<double(glm::dvec3)>& f) {
  s.data.emplace_back(std::make_shared<const WholeVolume>(sampled(grid, f)));
  Vis& vis = s.visualization.operators.emplace_back();
  vis.type = VisType::Volume;
  vis.dataset = "field";
  vis.colormap = {{{-1, {1, 0, 0}}, {1, {0, 0, 1}}}};
  vis.opacitymap = {false, {{-1, 0.02}, {1, 0.1}}};
}

void addBalls(TestScene& s, const std::vector<glm::dvec3>& centres, double radius, double opacity) {
  WholeGeometry g;
  for (const glm::dvec3& c : centres) {
    g.block.ids.push_back(g.block.points.size());
    g.block.points.push_back(c);
  }
  s.data.emplace_back(std::make_shared<const WholeGeometry>(g));
  Vis& vis = s.visualization.operators.emplace_back();
  vis.type = VisType::Particles;
  vis.dataset = "balls";
  vis.radius0 = vis.radius1 = radius;
  vis.opacity = opacity;
}

void expectNoBorderSeen(TestScene scene, const std::vector<Cut>& cuts) {
  std::vector<Camera> cameras{scene.camera};
  for (int axis = 0; axis < 3; axis++)
    for (bool backwards : {false, true}) cameras.push_back(alongAxis(axis, backwards));
  // on Vulkan the commit decides which two of the axes' six
  const size_t drawn = 1 + seedOfTheCommit() % 3;
  for (size_t c = 0; c < cameras.size(); c++) {
    if (!large() && c != 0 && c != drawn && c != drawn + 3) continue;
    scene.camera = cameras[c];
    const Picture expected = wholeOnTested(scene);
    for (const Cut& cut : cuts)
      EXPECT_EQ(difference(expected, render(scene, cut), Sameness::Bits), "")
          << scene.name << ", camera " << c << ", " << cut.name;
  }
}

std::vector<Cut> cutsThroughCentre() {
  return {octants(kCube, {0, 0, 0}, 3), lattice(kCube, {1, 2, 1}, 2), lattice(kCube, {4, 4, 4}, 4)};
}

TEST(Border, IsosurfaceOnAFace) {
  for (int64_t points : {25, 32}) {  // the face on a grid plane, and through cells
    TestScene s = cubeScene("isosurface on a face");
    addField(s, cubeGrid(points), [](glm::dvec3 p) { return p.x; });
    s.visualization.operators[0].isovalues = {0, 0.5};
    s.visualization.operators[0].opacity = 0.5;
    expectNoBorderSeen(s, cutsThroughCentre());
  }
}

TEST(Border, SlicesOnFaces) {
  TestScene s = cubeScene("slices on faces");
  addField(s, cubeGrid(26), [](glm::dvec3 p) { return p.x * p.y + p.z; });
  s.visualization.operators[0].slices = {{{1, 0, 0}, 0}, {{0, 1, 0}, 0}, {{0, 0, -1}, 0.5}};
  s.visualization.operators[0].opacity = 0.4;
  expectNoBorderSeen(s, cutsThroughCentre());
}

TEST(Border, SpheresOnCorners) {
  for (double opacity : {1.0, 0.5}) {
    TestScene s = cubeScene("spheres on corners");
    addBalls(s, {{0, 0, 0}, {0.5, 0.5, 0.5}, {-0.5, 0, 0.5}, {0, 0.25, 0}}, 0.25, opacity);
    addLights(s);
    expectNoBorderSeen(s, cutsThroughCentre());
  }
}

TEST(Border, TrianglesInFaces) {
  TestScene s = cubeScene("triangles in faces");
  WholeGeometry g;
  g.kind = GeometryKind::Triangles;
  g.block.points = {{0, -0.5, -0.5}, {0, 0.5, -0.5}, {0, 0, 0.5},  {-0.5, 0, 0},
                    {0.5, 0, 0},     {0, 0, 0.75},   {0.5, 0.5, 0}};
  g.block.triangles = {{0, 1, 2}, {3, 4, 5}, {3, 4, 6}};
  g.block.ids = {0, 1, 2};
  s.data.emplace_back(std::make_shared<const WholeGeometry>(g));
  Vis& vis = s.visualization.operators.emplace_back();
  vis.type = VisType::Triangles;
  vis.dataset = "triangles";
  vis.opacity = 0.5;
  addLights(s);
  expectNoBorderSeen(s, cutsThroughCentre());
}

TEST(Border, CutsThroughMacrocellsAndCells) {
  TestScene s = cubeScene("cuts through macrocells");
  addField(s, cubeGrid(30), [](glm::dvec3 p) { return std::sin(4 * p.x) * std::cos(3 * p.y + p.z); });
  s.visualization.operators[0].volumeRendering = true;
  s.visualization.operators[0].opacitymap = {
      false, {{-1, 0}, {0.2, 0}, {0.25, 0.8}, {0.3, 0}, {0.31, 0.1}, {1, 0.2}}};
  std::vector<Cut> cuts = cutsThroughCentre();
  cuts.push_back(octants(kCube, {0.01, -0.013, 0.7}, 2));
  cuts.push_back(octants(kCube, {-0.97, 0.98, 0.5}, 2));  // slabs thinner than a cell
  cuts.push_back(lattice(kCube, {9, 1, 3}, 4));
  expectNoBorderSeen(s, cuts);
}

// Long segments reach far back over a border.
TEST(Border, CoarseSteps) {
  for (double step : {0.5, 2.0, 4.0, 11.0}) {
    TestScene s = cubeScene("coarse steps");
    addField(s, cubeGrid(30), [](glm::dvec3 p) { return std::sin(4 * p.x) * std::cos(3 * p.y + p.z); });
    s.visualization.operators[0].volumeRendering = true;
    s.settings.step = step;
    expectNoBorderSeen(s, {octants(kCube, {0.01, -0.013, 0.7}, 2), lattice(kCube, {5, 4, 3}, 4)});
  }
  for (double tolerance : {1e-4, 0.05, 0.9}) {
    TestScene s = cubeScene("loose tolerance");
    addField(s, cubeGrid(30), [](glm::dvec3 p) { return std::sin(4 * p.x) * std::cos(3 * p.y + p.z); });
    s.visualization.operators[0].volumeRendering = true;
    s.visualization.operators[0].opacitymap = {false, {{-1, 0.01}, {0.2, 0.01}, {0.2, 0.012}, {1, 0.02}}};
    s.settings.tolerance = tolerance;
    expectNoBorderSeen(s, {octants(kCube, {0.01, -0.013, 0.7}, 2), lattice(kCube, {5, 4, 3}, 4)});
  }
}

// By Beer and Lambert's law: through one volume, and through two that lie in each other.
TEST(Border, UniformSlabInAnyNumberOfPieces) {
  for (const auto& [sigma, step, volumes] : std::initializer_list<std::tuple<double, double, int>>{
           {0.1, 0, 1}, {3, 0, 1}, {3, 0.25, 1}, {2, 3, 1}, {20, 0, 1}, {1.5, 0, 2}, {0.05, 2, 2}}) {
    TestScene s = cubeScene("uniform slab");
    s.camera = alongAxis(2, false, 8);
    s.camera.height = 1.9;
    s.settings.background = glm::dvec4(0);
    s.settings.step = step;
    s.settings.tolerance = 1e-5;  // so that no ray ends early
    for (int v = 0; v < volumes; v++) {
      const Grid grid{{-1, -1, -1}, {0.5, 0.25, 2.0 / (16 + v)}, {5, 9, 17 + v}};
      addField(s, grid, [](glm::dvec3) { return 0.5; });
      s.visualization.operators.back().volumeRendering = true;
      s.visualization.operators.back().opacitymap = {true, {{0, sigma}, {1, sigma}}};
    }
    const Picture expected = wholeOnTested(s);
    const double alpha = -std::expm1(-2 * sigma * volumes), bound = std::max(1e-6, 1e-4 * alpha);
    for (int pieces : {1, 2, 7, 64}) {
      const Picture picture = render(s, lattice(kCube, {1, 1, pieces}, 2));
      EXPECT_EQ(difference(expected, picture, Sameness::Bits), "") << sigma << ", " << pieces << " pieces";
      for (size_t i = 3; i < picture.rgba.size(); i += 4)
        ASSERT_NEAR(picture.rgba[i], alpha, bound) << sigma << ", " << pieces << " pieces";
    }
  }
}

// The grid ends exactly on faces of the partitioning, and its last surfaces lie there.
TEST(Border, GridsThatEndOnFaces) {
  TestScene s = cubeScene("grid inside the domain");
  Grid grid{{-0.5, -0.5, -0.5}, glm::dvec3(1.0 / 24), {25, 25, 25}};
  addField(s, grid, [](glm::dvec3 p) { return p.x; });
  Vis& vis = s.visualization.operators[0];
  vis.volumeRendering = true;
  vis.isovalues = {-0.5, 0.5};
  vis.slices = {{{0, 1, 0}, 0.5}, {{0, 1, 0}, -0.5}, {{0, 0, 1}, 0.5}};
  vis.opacity = 0.5;
  Grid other{{-0.25, -0.75, 0}, {0.05, 0.03125, 0.05}, {16, 33, 21}};
  addField(s, other, [](glm::dvec3 p) { return p.y; });
  s.visualization.operators[1].volumeRendering = true;
  std::vector<Cut> cuts = cutsThroughCentre();
  cuts.push_back(octants(kCube, {0.5, 0.5, 0.5}, 2));
  cuts.push_back(octants(kCube, {-0.5, -0.5, -0.5}, 2));
  cuts.push_back(octants(kCube, {0.5 + 3e-8, 0.5 - 3e-8, 0.5 + 1e-9}, 2));
  cuts.push_back(octants(kCube, {0.25, 0.125, 0.7}, 2));
  expectNoBorderSeen(s, cuts);
}

// A camera so near that a pixel is smaller than the rounding of a partition's corner.
TEST(Border, MagnifiedCorner) {
  TestScene s = cubeScene("magnified corner");
  addField(s, cubeGrid(25), [](glm::dvec3 p) { return p.x + p.y; });
  s.visualization.operators[0].volumeRendering = true;
  addBalls(s, {{0.3, 0.2, 0.1}}, 0.3, 0.5);
  const glm::dvec3 corner(0.123456789, -0.0987654321, 0.4);
  for (double aov : {1e-2, 1e-5, 1e-7}) {
    s.camera.viewdirection = corner - s.camera.viewpoint;
    s.camera.aov = aov;
    const Picture expected = wholeOnTested(s);
    EXPECT_EQ(difference(expected, render(s, octants(kCube, corner, 8)), Sameness::Bits), "")
        << aov << " degrees";
  }
}

}  // namespace
}  // namespace gxy::test
