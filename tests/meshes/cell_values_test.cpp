// SPDX-License-Identifier: Apache-2.0
// Unstructured volumes whose data are those of cells, flat and smooth: backends against reference.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "tests/agreement/draw.h"
#include "tests/meshes/cells.h"
#include "tests/meshes/mesh_scenes.h"

namespace gxy::test {
namespace {

using agreement::embree;
using agreement::rendered;
using agreement::TestScene;

constexpr std::array kKinds{Cells::Tetrahedra, Cells::Hexahedra, Cells::Wedges, Cells::Pyramids, Cells::All};
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

MeshPiece cellsOf(Cells cells, const Field& field, uint32_t n = 6, double far = 0.15) {
  return withCellValues(cubeOfCells(cells, n, far, waves), field);
}
/// Faces of tetrahedra only are turned: a ray that passes a bent face twice, in and out of its bulge, does not see the value there.
TestScene cellScene(Cells cells, const Field& field, Vis vis, int size = 20, uint32_t n = 6) {
  return meshScene("cell_values_" + nameOf(cells), std::move(vis),
                   cellsOf(cells, field, n, cells == Cells::Tetrahedra ? 0.15 : 0), size);
}
Vis smooth(Vis vis) {
  vis.cells = CellsShown::Smooth;
  return vis;
}
double holed(glm::dvec3 p) { return glm::length(p - glm::dvec3(0.3, 0.2, 0.4)) < 0.5 ? kNan : waves(p); }

TEST(CellValues, FlatVolumesAgreeWithTheReference) {
  for (const Cells cells : kKinds) {
    agreement::CompareOptions options;
    options.vulkan = cells == Cells::Tetrahedra || cells == Cells::All;
    expectAgreement(embree(), cellScene(cells, waves, haze()), options);
  }
}

TEST(CellValues, SmoothVolumesAgreeWithTheReference) {
  for (const Cells cells : kKinds) {
    TestScene scene =
        meshScene("cell_values_smooth_" + nameOf(cells), smooth(haze()), cellsOf(cells, waves), 20);
    agreement::CompareOptions options;
    options.vulkan = cells == Cells::All;
    expectAgreement(embree(), scene, options);
  }
}

TEST(CellValues, UnderMapsOfStepsSpikesAndManyPoints) {
  const Vis stepped =
      rendered({{-0.2, 0}, {-0.2, 2}, {0.1, 2}, {0.1, 0.1}, {0.4, 0.1}, {0.4, 6}}, -1, 1, true);
  Vis many = haze();
  many.opacitymap.points.clear();
  for (int i = 0; i <= 40; i++) many.opacitymap.points.push_back({-1 + 0.05 * i, 1 + std::sin(1.3 * i)});
  for (const Cells cells : {Cells::Tetrahedra, Cells::All})
    for (const Vis& vis : {stepped, spikes(), many}) {
      TestScene scene = cellScene(cells, waves, vis, 20);
      scene.settings.tolerance = 1.0 / 4096;
      agreement::CompareOptions options;
      options.tolerance = 1.0 / 4096;
      options.vulkan = false;
      expectAgreement(embree(), scene, options);
    }
}

TEST(CellValues, SlicesAndIsosurfacesAgreeWithTheReference) {
  for (const Cells cells : kKinds) {
    agreement::CompareOptions options;
    options.vulkan = cells == Cells::All;
    const Vis vis = surfacesIn({0.2, -0.4}, {{{1, 0.3, 0.2}, 0.1}});
    expectAgreement(embree(), cellScene(cells, waves, vis, 16), options, 4);
    expectAgreement(embree(), cellScene(cells, waves, smooth(vis), 16), kFirstAlone, 4);
    expectAgreement(embree(), cellScene(cells, waves, surfacesInHaze(), 14), kFirstAlone, 4);
  }
}

TEST(CellValues, CellsWithoutDataAreTransparent) {
  for (const Cells cells : {Cells::Tetrahedra, Cells::All}) {
    const Vis surfaces = surfacesIn({0.1}, {{{1, 0.3, 0.2}, 0.1}});
    expectAgreement(embree(), cellScene(cells, holed, haze(3)), kFirstAlone);
    expectAgreement(embree(), cellScene(cells, holed, smooth(haze(3))), kFirstAlone);
    expectAgreement(embree(), cellScene(cells, holed, surfaces), kFirstAlone, 4);
    expectAgreement(embree(), cellScene(cells, holed, smooth(surfaces)), kFirstAlone, 4);
  }
}

// Parallel rays along z through n^3 cubes: the optical depth is the sum of those of the cells, by Beer and Lambert's law.
TEST(CellValues, AFlatCellHasOneOpticalDepth) {
  constexpr int kCubes = 5, kPixels = 20;
  const auto field = [](glm::dvec3 p) { return 0.5 + 0.5 * std::sin(3 * p.x + 5 * p.y + 7 * p.z); };
  for (const Cells cells : {Cells::Hexahedra, Cells::Tetrahedra}) {
    // Tetrahedra of one cube have one value.
    const auto ofCube = [&](glm::dvec3 p) {
      return field((glm::floor((p + 1.0) * (0.5 * kCubes)) + 0.5) * (2.0 / kCubes) - 1.0);
    };
    TestScene scene = meshScene("cell_values_slab", rendered({{0, 0}, {1, 2}}, 0, 1, true),
                                cellsOf(cells, ofCube, kCubes, 0), kPixels);
    scene.camera.viewpoint = {0, 0, 4};
    scene.camera.viewdirection = {0, 0, -1};
    scene.camera.viewup = {0, 1, 0};
    scene.camera.aov = 0;
    scene.camera.height = 2;
    scene.settings.background = glm::dvec4(0);
    const Picture picture = agreement::draw(embree(), scene);
    for (int y = 0; y < kPixels; y++)
      for (int x = 0; x < kPixels; x++) {
        double depth = 0;
        for (int k = 0; k < kCubes; k++)
          depth +=
              2 *
              ofCube({(2 * x + 1.0) / kPixels - 1, (2 * y + 1.0) / kPixels - 1, (2 * k + 1.0) / kCubes - 1}) *
              (2.0 / kCubes);
        EXPECT_NEAR(picture.rgba[size_t(4 * (y * kPixels + x) + 3)], -std::expm1(-depth), 2e-6)
            << x << " " << y;
      }
  }
}

TEST(CellValues, ASliceShowsTheValuesOfCells) {
  constexpr int kCubes = 4, kPixels = 16;
  const auto field = [](glm::dvec3 p) {
    return std::floor(2 * (p.x + 1)) / 4 + std::floor(2 * (p.y + 1)) / 16;
  };
  Vis vis = surfacesIn({}, {{{0, 0, 1}, 0.1}});
  vis.colormap = {{{0, {0, 0, 0}}, {1, {1, 1, 1}}}};
  for (const Cells cells : {Cells::Hexahedra, Cells::Tetrahedra}) {
    TestScene scene = meshScene("cell_values_slice", vis, cellsOf(cells, field, kCubes, 0), kPixels);
    scene.visualization.lighting = {};
    scene.visualization.lighting.Ka = 1, scene.visualization.lighting.Kd = 0;
    scene.camera.viewpoint = {0, 0, 4};
    scene.camera.viewdirection = {0, 0, -1};
    scene.camera.viewup = {0, 1, 0};
    scene.camera.aov = 0;
    scene.camera.height = 2;
    const Picture picture = agreement::draw(embree(), scene);
    for (int y = 0; y < kPixels; y++)
      for (int x = 0; x < kPixels; x++)
        EXPECT_NEAR(picture.rgba[size_t(4 * (y * kPixels + x))],
                    field({(2 * x + 1.0) / kPixels - 1, (2 * y + 1.0) / kPixels - 1, 0}), 1e-6)
            << nameOf(cells) << " " << x << " " << y;
  }
}

// A scene takes over what another one has only where both show cells alike.
TEST(CellValues, ScenesThatShowCellsOtherwiseShareNothing) {
  TestScene flat = cellScene(Cells::All, waves, surfacesInHaze(), 16);
  TestScene other = cellScene(Cells::All, waves, smooth(surfacesInHaze()), 16);
  other.data = flat.data;
  const Picture alone = agreement::draw(embree(), other);
  other.others = {flat.compile()};
  EXPECT_EQ(agreement::draw(embree(), other).rgba, alone.rgba);
  EXPECT_NE(agreement::draw(embree(), flat).rgba, alone.rgba);
}

TEST(CellValues, OfSeveralComponentsOneOrTheMagnitudeIsShown) {
  const MeshPiece one = cellsOf(Cells::All, waves);
  MeshPiece two = one, magnitude = one;
  two.components = 2;
  for (const CellType type : kAllCellTypes) {
    auto& values = two.cellValues[size_t(type)];
    values.clear();
    for (size_t c = 0; c < one.cellValues[size_t(type)].size(); c++) {
      const float x = one.cellValues[size_t(type)][c], y = 0.25f * float(c % 4);
      values.insert(values.end(), {y, x});
      magnitude.cellValues[size_t(type)][c] = std::sqrt(x * x + y * y);
    }
  }
  const auto pictureOf = [](const MeshPiece& piece, std::optional<int> component) {
    Vis vis = haze();
    vis.slices = {{{1, 0.3, 0.2}, 0.1}};
    vis.opacity = 0.5;
    vis.component = component;
    return agreement::draw(embree(), meshScene("cell_values_components", vis, piece, 24)).rgba;
  };
  EXPECT_EQ(pictureOf(two, 1), pictureOf(one, {}));
  EXPECT_EQ(pictureOf(two, {}), pictureOf(magnitude, {}));
}

}  // namespace
}  // namespace gxy::test
