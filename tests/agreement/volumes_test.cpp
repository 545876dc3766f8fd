// SPDX-License-Identifier: Apache-2.0
// Volume rendering and surfaces in volumes: backend against reference.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "core/comm/error.h"
#include "core/kernels/single_views.h"
#include "tests/agreement/backend.h"
#include "tests/agreement/compare.h"

namespace gxy::agreement {
namespace {

const glm::dvec3 kEye(2.1, 1.4, 3.3);

TestScene volumeScene(const std::string& name, Vis vis, int size = 64) {
  TestScene scene = sceneFrom(name, kEye, size, size);
  scene.add(std::move(vis), makeVolume(cube(32), waves));
  return scene;
}

TEST(VolumeAgreement, SmoothMap) {
  expectAgreement(embree(), volumeScene("smooth", rendered({{-1, 0}, {1, 0.3}}, -1, 1)));
}

TEST(VolumeAgreement, SpikyMap) {
  expectAgreement(
      embree(),
      volumeScene(
          "spiky",
          rendered({{-1, 0}, {-0.32, 0}, {-0.3, 0.8}, {-0.28, 0}, {0.2, 0}, {0.21, 0.5}, {0.22, 0}}, -1, 1)));
}

TEST(VolumeAgreement, SteppedMap) {
  expectAgreement(
      embree(),
      volumeScene(
          "stepped",
          rendered({{-0.2, 0}, {-0.2, 0.3}, {0.1, 0.3}, {0.1, 0.02}, {0.4, 0.02}, {0.4, 0.6}}, -1, 1)));
}

TEST(VolumeAgreement, NearlyOpaqueMap) {
  expectAgreement(embree(), volumeScene("nearly_opaque", rendered({{-1, 0.9}, {1, 0.999}}, -1, 1)));
}

TEST(VolumeAgreement, NearlyTransparentMap) {
  expectAgreement(embree(), volumeScene("nearly_transparent", rendered({{-1, 0.001}, {1, 0.01}}, -1, 1)));
}

TEST(VolumeAgreement, OpaqueSteps) {
  expectAgreement(embree(), volumeScene("opaque_steps", rendered({{0.3, 0}, {0.3, 1}, {0.6, 1}}, -1, 1)));
}

TEST(VolumeAgreement, ExtinctionMap) {
  expectAgreement(embree(), volumeScene("extinction", rendered({{-1, 0}, {0, 0.5}, {1, 8}}, -1, 1, true)));
}

// A backend may hold maps of so few intervals in registers, and search longer ones in other ways.
TEST(VolumeAgreement, MapsOfAnyNumberOfIntervals) {
  for (int intervals : {3, 4, 5, 8, 9, 16, 17}) {
    const int points = intervals - 1;  // the first and last interval are outside
    std::vector<OpacityPoint> map;
    for (int i = 0; i < points; i++)
      map.push_back({-0.9 + 1.8 * i / (points - 1), 0.2 + (i % 2) * 3.0 + (i % 3)});
    Vis vis = rendered(map, -0.9, 0.9, true);
    vis.colormap = {{{-0.9, {0.2, 0.3, 0.9}}, {0.9, {0.9, 0.2, 0.1}}}};
    TestScene scene = volumeScene("intervals_" + std::to_string(intervals), vis, 32);
    ASSERT_EQ(scene.compile()->operators[0].map.intervals(), intervals);
    expectAgreement(embree(), scene);
  }
}

// By Beer and Lambert's law.
TEST(VolumeAgreement, UniformSlab) {
  for (double sigma : {1e-3, 0.1, 3.0, 20.0}) {
    TestScene scene = sceneFrom("slab", {0, 0, 4}, 32, 32);
    scene.camera.viewdirection = {0, 0, -1};
    scene.camera.aov = 0;
    scene.camera.height = 1;
    scene.settings.background = glm::dvec4(0);
    Grid grid;
    grid.points = {5, 9, 17};
    grid.origin = {-1, -1, -1};
    grid.spacing = {0.5, 0.25, 0.125};
    scene.add(rendered({{0, sigma}, {1, sigma}}, 0, 1, true),
              makeVolume(grid, [](glm::dvec3) { return 0.5; }));
    const Picture picture = drawnByBoth(scene);
    const double expected = -std::expm1(-2 * sigma), bound = std::max(1e-6, 1e-4 * expected);
    for (size_t i = 3; i < picture.rgba.size(); i += 4)
      ASSERT_NEAR(picture.rgba[i], expected, bound) << sigma;
  }
}

TEST(VolumeAgreement, ReferenceLengthAndDataRange) {
  Vis vis = rendered({{0, 0}, {1, 0.5}}, 0, 1);
  vis.referenceLength = 0.3;
  vis.dataRange = {{-0.7, 0.9}};
  expectAgreement(embree(), volumeScene("reference_length", vis));
}

TEST(VolumeAgreement, NarrowTypes) {
  for (ScalarType type : {ScalarType::UInt8, ScalarType::Int8, ScalarType::UInt16, ScalarType::Int16}) {
    TestScene scene = sceneFrom(std::string("narrow_") + nameOf(type), kEye, 40, 40);
    const bool isSigned = type == ScalarType::Int8 || type == ScalarType::Int16;
    Vis vis = rendered({{0, 0}, {200, 0.4}}, 0, 200);
    if (isSigned) vis = rendered({{-100, 0}, {100, 0.4}}, -100, 100);
    scene.add(vis, makeVolume(
                       cube(24), [=](glm::dvec3 p) { return 100 * waves(p) + (isSigned ? 0 : 100); }, type));
    expectAgreement(embree(), scene);
  }
}

TEST(VolumeAgreement, SeveralVolumesOverlap) {
  TestScene scene = volumeScene("several", rendered({{-1, 0}, {1, 0.2}}, -1, 1));
  scene.add(rendered({{0.2, 0}, {1, 0.3}}, 0, 1), makeVolume(cube(41, 0.8), marschnerLobb));
  Grid grid = cube(20, 0.7);
  grid.origin += glm::dvec3(0.5, 0.3, 0.2);
  scene.add(rendered({{0, 0}, {1.5, 2}}, 0, 1, true),
            makeVolume(grid, [](glm::dvec3 p) { return glm::length(p); }));
  expectAgreement(embree(), scene);
}

/// Two smooth fields on n^3 points, through maps without a kink.
TestScene severalSmooth(int n, const FieldFunction& first, const FieldFunction& second) {
  TestScene scene = sceneFrom("order of several", kEye, 32, 32);
  scene.add(rendered({{-2, 0}, {2, 1.5}}, -2, 2, true), makeVolume(cube(n), first));
  scene.add(rendered({{-2, 1}, {2, 0}}, -2, 2, true), makeVolume(cube(n), second));
  scene.settings.tolerance = 1e-5;
  scene.settings.background = glm::dvec4(0);
  return scene;
}

FieldFunction wave(double phase) {
  return [phase](glm::dvec3 p) { return std::sin(1.5 * p.x + p.y + phase) * std::cos(p.z - phase); };
}

/// The slope over halvings, of pictures; in float, whose rounding is far below.
void expectSecondOrder(const std::vector<double>& errors) {
  const double order = std::log2(errors.front() / errors.back()) / double(errors.size() - 1);
  testing::Test::RecordProperty("order", std::to_string(order));
  EXPECT_GE(order, 1.9) << errors.front() << " to " << errors.back();
}

template <class Mine, class Theirs>
double rms(const Mine& a, const Theirs& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); i++) sum += std::pow(double(a[i]) - double(b[i]), 2);
  return std::sqrt(sum / double(a.size()));
}

