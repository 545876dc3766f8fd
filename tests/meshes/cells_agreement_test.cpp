// SPDX-License-Identifier: Apache-2.0
// Meshes of hexahedra, wedges, pyramids and of all types of cells: backends against reference.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/agreement/draw.h"
#include "tests/meshes/cells.h"
#include "tests/meshes/mesh_scenes.h"

namespace gxy::test {
namespace {

using agreement::embree;
using agreement::TestScene;

TestScene cellScene(Cells cells, double far, Vis vis, int size = 36, uint32_t n = 7) {
  return meshScene("cells_" + nameOf(cells), std::move(vis), cubeOfCells(cells, n, far, waves), size);
}

TEST(CellAgreement, SmoothMap) {
  for (const Cells cells : kOtherCells) expectAgreement(embree(), cellScene(cells, 0.15, haze()));
}

TEST(CellAgreement, SpikyMap) {
  for (const Cells cells : {Cells::Hexahedra, Cells::Pyramids, Cells::All})
    expectAgreement(embree(), cellScene(cells, 0.15, spikes(), 20));
}

TEST(CellAgreement, CellsThatAreNotBent) {
  for (const Cells cells : kOtherCells) {
    TestScene scene = cellScene(cells, 0, haze());
    scene.settings.tolerance = 1.0 / 4096;
    agreement::CompareOptions options = kFirstAlone;
    options.tolerance = 1.0 / 4096;
    expectAgreement(embree(), scene, options);
  }
}

TEST(CellAgreement, IsosurfacesAndSlices) {
  for (const Cells cells : kOtherCells) {
    agreement::CompareOptions options;
    options.vulkan = cells == Cells::All;
    expectAgreement(embree(), cellScene(cells, 0.15, surfacesIn({0.2, -0.4}, {{{1, 0.3, 0.2}, 0.1}}), 20),
                    options);
    expectAgreement(embree(), cellScene(cells, 0.15, surfacesInHaze(), 16), kFirstAlone);
  }
}

TEST(CellAgreement, ShadowsAndOcclusion) {
  TestScene scene = cellScene(Cells::All, 0.15, surfacesIn({0.2}, {{{0, 1, 0}, -0.8}}), 20);
  scene.visualization.lighting = agreement::lit({agreement::kSun, agreement::kLamp}, true);
  scene.visualization.lighting.aoCount = 2;
  scene.visualization.lighting.aoRadius = 0.7;
  expectAgreement(embree(), scene);
}

// By Beer and Lambert's law, whatever the cells are.
TEST(CellAgreement, UniformSlab) {
  for (const Cells cells : kOtherCells) {
    TestScene scene = meshScene("cells_slab", rendered({{0, 3}, {1, 3}}, 0, 1, true),
                                cubeOfCells(cells, 6, 0.3, [](glm::dvec3) { return 0.5; }), 32);
    scene.camera.viewpoint = {0.01, 0.02, 4};
    scene.camera.viewdirection = {0, 0, -1};
    scene.camera.aov = 0;
    scene.camera.height = 1.9;
    scene.settings.background = glm::dvec4(0);
    const Picture picture = agreement::draw(embree(), scene);
    for (size_t i = 3; i < picture.rgba.size(); i += 4)
      ASSERT_NEAR(picture.rgba[i], -std::expm1(-6.0), 1e-5) << nameOf(cells);
  }
}

// What is linear in space is the same in cells of all types, bent or not.
TEST(CellAgreement, LinearFieldsAreThoseOfTetrahedra) {
  const auto linear = [](glm::dvec3 p) { return 0.5 * p.x - 0.3 * p.y + 0.4 * p.z; };
  for (const bool surfaces : {false, true}) {
    const auto pictureOf = [&](Cells cells) {
      Vis vis = surfaces ? surfacesIn({-0.2, 0.3}, {{{0, 1, 0.2}, 0.1}}) : haze(3);
      return agreement::draw(embree(),
                             meshScene("cells_linear", vis, cubeOfCells(cells, 5, 0.2, linear), 48));
    };
    const Picture expected = pictureOf(Cells::Tetrahedra);
    for (const Cells cells : kOtherCells) {
      const Picture picture = pictureOf(cells);
      size_t different = 0;
      for (size_t i = 0; i < picture.rgba.size(); i++)
        different += std::abs(picture.rgba[i] - expected.rgba[i]) > 1.0f / 512;
      EXPECT_LE(different, 4u) << nameOf(cells) << (surfaces ? ", surfaces" : ", volume");
    }
  }
}

}  // namespace
}  // namespace gxy::test
