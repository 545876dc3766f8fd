// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "core/comm/error.h"
#include "tests/reference/samples.h"

namespace gxy::reference {
namespace {

std::shared_ptr<Geometry> geometry(GeometryKind kind, GeometryBlock block) {
  auto made = std::make_shared<Geometry>();
  made->kind = kind;
  made->blocks[0] = std::move(block);
  return made;
}

/// A volume of ones in [-1, 1]^3 with the given slices, each of them a layer of ambient colour.
ReferenceScene sliced(std::vector<Plane> slices, double opacity) {
  ReferenceScene scene;
  Vis vis = plain(VisType::Volume, {0.2, 0.4, 0.8});
  vis.slices = std::move(slices);
  vis.opacity = opacity;
  scene.visualization.operators = {vis};
  scene.visualization.lighting = ambientOnly();
  scene.data = {makeVolume(cube(5), [](glm::dvec3) { return 1; })};
  return scene;
}

const Camera kFromFront = along({0.1, 0.2, 4}, {0, 0, -1});

TEST(Picture, TranslucentLayersComposeFrontToBack) {
  ReferenceScene scene = sliced({{{0, 0, 1}, -0.5}, {{0, 0, 1}, 0.5}}, 0.25);
  ReferencePicture picture = renderReference(scene, kFromFront);
  EXPECT_NEAR(picture.rgba[3], 1 - 0.75 * 0.75, 1e-14);
  EXPECT_NEAR(picture.rgba[2], 0.8 * (1 - 0.75 * 0.75), 1e-14);
  EXPECT_NEAR(picture.depth[0], 3.5, 1e-14);
  // With a uniform volume around them: T falls between the layers.
  Vis& vis = scene.visualization.operators[0];
  vis.volumeRendering = true;
  vis.opacitymap = {true, {{0, 0.6}}};
  vis.colormap.points = {{0, glm::dvec3(1)}};
  picture = renderReference(scene, kFromFront);
  EXPECT_NEAR(picture.rgba[3], 1 - 0.75 * 0.75 * std::exp(-0.6 * 2), 1e-12);
  EXPECT_NEAR(picture.rgba[0], picture.rgba[3], 1e-12);
}

TEST(Picture, VolumeBehindAnOpaqueSurfaceIsHidden) {
  ReferenceScene scene = sliced({{{0, 0, 1}, 0.5}}, 1);
  Vis& vis = scene.visualization.operators[0];
  vis.volumeRendering = true;
  vis.opacitymap = {true, {{0, 2}}};
  vis.colormap.points = {{0, {1, 0, 0}}, {1, {1, 0, 0}}};
  Vis slice = sliced({{{0, 0, 1}, 0.5}}, 1).visualization.operators[0];
  slice.colormap.points = {{0, {0, 1, 0}}};
  vis.slices.clear();
  scene.visualization.operators.push_back(slice);
  scene.data.push_back(scene.data[0]);
  const ReferencePicture picture = renderReference(scene, kFromFront);
  EXPECT_NEAR(picture.rgba[0], -std::expm1(-1.0), 1e-12);
  EXPECT_NEAR(picture.rgba[1], std::exp(-1.0), 1e-12);
  EXPECT_EQ(picture.rgba[3], 1);
}

TEST(Picture, BackgroundFillsWhatIsLeft) {
  ReferencePicture picture = renderReference(sliced({{{0, 0, 1}, 0}}, 0.25), kFromFront);
  applyBackground(picture, glm::dvec4{1, 1, 1, 0.5});
  EXPECT_NEAR(picture.rgba[0], 0.25 * 0.2 + 0.75 * 0.5, 1e-14);
  EXPECT_NEAR(picture.rgba[3], 0.25 + 0.75 * 0.5, 1e-14);
}

TEST(Picture, AGradientFillsWhatIsLeftAsTheFramebufferHasIt) {
  ReferencePicture picture = renderReference(sliced({{{0, 0, 1}, 0}}, 0.25), kFromFront);
  const ReferencePicture before = picture;
  RenderSettings settings;
  settings.background = {0, 0, 0, 1};
  settings.backgroundTop = glm::dvec4{1, 1, 1, 1};
  applyBackground(picture, settings);
  for (int y = 0; y < picture.height; y++)
    EXPECT_NEAR(picture.pixel(0, y)[0],
                before.pixel(0, y)[0] + (1 - before.pixel(0, y)[3]) * (y + 0.5) / picture.height, 1e-14);
}

TEST(Picture, TiesGoToTheLowestVis) {
  ReferenceScene scene = sliced({{{0, 0, 1}, 0}}, 1);
  scene.visualization.operators.push_back(scene.visualization.operators[0]);
  scene.visualization.operators[1].colormap.points = {{0, {1, 0, 0}}};
  scene.data.push_back(scene.data[0]);
  EXPECT_NEAR(renderReference(scene, kFromFront).rgba[0], 0.2, 1e-14);
}

TEST(Picture, ClipPlanesCutAllOfAVisAndKeepASliceInTheirPlane) {
  ReferenceScene scene = sliced({{{0, 0, 1}, 0.5}, {{0, 0, 2}, 0.4}}, 1);
  scene.visualization.operators[0].clipPlanes = {{{0, 0, -2}, -0.4}};  // keeps z <= 0.2
  EXPECT_NEAR(renderReference(scene, kFromFront).depth[0], 3.8, 1e-14);
  scene.visualization.operators[0].clipPlanes.push_back(
      {{1, 0, 0}, 0.3});  // keeps x >= 0.3: nothing on this ray
  EXPECT_EQ(renderReference(scene, kFromFront).depth[0], 1e30);
}

TEST(Picture, SliceShowsTheFieldOnlyInsideItsVolumeAndWhereThereAreData) {
  ReferenceScene scene = sliced({{{0, 0, 1}, 0}}, 1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  scene.data = {makeVolume(cube(5), [&](glm::dvec3 p) { return p.x < -0.9 ? nan : p.x; })};
  scene.visualization.operators[0].colormap.points = {{-1, glm::dvec3(0)}, {1, glm::dvec3(1)}};
  auto red = [&](double x) { return renderReference(scene, along({x, 0.3, 4}, {0, 0, -1})).rgba[0]; };
  EXPECT_NEAR(red(0.3), 0.65, 1e-12);
  EXPECT_EQ(red(1.01), 0);
  EXPECT_EQ(red(-0.7), 0);
  EXPECT_NEAR(red(1.0), 1, 1e-12) << "a volume is closed";
}

// Two cells with the values 0.2 and 0.8 from x = -1 to 1: constant in the outer halves, and nothing beyond.
TEST(Picture, SamplesOfCellsAreLinearBetweenCentresAndEndWithTheCells) {
  ReferenceScene scene = sliced({{{0, 0, 1}, 0}}, 1);
  Grid grid{{-1.5, -1.5, -1.5}, {1, 1, 1}, {4, 4, 4}, true};
  scene.data = {makeVolume(grid, [](glm::dvec3 p) { return p.x < 0 ? 0.2 : 0.8; })};
  scene.visualization.operators[0].colormap.points = {{0, glm::dvec3(0)}, {1, glm::dvec3(1)}};
  const auto red = [&](double x) { return renderReference(scene, along({x, 0.3, 4}, {0, 0, -1})).rgba[0]; };
  EXPECT_NEAR(red(-0.9), 0.2, 1e-6);
  EXPECT_NEAR(red(-0.5), 0.2, 1e-6);
  EXPECT_NEAR(red(0), 0.5, 1e-6);
  EXPECT_NEAR(red(0.25), 0.65, 1e-6);
  EXPECT_NEAR(red(0.9), 0.8, 1e-6);
  EXPECT_EQ(red(-1.01), 0);
  EXPECT_EQ(red(1.01), 0);
}

TEST(Picture, SphereDepthsMatchTheClosedForm) {
  ReferenceScene scene;
  Vis vis = plain(VisType::Particles, glm::dvec3(1));
  vis.radius0 = 0.2, vis.radius1 = 0.6, vis.value0 = 10, vis.value1 = 20;
  vis.colormap.points = {{10, glm::dvec3(0)}, {20, glm::dvec3(1)}};
  scene.visualization.operators = {vis};
  scene.visualization.lighting = ambientOnly();
  GeometryBlock block;
  block.points = {{-1, 0, 0}, {1, 0, 0}};
  block.values = {5, 15};  // clamped to radius 0.2; radius 0.4
  scene.data = {geometry(GeometryKind::Particles, block)};
  Camera camera;
  camera.viewpoint = {0, 0, 5};
  camera.aov = 40;
  camera.dimensions = {96, 48};
  const ReferencePicture picture = renderReference(scene, camera);
  const double pixel = 2 * std::tan(20 * std::numbers::pi / 180) / 48;
  int hits = 0;
  for (int y = 0; y < 48; y++) {
    for (int x = 0; x < 96; x++) {
      const glm::dvec3 d = glm::normalize(glm::dvec3((x - 47.5) * pixel, (y - 23.5) * pixel, -1));
      double expected = 1e30;
      for (auto [cx, r] : {std::pair{-1.0, 0.2}, {1.0, 0.4}}) {
        const glm::dvec3 o = camera.viewpoint - glm::dvec3(cx, 0, 0);
        const double b = glm::dot(o, d), disc = b * b - glm::dot(o, o) + r * r;
        if (disc > 0) expected = std::min(expected, -b - std::sqrt(disc));
      }
      const double found = picture.depth[size_t(y) * 96 + x];
      hits += found < 1e30;
      EXPECT_NEAR(found, expected, 1e-9);
      EXPECT_NEAR(picture.pixel(x, y)[0], found < 1e30 && x >= 48 ? 0.5 : 0, 1e-12);
    }
  }
  EXPECT_GT(hits, 50);
}

TEST(Picture, TranslucentPathLineIsOneBody) {
  // Three collinear segments: a ray along the axis meets the first cap and the last one, nothing between.
  GeometryBlock block;
  block.points = {{-1.5, 0, 0}, {-0.5, 0, 0}, {0.5, 0, 0}, {1.5, 0, 0}};
  block.segments = {{0, 1}, {1, 2}, {2, 3}};
  block.neighbours = {{0, 2}, {0, 3}, {1, 3}};
  block.values = {0, 1, 2, 3};
  block.ids = {0, 1, 2};
  Vis vis = plain(VisType::PathLines, glm::dvec3(1));
  vis.radius0 = 0.25;
  vis.opacity = 0.5;
  ReferenceScene scene;
  scene.visualization.operators = {vis};
  scene.visualization.lighting = ambientOnly();
  scene.data = {geometry(GeometryKind::PathLines, block)};
  const ReferencePicture lengthwise = renderReference(scene, along({-4, 0.1, 0}, {1, 0, 0}));
  EXPECT_NEAR(lengthwise.rgba[3], 0.75, 1e-14);
  EXPECT_NEAR(lengthwise.depth[0], 2.5 - std::sqrt(0.0625 - 0.01), 1e-12);
  // Across: depth of a cylinder, colour by the place along the line.
  scene.visualization.operators[0].opacity = 1;
  scene.visualization.operators[0].colormap.points = {{0, glm::dvec3(0)}, {3, glm::dvec3(3)}};
  const ReferencePicture across = renderReference(scene, along({0.2, 0.15, 4}, {0, 0, -1}));
  EXPECT_NEAR(across.depth[0], 3.8, 1e-12);
  EXPECT_NEAR(across.rgba[0], 1.7, 1e-12);
}

TEST(Picture, BentPathLineHasNoHoleAtItsJoints) {
  Uniform random(31);
  GeometryBlock block;
  for (uint32_t i = 0; i < 12; i++) {
    block.points.push_back(random.inCube(0.8));
    block.values.push_back(float(random()));
    if (i == 0) continue;
    block.segments.push_back({i - 1, i});
    block.neighbours.push_back({i == 1 ? 0 : i - 2, i == 11 ? 11 : i + 1});
    block.ids.push_back(i - 1);
  }
  Vis vis = plain(VisType::PathLines, glm::dvec3(1));
  vis.radius0 = 0.05, vis.radius1 = 0.3, vis.value0 = 0, vis.value1 = 1;
  ReferenceScene scene;
  scene.visualization.operators = {vis};
  scene.visualization.lighting = ambientOnly();
  scene.data = {geometry(GeometryKind::PathLines, block)};
  Camera camera = along({0, 0, 4}, {0, 0, -1});
  camera.height = 2;
  camera.dimensions = {64, 64};
  const ReferencePicture picture = renderReference(scene, camera);
  auto ball = [&](uint32_t i) { return Ball{block.points[i], 0.05 + 0.25 * block.values[i]}; };
  for (int y = 0; y < 64; y++) {
    for (int x = 0; x < 64; x++) {
      const Ray ray{{(x - 31.5) / 32, (y - 31.5) / 32, 4}, {0, 0, -1}};
      double expected = 1e30;
      for (const auto& [a, b] : block.segments) {
        const Crossing c = cross(RoundCone{ball(a), ball(b)}, ray);
        if (c.hit) expected = std::min(expected, c.in);
      }
      EXPECT_NEAR(picture.depth[size_t(y) * 64 + x], expected, 1e-12);
    }
  }
}

TEST(Picture, PathLineThinsOutToThePointWhereItsRadiusIsZero) {
  GeometryBlock block;
  block.points = {{-1, 0, 0}, {1, 0, 0}, {1.5, 0, 0}};
  block.segments = {{0, 1}, {1, 2}};
  block.neighbours = {{0, 2}, {0, 2}};
  block.values = {1, 0, 0};
  Vis vis = plain(VisType::PathLines, glm::dvec3(1));
  vis.radius0 = 0, vis.radius1 = 0.5, vis.value0 = 0, vis.value1 = 1;
  ReferenceScene scene;
  scene.visualization.operators = {vis};
  scene.data = {geometry(GeometryKind::PathLines, block)};
  // The tangent cone to the ball of radius 1/2 from its tip at distance 2: sine 1/4.
  const double radius = 0.1 * 0.25 / std::sqrt(1 - 0.0625);
  EXPECT_NEAR(renderReference(scene, along({0.9, 0, 4}, {0, 0, -1})).depth[0], 4 - radius, 1e-12);
  EXPECT_EQ(renderReference(scene, along({1.2, 0, 4}, {0, 0, -1})).depth[0], 1e30);
}

/// Volume, isosurface, slice, spheres and a triangle, with shadows and occlusion, all of it scaled and
/// shifted.
ReferencePicture mixedScene(double scale, glm::dvec3 shift) {
  ReferenceScene scene;
  Vis volume = plain(VisType::Volume, {0.8, 0.5, 0.3});
  volume.volumeRendering = true;
  volume.opacitymap.points = {{0.2, 0}, {1, 0.3}};
  volume.isovalues = {0.7};
  volume.opacity = 0.6;
  volume.slices = {{{1, 1, 0}, shift.x + shift.y}};
  Vis spheres = plain(VisType::Particles, {0.1, 0.9, 0.3});
  spheres.radius0 = 0.4 * scale;
  const Vis mesh = plain(VisType::Triangles, {0.3, 0.1, 0.7});
  scene.visualization.operators = {volume, spheres, mesh};
  GeometryBlock centres, triangle;
  centres.points = {shift + scale * glm::dvec3(1, 0, 0), shift + scale * glm::dvec3(-0.5, 0.5, 1)};
  triangle.points = {shift + scale * glm::dvec3(-1, -1, -1), shift + scale * glm::dvec3(2, -1, -1),
                     shift + scale * glm::dvec3(-1, 2, 1)};
  triangle.triangles = {{0, 1, 2}};
  const Grid grid{shift - scale, glm::dvec3(scale / 8), {17, 17, 17}};
  scene.data = {makeVolume(grid, [&](glm::dvec3 p) { return marschnerLobb((p - shift) / scale); }),
                geometry(GeometryKind::Particles, centres), geometry(GeometryKind::Triangles, triangle)};
  Lighting& lighting = scene.visualization.lighting;
  lighting.shadows = true;
  lighting.aoCount = 4;
  lighting.aoRadius = 0.5 * scale;
  lighting.Ks = 0.3;
  lighting.sources = {{LightType::Point, shift + scale * glm::dvec3(3, 4, 5)},
                      {LightType::Directional, {1, -2, -1}}};
  Camera camera;
  camera.viewpoint = shift + scale * glm::dvec3(1, 2, 4);
  camera.viewdirection = {-1, -2, -4};
  camera.dimensions = {24, 24};
  camera.aov = 45;
  return renderReference(scene, camera);
}

TEST(Picture, IsTheSameToTheBitAtAnyScaleByPowersOfTwo) {
  const ReferencePicture unit = mixedScene(1, glm::dvec3(0));
  EXPECT_EQ(unit.rgba, mixedScene(0x1p100, glm::dvec3(0)).rgba);
  EXPECT_EQ(unit.rgba, mixedScene(0x1p-100, glm::dvec3(0)).rgba);
}

TEST(Picture, ShiftByAMillionExtentsMovesPixelsByRoundingOnly) {
  const ReferencePicture unit = mixedScene(1, glm::dvec3(0)),
                         far = mixedScene(1, glm::dvec3(0x1p21, -0x1p20, 0x1p19));
  int flips = 0;
  for (size_t i = 0; i < unit.rgba.size(); i++) flips += std::abs(unit.rgba[i] - far.rgba[i]) > 1e-6;
  EXPECT_LE(flips, 4);
}

TEST(Picture, TrianglesInterpolateValuesAndNormals) {
  GeometryBlock block;
  block.points = {{-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}};
  block.values = {0, 1, 0};
  block.triangles = {{0, 1, 2}};
  block.normals = {{0, 0, 1}, {0.6f, 0, 0.8f}, {0, 0, 1}};
  Vis vis = plain(VisType::Triangles, glm::dvec3(1));
  vis.colormap.points = {{0, glm::dvec3(0)}, {1, glm::dvec3(1)}};
  ReferenceScene scene;
  scene.visualization.operators = {vis};
  scene.visualization.lighting = ambientOnly();
  scene.data = {geometry(GeometryKind::Triangles, block)};
  EXPECT_NEAR(renderReference(scene, along({-0.2, -0.5, 4}, {0, 0, -1})).rgba[0], 0.4, 1e-12);
  Lighting& lighting = scene.visualization.lighting;
  lighting.Ka = 0;
  lighting.Kd = 1;
  lighting.sources = {{LightType::Directional, {0, 0, -1}}};
  const glm::dvec3 normal = glm::normalize(0.6 * glm::dvec3(0, 0, 1) + 0.4 * glm::dvec3(0.6, 0, 0.8));
  EXPECT_NEAR(renderReference(scene, along({-0.2, -0.5, 4}, {0, 0, -1})).rgba[0], 0.4 * normal.z, 1e-7);
  // From below, one-sided: the light from above still shines on the side that the normals say.
  scene.visualization.operators[0].twoSided = false;
  EXPECT_NEAR(renderReference(scene, along({-0.2, -0.5, -4}, {0, 0, 1})).rgba[0], 0.4 * normal.z, 1e-7);
}

TEST(Picture, ColoursOfPointsAreMixedAsValuesAre) {
  GeometryBlock triangle, balls, tube;
  triangle.points = {{-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}};
  triangle.triangles = {{0, 1, 2}};
  balls.points = {{-1, 0, 0}, {1, 0, 0}};
  tube.points = {{-1, 0, 0}, {1, 0, 0}};
  tube.segments = tube.neighbours = {{0, 1}};
  triangle.colors = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  balls.colors = tube.colors = {{1, 0, 0.25f}, {0, 1, 0.75f}};
  ReferenceScene scene;
  scene.visualization.lighting = ambientOnly();
  const auto expectColour = [&](VisType type, GeometryKind kind, const GeometryBlock& block, glm::dvec3 from,
                                glm::dvec3 expected) {
    Vis vis = plain(type, {0.3, 0.3, 0.3});  // this map has no effect
    vis.radius0 = 0.25;
    scene.visualization.operators = {vis};
    scene.data = {geometry(kind, block)};
    const ReferencePicture picture = renderReference(scene, along(from, {0, 0, -1}));
    for (int c = 0; c < 3; c++) EXPECT_NEAR(picture.rgba[c], expected[c], 1e-12) << int(type) << " " << c;
  };
  expectColour(VisType::Triangles, GeometryKind::Triangles, triangle, {-0.2, -0.5, 4}, {0.35, 0.4, 0.25});
  expectColour(VisType::Particles, GeometryKind::Particles, balls, {-1.1, 0, 4}, {1, 0, 0.25});
  expectColour(VisType::Particles, GeometryKind::Particles, balls, {1.1, 0.1, 4}, {0, 1, 0.75});
  expectColour(VisType::PathLines, GeometryKind::PathLines, tube, {0.2, 0.1, 4}, {0.4, 0.6, 0.55});
  expectColour(VisType::PathLines, GeometryKind::PathLines, tube, {1.1, 0.1, 4}, {0, 1, 0.75});
}

TEST(Picture, IsosurfaceShowsTheColourOfItsIsovalueNearestFirst) {
  ReferenceScene scene = sliced({}, 1);
  scene.data = {makeVolume(cube(9), [](glm::dvec3 p) { return p.z; })};
  Vis& vis = scene.visualization.operators[0];
  vis.isovalues = {-0.3, 0.6};
  vis.colormap.points = {{-1, glm::dvec3(0)}, {1, glm::dvec3(1)}};
  vis.opacity = 0.5;
  const ReferencePicture picture = renderReference(scene, kFromFront);
  EXPECT_NEAR(picture.depth[0], 3.4, 1e-7);
  EXPECT_NEAR(picture.rgba[0], 0.5 * 0.8 + 0.25 * 0.35, 1e-7);
}

TEST(Picture, CameraInsideTheVolumeSeesWhatIsAhead) {
  ReferenceScene scene = sliced({}, 1);
  Vis& vis = scene.visualization.operators[0];
  vis.volumeRendering = true;
  vis.opacitymap = {true, {{0, 1.5}}};
  const ReferencePicture picture = renderReference(scene, along({0.1, 0.2, 0.3}, {0, 0, -1}));
  EXPECT_NEAR(picture.rgba[3], -std::expm1(-1.5 * 1.3), 1e-12);
}

TEST(Picture, OrthographicWindowSpansTheSmallerDimension) {
  ReferenceScene scene = sliced({{{0, 0, 1}, 0}}, 1);  // covers [-1, 1]^2
  Camera camera = along({0, 0, 4}, {0, 0, -1});
  camera.height = 4;
  camera.dimensions = {80, 40};
  const ReferencePicture picture = renderReference(scene, camera);
  int covered = 0;
  for (double d : picture.depth) covered += d < 1e30;
  EXPECT_EQ(covered, 20 * 20);
  EXPECT_NEAR(picture.depth[20 * 80 + 40], 4, 1e-14);
}

TEST(Picture, RaysPerPixelAverageTheirPositions) {
  ReferenceScene scene = sliced({{{0, 0, 1}, 0}}, 1);
  scene.data = {makeVolume(cube(5), [](glm::dvec3 p) { return p.x; })};
  scene.visualization.operators[0].colormap.points = {{-1, glm::dvec3(0)}, {1, glm::dvec3(1)}};
  scene.settings.raysPerPixel = 3;
  Camera camera = along({0, 0, 4}, {0, 0, -1});
  camera.height = 0.5;
  double mean = 0;
  for (int k = 0; k < 3; k++) mean += (0.5 + 0.25 * (subpixel(k).x - 0.5)) / 3;
  EXPECT_NEAR(renderReference(scene, camera).rgba[0], mean, 1e-12);
  EXPECT_NEAR(subpixel(1).x, 0.2548776662466927, 1e-15);
  EXPECT_EQ(subpixel(0), glm::dvec2(0.5));
}

TEST(Picture, RectangleAndThreadsDoNotChangePixels) {
  ReferenceScene scene = sliced({}, 1);
  scene.data = {makeVolume(cube(17), marschnerLobb)};
  scene.visualization.operators[0].isovalues = {0.5};
  scene.visualization.lighting = Lighting{};
  Camera camera;
  camera.dimensions = {24, 20};
  ReferenceOptions options;
  options.threads = 1;
  std::vector<double> fractions;
  options.progress = [&](double f) { fractions.push_back(f); };
  const ReferencePicture whole = renderReference(scene, camera, options);
  EXPECT_EQ(fractions.size(), 20u);
  EXPECT_EQ(fractions.back(), 1);
  const ReferencePicture again = renderReference(scene, camera);
  EXPECT_EQ(whole.rgba, again.rgba);
  ReferenceOptions part;
  part.first = {5, 6};
  part.size = {7, 3};
  const ReferencePicture crop = renderReference(scene, camera, part);
  for (int y = 0; y < 3; y++) {
    for (int x = 0; x < 7; x++) {
      for (int c = 0; c < 4; c++) EXPECT_EQ(crop.pixel(x, y)[c], whole.pixel(x + 5, y + 6)[c]);
    }
  }
}

TEST(Picture, PerturbationChangesPixelsOnSilhouettesOnly) {
  ReferenceScene scene;
  scene.visualization.operators = {plain(VisType::Particles, glm::dvec3(1))};
  scene.visualization.operators[0].radius0 = 1;
  scene.visualization.lighting = ambientOnly();
  GeometryBlock block;
  block.points = {{0, 0, 0}};
  scene.data = {geometry(GeometryKind::Particles, block)};
  Camera camera = along({0, 0, 5}, {0, 0, -1});
  camera.height = 4;
  camera.dimensions = {64, 64};
  const ReferencePicture straight = renderReference(scene, camera);
  ReferenceOptions options;
  options.seed = 3;
  options.perturbation =
      0x1p24 * 0.02;  // far larger than rounding, so that some pixels must flip: 0.04 world units
  const ReferencePicture moved = renderReference(scene, camera, options);
  int flips = 0;
  for (int y = 0; y < 64; y++) {
    for (int x = 0; x < 64; x++) {
      if (straight.pixel(x, y)[3] == moved.pixel(x, y)[3]) continue;
      flips++;
      const double r = std::hypot((x - 31.5) / 16, (y - 31.5) / 16);
      EXPECT_NEAR(r, 1, 0.04 * std::sqrt(2.0) + 0.02 * 5 * std::sqrt(2.0));
    }
  }
  EXPECT_GT(flips, 10);
  options.perturbation = 4;
  const ReferencePicture nudged = renderReference(scene, camera, options);
  for (size_t i = 0; i < nudged.depth.size(); i++) {
    if (straight.depth[i] < 4.5 && nudged.depth[i] < 4.5) {
      EXPECT_NEAR(nudged.depth[i], straight.depth[i], 1e-5);
    }
  }
  EXPECT_NE(straight.depth, nudged.depth);
}

TEST(Picture, SceneThatDoesNotFitItsDataIsAnError) {
  ReferenceScene scene = sliced({}, 1);
  scene.visualization.operators[0].type = VisType::Particles;
  EXPECT_THROW(renderReference(scene, kFromFront), Error);
  scene.data.clear();
  EXPECT_THROW(renderReference(scene, kFromFront), Error);
  Camera camera = kFromFront;
  camera.viewup = camera.viewdirection;
  EXPECT_THROW(renderReference(sliced({}, 1), camera), Error);
}

}  // namespace
}  // namespace gxy::reference