/// Steps in both maps, wherever values are: they go cell by cell. Too small to be seen.
void addSmallSteps(TestScene& scene) {
  for (Vis& vis : scene.visualization.operators) {
    const auto ends = vis.opacitymap.points;
    const double slope = (ends[1].opacity - ends[0].opacity) / (ends[1].value - ends[0].value);
    vis.opacitymap.points = {ends[0]};
    for (double v = -1.9; v < 2; v += 0.2)
      for (const double side : {0.0, 1e-6})
        vis.opacitymap.points.push_back({v, ends[0].opacity + slope * (v - ends[0].value) + side});
    vis.opacitymap.points.push_back(ends[1]);
  }
}

TEST(VolumeAgreement, SeveralVolumesAreOfSecondOrderInTheSpacing) {
  for (const bool byCells : {false, true}) {
    const auto picture = [&](int n) {
      TestScene scene = severalSmooth(n, wave(0), wave(1));
      if (byCells)
        addSmallSteps(scene);
      else
        scene.settings.step = 0.25;
      return draw(embree(), scene).rgba;
    };
    const LargeVector<float> fine = picture(byCells ? 81 : 161);
    std::vector<double> errors;
    for (int n : {6, 11, 21}) errors.push_back(rms(picture(n), fine));
    expectSecondOrder(errors);
  }
}

