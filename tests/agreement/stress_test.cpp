// SPDX-License-Identifier: Apache-2.0
// The stress list: coordinates, grids, values, maps, primitives and cameras at their limits.
#include <gtest/gtest.h>
#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>

#include "core/data/bricks.h"
#include "core/kernels/single_views.h"
#include "core/scene/state_file.h"
#include "fields_ispc.h"
#include "tests/agreement/backend.h"
#include "tests/agreement/compare.h"
#include "tests/support/every_cell.h"

namespace gxy::agreement {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN(),
                kInfinite = std::numeric_limits<float>::infinity();

/// The volume and an isosurface, a slice, spheres and tubes, with shadows.
TestScene mixed(const std::string& name, int size = 40) {
  TestScene scene = solids(name, size);
  scene.add(rendered({{-1, 0}, {0, 0}, {1, 0.3}}, -1, 1), wavy());
  scene.visualization.lighting = lit({kSun, kLamp}, true);
  return scene;
}

void expectFinite(const TestScene& scene) {
  const Picture picture = drawnByBoth(scene);
  for (float x : picture.rgba) ASSERT_TRUE(std::isfinite(x)) << scene.name;
  for (double x : picture.depth) ASSERT_GE(x, 0) << scene.name;
}

TEST(Stress, PowersOfTwoOfScaleLeaveEveryBit) {
  const TestScene scene = mixed("scaled");
  const Picture one = drawnByBoth(scene);
  for (double factor : {0x1p-100, 0x1p100, 0.5, 0x1p20})
    EXPECT_EQ(drawnByBoth(moved(scene, factor, glm::dvec3(0))).rgba, one.rgba) << factor;
}

TEST(Stress, AnyScaleLeavesThePicture) {
  const TestScene scene = mixed("scaled");
  const Picture one = drawnByBoth(scene);
  for (double factor : {1e-30, 1e30, 1e-3, 1e7}) {
    const Picture other = drawnByBoth(moved(scene, factor, glm::dvec3(0)));
    int differ = 0;
    for (size_t i = 0; i < one.rgba.size(); i += 4)
      for (int c = 0; c < 3; c++)
        if (std::abs(one.rgba[i + c] - other.rgba[i + c]) > 1.0 / 512) {
          differ++;
          break;
        }
    EXPECT_LE(differ, 2) << factor;  // flips
  }
}

TEST(Stress, CoordinatesFarFromTheOrigin) {
  expectAgreement(embree(), moved(mixed("offset"), 1, {1e6, -1e6, 1e6}));
}

TEST(Stress, CameraAMillionExtentsAway) {
  TestScene scene = mixed("far_away");
  scene.camera.viewpoint *= 1e6 / 4;
  scene.camera.aov = 35 / 2.5e5;
  expectAgreement(embree(), scene, {}, 8);  // an edge of the floor runs along pixels
}

TEST(Stress, AnisotropicSpacing) {
  for (glm::dvec3 stretch : {glm::dvec3(1, 1, 1e-4), glm::dvec3(1e-4, 1, 1)}) {
    TestScene scene =
        sceneFrom("anisotropic_" + std::to_string(int(stretch.x < 1)) + std::to_string(int(stretch.y < 1)),
                  {2.1, 1.4, 3.3}, 40, 40);
    Grid grid = cube(24);
    grid.origin *= stretch;
    grid.spacing *= stretch;
    Vis vis = rendered({{-1, 0}, {1, 0.3}}, -1, 1);
    vis.referenceLength = 0.1;
    vis.isovalues = {0.3};
    vis.opacity = 0.5;
    scene.add(vis, makeVolume(grid, [&](glm::dvec3 p) { return waves(p / stretch); }));
    expectAgreement(embree(), scene, {}, -1, 20);
  }
}

/// Rays along z through every grid point, edge and face of a cube of n^3 points in [-1, 1]^3.
Camera onGridPoints(int n) {
  Camera camera;
  camera.viewpoint = {0, 0, 4};
  camera.aov = 0;
  camera.dimensions = {2 * n + 1, 2 * n + 1};
  camera.height =
      (2 * n + 1) / double(n - 1);  // pixels of half a cell, centres on points and on cell centres
  return camera;
}

TEST(Stress, RaysInGridPlanesAndThroughGridPoints) {
  TestScene scene = sceneFrom("grid_planes", {0, 0, 4}, 8, 8);
  Vis vis = rendered({{-1, 0.1}, {1, 0.4}}, -1, 1);
  vis.isovalues = {0.3};
  vis.opacity = 0.5;
  scene.add(vis, makeVolume(cube(9), waves));
  scene.camera = onGridPoints(9);
  // The border itself is a silhouette: one ring of pixels, in which the data are met or missed.
  const Comparison c = compare(embree(), scene);
  for (glm::ivec2 p : c.wrong) EXPECT_TRUE(p.x == 1 || p.y == 1 || p.x == 17 || p.y == 17) << c.report;
  const Picture picture = draw(embree(), scene);
  scene.camera.height *= 1 - 1e-6;  // inside
  const reference::ReferencePicture inside = reference::renderReference(scene.forReference(), scene.camera);
  for (size_t i = 0; i < picture.rgba.size(); i += 4) {
    double met = 0, missed = 0;
    for (size_t k = 0; k < 3; k++) {
      met = std::max(met, std::abs(picture.rgba[i + k] - double(inside.rgba[i + k])));
      missed = std::max(missed, std::abs(picture.rgba[i + k] - scene.settings.background[int(k)]));
    }
    EXPECT_LE(std::min(met, missed), 1 / 512.0) << "pixel " << i / 4 % 19 << ", " << i / 4 / 19;
  }
  EXPECT_TRUE(c.finite);
  EXPECT_GE(c.seen, 17 * 17 - 70);
}

TEST(Stress, CameraOnAFaceAndOnAGridPoint) {
  for (glm::dvec3 eye :
       {glm::dvec3(0.1, 0.3, 1), glm::dvec3(1, 1, 1), glm::dvec3(0, 0, 0), glm::dvec3(-1, 0.5, 0)}) {
    TestScene scene = sceneFrom("eye_on_border", eye, 32, 32);
    scene.camera.viewdirection = glm::dvec3(0.05, 0.02, 0.01) - eye * 1.01;
    if (eye == glm::dvec3(0)) scene.camera.viewdirection = {0, 0, -1};
    scene.camera.aov = 80;
    Vis vis = rendered({{-1, 0}, {1, 0.2}}, -1, 1);
    vis.isovalues = {0.6};
    scene.add(vis, makeVolume(cube(17), waves));
    expectAgreement(embree(), scene, {}, 4);
  }
}

TEST(Stress, FieldOfView179Degrees) {
  TestScene scene = mixed("wide_angle", 48);
  scene.camera.aov = 179;
  scene.camera.viewpoint = {0.1, 0.2, 2.5};
  scene.camera.viewdirection = {0, 0, -1};
  expectAgreement(embree(), scene, {}, -1, 0);
}

TEST(Stress, ConstantFields) {
  for (double value : {0.0, 0.3, -7e20}) {
    TestScene scene = sceneFrom("constant", {2.1, 1.4, 3.3}, 24, 24);
    Vis vis = rendered({{value - 1, 0.2}, {value + 1, 0.2}}, value - 1, value + 1);
    vis.slices = {{{0, 0, 1}, 0.2}};
    vis.opacity = 0.5;
    scene.add(vis, makeVolume(cube(12), [=](glm::dvec3) { return value; }));
    expectAgreement(embree(), scene, {}, 2);
    scene.visualization.operators[0].isovalues = {value};  // a plateau: hit where the ray enters it
    expectFinite(scene);
  }
}

TEST(Stress, IsovaluesEqualToSamplesMinimumAndMaximum) {
  TestScene scene = sceneFrom("iso_at_samples", {2.13, 1.41, 3.37}, 48, 48);
  Vis vis = surfaces(VisType::Volume, 0, 6);
  vis.isovalues = {3};
  // whole numbers, without plateaus: the isosurface runs through grid points
  scene.add(vis, makeVolume(cube(13), [](glm::dvec3 p) { return std::round(6 * (p.x + p.y + p.z)); }));
  expectAgreement(embree(), scene, {}, 4);
  for (double extreme : {-18.0, 18.0}) {  // a single corner
    scene.visualization.operators[0].isovalues = {extreme};
    expectFinite(scene);
  }
}

// Found by random scenes: 0.4 is no float, but a plateau of samples 0.4 in float is met.
TEST(Stress, IsovaluesAreComparedAsSamplesAreStored) {
  TestScene scene = sceneFrom("iso_as_stored", {2.13, 1.41, 3.37}, 32, 32);
  Vis vis = surfaces(VisType::Volume, 0, 1);
  vis.isovalues = {0.4};
  scene.add(vis, makeVolume(cube(6), [](glm::dvec3) { return 0.4; }));
  expectAgreement(embree(), scene, {}, 2);
}

// Found by random scenes: the step at the end of a data range that ends at a plateau.
TEST(Stress, StepsOfMapsAreComparedAsSamplesAreStored) {
  for (const double plateau : {0.4, 0.7}) {  // whose floats are above and below them
    TestScene scene = sceneFrom("step_as_stored", {2.13, 1.41, 3.37}, 32, 32);
    scene.add(rendered({{0, 0.1}, {plateau, 0.1}, {plateau, 0.5}, {1, 0.5}}, 0, 1),
              makeVolume(cube(6), [&](glm::dvec3) { return plateau; }));
    expectAgreement(embree(), scene);
  }
}

TEST(Stress, UnsortedMapPointsAreThoseSorted) {
  Visualization sorted;
  sorted.operators = {rendered({{-1, 0}, {-0.2, 0.3}, {0.1, 0.05}, {1, 0.3}}, -1, 1)};
  Visualization unsorted = sorted;
  auto& points = unsorted.operators[0].opacitymap.points;
  std::swap(points[0], points[2]);
  std::reverse(unsorted.operators[0].colormap.points.begin(), unsorted.operators[0].colormap.points.end());
  State state;
  unsorted.operators[0].dataset = "data";
  state.datasets = {{"data", DatasetType::Volume, "data.vti", "", glm::dvec4(1)}};
  state.visualizations = {unsorted};
  TestScene scene = sceneFrom("unsorted", {2.1, 1.4, 3.3}, 24, 24);
  scene.add(readState(writeState(state), "unsorted").state.visualizations[0].operators[0], wavy());
  TestScene other = sceneFrom("sorted", {2.1, 1.4, 3.3}, 24, 24);
  other.add(sorted.operators[0], wavy());
  EXPECT_EQ(drawnByBoth(scene).rgba, drawnByBoth(other).rgba);
  expectAgreement(embree(), scene);
}

TEST(Stress, SamplesWithoutData) {
  TestScene scene = sceneFrom("no_data", {2.1, 1.4, 3.3}, 40, 40);
  Vis vis = surfaces(VisType::Volume, -1, 1);
  vis.isovalues = {0.2};
  vis.slices = {{{0.1, 0, 1}, -0.2}};
  auto holes = [](glm::dvec3 p) {
    const double r = glm::length(p - glm::dvec3(0.3, 0.2, 0.4));
    return r < 0.35     ? double(kNaN)
           : p.x < -0.8 ? double(kInfinite)
           : p.y > 0.9  ? -double(kInfinite)
                        : waves(p);
  };
  scene.add(vis, makeVolume(cube(24), holes));
  expectAgreement(embree(), scene, {}, 4);
  scene.name = "no_data_rendered";
  scene.visualization.operators[0] = rendered({{-1, 0}, {1, 0.2}}, -1, 1);
  expectAgreement(embree(), scene);
  scene.data[0].volume = makeVolume(cube(6), [](glm::dvec3) { return double(kNaN); });
  expectFinite(scene);
}

/// waves(p), scaled, volume and surfaces under a map that is scaled alike.
TestScene scaledWaves(double scale, ScalarType type = ScalarType::Float32) {
  TestScene scene = sceneFrom("values_scaled", {2.1, 1.4, 3.3}, 32, 32);
  Vis vis = rendered({{-scale, 0}, {scale, 0.4}}, -scale, scale);
  vis.isovalues = {0.3 * scale};
  vis.slices = {{{0, 0, 1}, 0.2}};
  vis.opacity = 0.5;
  scene.add(vis, makeVolume(
                     cube(12), [=](glm::dvec3 p) { return scale * waves(p); }, type));
  return scene;
}

TEST(Stress, DenormalSamples) {
  TestScene scene = sceneFrom("denormal", {2.1, 1.4, 3.3}, 24, 24);
  Vis vis = rendered({{-1, 0}, {1, 0.4}}, -1, 1);
  vis.isovalues = {0.2};
  scene.add(vis, makeVolume(cube(12), [](glm::dvec3 p) { return p.x > 0 ? waves(p) : 1e-41 * waves(p); }));
  expectAgreement(embree(), scene);
  // denormal throughout, the last in steps of a seventieth
  for (double scale : {1e-36, 1e-38, 1e-40, 1e-43}) expectAgreement(embree(), scaledWaves(scale));
}

TEST(Stress, ValuesOfAnySize) {
  for (double scale : {1e-20, 1e20, 3e38}) expectAgreement(embree(), scaledWaves(scale));
  for (double scale : {1e-60, 1e60}) expectAgreement(embree(), scaledWaves(scale, ScalarType::Float64));
}

TEST(Stress, MapsThatReachFarBeyondTheValues) {
  for (ScalarType type : {ScalarType::Float32, ScalarType::Float64}) {
    TestScene scene = scaledWaves(1e-40, type);
    Vis& vis = scene.visualization.operators[0];
    vis.opacitymap.points = {{-1, 0}, {3, 0.4}};  // all values lie at a quarter of it
    vis.colormap.points = {{-1, {1, 0, 0}}, {3, {0, 0, 1}}};
    vis.isovalues.push_back(0.5);
    expectAgreement(embree(), scene);
    vis.opacitymap.points = {{1, 0}, {3, 0.4}};
    vis.isovalues = {0.5};
    for (float x : drawnByBoth(scene).rgba) EXPECT_TRUE(std::isfinite(x));
  }
}

TEST(Stress, MapsAtTheirLimits) {
  struct Case {
    const char* name;
    Vis vis;
  };
  Vis onePoint = rendered({{0.3, 0.2}});
  onePoint.colormap.points = {{0.5, {1, 0.5, 0.2}}};
  const Case cases[] = {
      {"one_point", onePoint},
      {"zero_width_peak", rendered({{-1, 0}, {0.2, 0}, {0.2, 1}, {0.2, 0}, {1, 0}}, -1, 1)},
      {"opaque_in_one_segment", rendered({{-1, 1}, {1, 1}}, -1, 1)},
      {"extinction_1e6", rendered({{-1, 1e6}, {1, 1e6}}, -1, 1, true)},
      {"transparent", rendered({{-1, 0}, {1, 0}}, -1, 1)},
  };
  for (const Case& c : cases) {
    TestScene scene = sceneFrom(c.name, {2.1, 1.4, 3.3}, 32, 32);
    scene.add(c.vis, wavy());
    expectAgreement(embree(), scene, {}, -1, 0);
  }
}

TEST(Stress, ShellLittleThickerThanACell) {
  TestScene scene = sceneFrom("shell", {2.1, 1.4, 3.3}, 40, 40);
  const double cell = 2.0 / 31, thickness = 1.2 * cell;
  Vis vis = rendered(
      {{0.7, 0}, {0.7 + 0.1 * cell, 0.8}, {0.7 + thickness - 0.1 * cell, 0.8}, {0.7 + thickness, 0}});
  scene.add(vis, makeVolume(cube(32), [](glm::dvec3 p) { return glm::length(p); }));
  expectAgreement(embree(), scene);
}

TEST(Stress, SmallestGrids) {
  for (Index3 points : {Index3{2, 2, 2}, Index3{2, 2, 40}, Index3{2, 30, 2}, Index3{33, 2, 2}}) {
    TestScene scene = sceneFrom("grid_" + std::to_string(points[0]) + "_" + std::to_string(points[1]) + "_" +
                                    std::to_string(points[2]),
                                {2.1, 1.4, 3.3}, 32, 32);
    Grid grid;
    grid.points = points;
    grid.origin = glm::dvec3(-1);
    for (int a = 0; a < 3; a++) grid.spacing[a] = 2.0 / double(points[a] - 1);
    Vis vis = rendered({{-1, 0}, {1, 0.4}}, -1, 1);
    vis.isovalues = {0.1};
    vis.opacity = 0.6;
    scene.add(vis, makeVolume(grid, waves));
    expectAgreement(embree(), scene);
  }
}

TEST(Stress, ValuesFarFromZero) {
  TestScene scene = sceneFrom("values_offset", {2.1, 1.4, 3.3}, 32, 32);
  const double offset = 4e9;  // waves span less than 4
  Vis vis = rendered({{offset - 1, 0}, {offset + 1, 0.4}}, offset - 1, offset + 1);
  vis.isovalues = {offset + 0.3};
  vis.opacity = 0.5;
  scene.add(vis, makeVolume(
                     cube(20), [=](glm::dvec3 p) { return offset + waves(p); }, ScalarType::Float64));
  expectAgreement(embree(), scene);
}

TEST(Stress, DegeneratePrimitives) {
  TestScene scene = sceneFrom("degenerate", {2.1, 1.4, 3.3}, 64, 64);
  GeometryBlock balls;
  balls.points = {{0, 0, 0}, {0.5, 0, 0}, {0, 0.6, 0.1}};
  balls.values = {0, 1, 0.5};
  Vis vis = surfaces(VisType::Particles);
  vis.radius0 = 0, vis.radius1 = 0.3, vis.value0 = 0, vis.value1 = 1;
  scene.add(vis, makeGeometry(GeometryKind::Particles, balls));
  GeometryBlock line;  // no length, nested, and a needle
  addLine(line, {{-0.5, 0, 0}, {-0.5, 0, 0}, {-0.5, 0.3, 0}, {-0.5, 0.35, 0}, {-0.2, 0.9, 0}},
          {0.5f, 0.5f, 0.6f, 1.f, 0.f});
  addLine(line, {{0, -0.8, 0}, {0, -0.8, 0}}, {0.7f, 0.7f});
  vis.type = VisType::PathLines;
  scene.add(vis, makeGeometry(GeometryKind::PathLines, line));
  GeometryBlock mesh = sphereMesh(6, false, false);  // whose poles are edges of no length
  for (glm::dvec3& p : mesh.points) p = 0.4 * p + glm::dvec3(0.6, -0.6, 0);
  mesh.points.push_back({-1, -1, 0});
  mesh.points.push_back({1, 1, 0});
  mesh.points.push_back({0, 0, 0});
  const auto n = uint32_t(mesh.points.size());
  mesh.triangles.push_back({n - 3, n - 2, n - 1});  // on one line
  mesh.triangles.push_back({n - 1, n - 1, n - 1});
  scene.add(surfaces(VisType::Triangles), makeGeometry(GeometryKind::Triangles, mesh));
  scene.visualization.lighting = lit({kSun}, true);
  expectAgreement(embree(), scene);
}

TEST(Stress, AMillionCoincidentParticles) {
  TestScene scene = sceneFrom("coincident", {0, 0, 4}, 2, 2);
  scene.settings.background = glm::dvec4(0);
  GeometryBlock balls;
  balls.points.assign(1'000'000, {0.1, 0.2, 0.3});
  Vis vis = surfaces(VisType::Particles);
  vis.radius0 = 2;
  scene.add(vis, makeGeometry(GeometryKind::Particles, balls));
  const Picture picture = drawnByBoth(scene);
  for (size_t i = 3; i < picture.rgba.size(); i += 4) EXPECT_EQ(picture.rgba[i], 1);
  for (double depth : picture.depth) EXPECT_NEAR(depth, 4 - 0.3 - 2, 0.2);
}

TEST(Stress, MoreSamplesThanAnInt32Counts) {
  // 1291^3 bytes, of which only those of the last planes are ever touched: 100 in the last 9, 0 before.
  const int64_t n = 1291;
  const Bricks bricks({n, n, n});
  const int64_t bytes = int64_t(bricks.count());
  ASSERT_GT(bytes, int64_t(1) << 31);
  void* memory = mmap(nullptr, size_t(bytes), PROT_READ | PROT_WRITE,
                      MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  for (int64_t z = n - 9; z < n; z++)
    for (int64_t y = 0; y < n; y++)
      bricks.alongX(0, y, z, n, [&](size_t place, int64_t, int64_t points) {
        std::memset(static_cast<char*>(memory) + place, 100, size_t(points));
      });
  const int64_t m = (n - 1 + 7) / 8;
  const std::vector<int32_t> everywhere = test::everyCell(size_t(m * m * m));
  const float isovalue = 50;

  single::VolumeView field{};
  field.samples = memory;
  field.kind = SAMPLE_U8;
  field.stride = 1;
  field.wide = 1;
  field.brickRow = int(bricks.row()), field.brickLayer = int(bricks.layer());
  field.lastX = field.lastY = field.lastZ = field.cellsX = field.cellsY = field.cellsZ = int(n) - 1;
  field.originX = field.originY = field.originZ = -0.5f;
  field.inverseX = field.inverseY = field.inverseZ = float(n - 1);
  field.isoMask = everywhere.data();
  field.macroX = field.macroY = int(m);
  field.isovalues = 1;
  field.isovalue = &isovalue;
  single::OperatorView op{};
  single::SceneView scene{};
  scene.operators = 1;
  scene.operator_ = &op;
  scene.field = &field;

  const int count = 16;
  RayList rays(count);
  rays.resize(count);
  const RayView& r = rays.view();
  const double cell = 1.0 / double(n - 1), start = 0.5 - 20 * cell;
  for (int i = 0; i < count; i++) {
    r.info[i] = r.start[i] = 0;
    r.ox[i] = float(-0.49 + 0.06 * i), r.oy[i] = float(0.49 - 0.05 * i), r.oz[i] = float(start);
    r.dx[i] = r.dy[i] = 0, r.dz[i] = 1;
    r.tIn[i] = 0, r.tOut[i] = r.tEnd[i] = 10;
    r.tLast[i] = -1;
    r.A[i] = 0;
    r.tHit[i] = 1e30f;
    r.hitKind[i] = HIT_NONE;
  }
  int64_t counts[2] = {0, 0};
  RayView view = rays.view();
  ispc::hitIsosurfaces(&scene, &view, count, 0, false, counts);
  const double expected = 0.5 - 8.5 * cell - start;  // half way between the planes of 0 and of 100
  for (int i = 0; i < count; i++) {
    EXPECT_EQ(r.hitKind[i], HIT_ISOSURFACE);
    EXPECT_NEAR(r.tHit[i], expected, 1e-6);
  }
  munmap(memory, size_t(bytes));
}

}  // namespace
}  // namespace gxy::agreement