// A pixel between two others is their mean, up to the square of their distance (Etiene et al. 2014, section 5.3); the rays
// cross the same two faces of the box.
void pixelsAreOfSecondOrder(TestScene scene) {
  scene.camera.viewpoint = {0, 0, 4};
  scene.camera.viewdirection = {0.02, 0.01, -1};
  scene.camera.aov = 0;
  scene.camera.height = 1.2;
  std::vector<double> errors;
  for (int size : {16, 32, 64}) {
    scene.camera.dimensions = {size, size};
    const LargeVector<float> all = draw(embree(), scene).rgba;
    std::vector<float> means, pixels;
    for (size_t i = 4; i + 4 < all.size(); i++) {
      if (i / 4 % size_t(size) == 0 || i / 4 % size_t(size) == size_t(size) - 1) continue;
      means.push_back(0.5f * (all[i - 4] + all[i + 4]));
      pixels.push_back(all[i]);
    }
    errors.push_back(rms(means, pixels));
  }
  expectSecondOrder(errors);
}

TEST(VolumeAgreement, SeveralVolumesAreOfSecondOrderInThePixels) {
  // on one side of the colour map's kink at 0
  const auto product = [](glm::dvec3 p) { return 1 + 0.5 * (p.x * p.y + 0.5 * p.z * p.x - 0.3 * p.y); };
  const auto other = [](glm::dvec3 p) { return 1 + 0.5 * p.x * (p.y * p.z - 1); };
  TestScene scene = severalSmooth(9, product, other);
  scene.settings.step = 0.125;
  pixelsAreOfSecondOrder(scene);
  addSmallSteps(scene);
  scene.settings.step = 0;
  pixelsAreOfSecondOrder(scene);
}

TEST(VolumeAgreement, SeveralVolumesAreOfSecondOrderInTheStep) {
  TestScene scene = severalSmooth(20, wave(0), wave(1));
  const reference::ReferencePicture truth = reference::renderReference(scene.forReference(), scene.camera);
  std::vector<double> errors;
  for (scene.settings.step = 1; scene.settings.step >= 0.125; scene.settings.step /= 2) {
    errors.push_back(rms(draw(embree(), scene).rgba, truth.rgba));
  }
  expectSecondOrder(errors);
}

TEST(VolumeAgreement, SeveralSteppedVolumesWithClipPlanes) {
  TestScene scene =
      volumeScene("several_clipped", rendered({{-0.2, 0}, {-0.2, 0.3}, {0.3, 0.3}, {0.3, 0}}, -1, 1));
  scene.visualization.operators[0].clipPlanes = {{{1, 0.3, 0}, 0.1}};
  Vis& b = scene.add(rendered({{0.5, 0}, {0.5, 0.5}}, 0, 1), makeVolume(cube(41, 0.8), marschnerLobb));
  b.clipPlanes = {{{0, -1, 0.2}, -0.3}, {{0, 0, 1}, -0.4}};
  expectAgreement(embree(), scene);
}

// Spikes, an opacity that reaches 1, where extinction has a pole, and gaps without data, each inside the others.
TEST(VolumeAgreement, SeveralSharpVolumesWithGaps) {
  TestScene scene = volumeScene("several_sharp", rendered({{-0.1, 0}, {0, 0.6}, {0.1, 0}}, -1, 1), 32);
  scene.add(rendered({{0.3, 0}, {0.8, 1}}, 0, 1), makeVolume(cube(41, 0.8), marschnerLobb));
  Grid grid = cube(20, 0.7);
  grid.origin += glm::dvec3(0.5, 0.3, 0.2);
  scene.add(rendered({{0, 0.1}, {1.5, 0.3}}, 0, 1), makeVolume(grid, [](glm::dvec3 p) {
              const bool gap = glm::fract(4 * p.x + 0.1) < 0.2 && p.y > 0.1;
              return gap ? std::numeric_limits<double>::quiet_NaN() : glm::length(p);
            }));
  expectAgreement(embree(), scene);
}

TEST(VolumeAgreement, ClipPlanes) {
  Vis vis = rendered({{-1, 0}, {1, 0.6}}, -1, 1);
  vis.clipPlanes = {{{1, 0.2, -0.3}, -0.2}, {{0, -1, 0}, -0.5}};
  expectAgreement(embree(), volumeScene("clipped", vis));
}

TEST(VolumeAgreement, SamplesOfCellsEndWithTheCells) {
  Vis vis = rendered({{-1, 0}, {1, 0.6}}, -1, 1);
  vis.isovalues = {0.3};
  vis.slices = {{{0, 0, 1}, 0.1}};
  vis.opacity = 0.5;
  TestScene scene = sceneFrom("cells", kEye, 64, 64);
  Grid grid = cube(12, 0.7);
  grid.rim = true;
  scene.add(vis, makeVolume(grid, [](glm::dvec3 p) { return std::sin(3 * p.x + 2 * p.y - p.z); }));
  expectAgreement(embree(), scene);
}

TEST(VolumeAgreement, Isosurfaces) {
  Vis vis = surfaces(VisType::Volume, -1, 1);
  vis.isovalues = {0.5, -0.2, 0.1};
  expectAgreement(embree(), volumeScene("isosurfaces", vis, 96));
}

TEST(VolumeAgreement, IsosurfacesOfMarschnerLobb) {
  TestScene scene = sceneFrom("iso_marschner_lobb", {0.5, 1, 4}, 96, 96);
  Vis vis = surfaces(VisType::Volume);
  vis.isovalues = {0.5};
  scene.add(vis, makeVolume(cube(41), marschnerLobb));
  expectAgreement(embree(), scene);
}

TEST(VolumeAgreement, TranslucentIsosurfacesOfSeveralVolumes) {
  Vis vis = surfaces(VisType::Volume, -1, 1);
  vis.isovalues = {0.5, -0.4, 0.1};
  vis.opacity = 0.4;
  TestScene scene = volumeScene("iso_translucent", vis);
  Vis other = surfaces(VisType::Volume);
  other.isovalues = {0.6};
  other.opacity = 0.7;
  scene.add(other, makeVolume(cube(30, 0.8), [](glm::dvec3 p) { return glm::length(p); }));
  expectAgreement(embree(), scene);
}

TEST(VolumeAgreement, OneSidedIsosurfaces) {
  Vis vis = surfaces(VisType::Volume, -1, 1);
  vis.isovalues = {0.3, -0.3};
  vis.opacity = 0.5;
  vis.twoSided = false;
  expectAgreement(embree(), volumeScene("iso_one_sided", vis));
}

TEST(VolumeAgreement, ClippedIsosurfacesAndSlices) {
  Vis vis = surfaces(VisType::Volume, -1, 1);
  vis.isovalues = {0.3, -0.3};
  vis.slices = {{{0, 0, 2}, 0.2}, {{1, 1, 1}, 0}};
  vis.clipPlanes = {{{1, 0.2, -0.3}, -0.2}};
  expectAgreement(embree(), volumeScene("iso_slices_clipped", vis, 96));
}

TEST(VolumeAgreement, SlicesOneSidedAndTranslucent) {
  Vis vis = surfaces(VisType::Volume, -1, 1);
  vis.slices = {{{0, 0, 1}, 0.5}, {{0, -1, 0}, 0.2}, {{1, 0.1, 0}, -0.1}};
  vis.opacity = 0.6;
  vis.twoSided = false;
  expectAgreement(embree(), volumeScene("slices", vis));
}

TEST(VolumeAgreement, VolumeWithItsOwnSurfaces) {
  Vis vis = rendered({{-1, 0}, {1, 0.1}}, -1, 1);
  vis.isovalues = {0.4};
  vis.slices = {{{0, 0, 1}, 0.1}};
  vis.opacity = 0.5;
  expectAgreement(embree(), volumeScene("volume_and_surfaces", vis));
}

TEST(VolumeAgreement, CameraInsideOrthographicAndSeveralRaysPerPixel) {
  TestScene scene = volumeScene("inside", rendered({{-1, 0}, {1, 0.15}}, -1, 1));
  scene.camera.viewpoint = {0.1, 0.2, 0.3};
  scene.camera.viewdirection = {1, 0.5, -0.3};
  scene.camera.aov = 100;
  scene.visualization.operators[0].isovalues = {0.5};
  expectAgreement(embree(), scene);
  scene.name = "inside_rays_per_pixel";
  scene.settings.raysPerPixel = 3;
  scene.camera.dimensions = {40, 30};
  expectAgreement(embree(), scene);
  scene = volumeScene("orthographic", rendered({{-1, 0}, {1, 0.15}}, -1, 1));
  scene.visualization.operators[0].isovalues = {0.5};
  scene.camera.aov = 0;
  scene.camera.height = 2.5;
  scene.settings.background = {0.2, 0.4, 0.6, 0.5};
  expectAgreement(embree(), scene);
}

TEST(CompiledScene, ListsOperatorsByWhatTheyShow) {
  TestScene scene = volumeScene("lists", rendered({{-1, 0}, {1, 0.3}}, -1, 1));
  Vis both = surfaces(VisType::Volume, -1, 1);
  both.isovalues = {0.1};
  both.slices = {{{0, 0, 1}, 0.2}};
  scene.add(both, wavy());
  scene.add(surfaces(VisType::Particles), makeGeometry(GeometryKind::Particles, sphereMesh(3, false, true)));
  scene.add(rendered({{2, 0}, {3, 1}}, -1, 1), wavy());  // transparent over all data
  Vis all = rendered({{-1, 0.1}, {1, 0.2}}, -1, 1);
  all.isovalues = {0.2};
  scene.add(all, wavy());
  Vis steps = surfaces(VisType::Volume, -1, 1);
  steps.every = 0.1;
  scene.add(steps, wavy());
  const auto compiled = scene.compile();
  EXPECT_EQ(compiled->sliced, (std::vector<int32_t>{1, 5}));
  EXPECT_EQ(compiled->isosurfaces, (std::vector<int32_t>{1, 4}));
  EXPECT_EQ(compiled->rendered, (std::vector<int32_t>{0, 4}));
}

TEST(CompiledScene, RendersSoManyVolumesAtOnceAndNoMore) {
  TestScene scene = volumeScene("many", rendered({{-1, 0}, {1, 0.3}}, -1, 1));
  while (scene.data.size() < MANY_VOLUMES) scene.add(rendered({{-1, 0}, {1, 0.3}}, -1, 1), wavy());
  scene.add(rendered({{2, 0}, {3, 1}}, -1, 1), wavy());  // shows nothing, so it does not count
  EXPECT_EQ(scene.compile()->rendered.size(), size_t(MANY_VOLUMES));
  scene.add(rendered({{-1, 0}, {1, 0.3}}, -1, 1), wavy());
  try {
    scene.compile();
    FAIL() << "compiled";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "a visualization renders 9 volumes at once, expected at most 8");
  }
}

}  // namespace
}  // namespace gxy::agreement
