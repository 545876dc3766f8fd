// SPDX-License-Identifier: Apache-2.0
// Meshes whose cells meet others of half their size: faces that coincide with several smaller ones, and points in the middle of faces and
// edges. Rays leave the mesh and enter it again at the same t.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/agreement/draw.h"
#include "tests/meshes/cells.h"
#include "tests/meshes/mesh_cuts.h"

namespace gxy::test {
namespace {

using agreement::embree;
using agreement::rendered;

/// [-1, 1]^3: n^3 cubes of cells at x < 0, (k n)^3 at x > 0. Points inside either half are moved, not those at x = 0.
MeshPiece hanging(Cells cells, uint32_t n, uint32_t k, const Field& field) {
  const auto half = [&](uint32_t cubes, double from) {
    MeshPiece piece = cubeOfCells(cells, cubes, 0.1, waves, cubes);
    for (glm::dvec3& p : piece.points) p.x = from + 0.5 * (p.x + 1);
    for (size_t i = 0; i < piece.points.size(); i++) piece.values[i] = float(field(piece.points[i]));
    return piece;
  };
  return joined(half(n, -1), half(n * k, 0));
}

double slope(glm::dvec3 p) { return 0.5 * p.x - 0.3 * p.y + 0.4 * p.z; }
double one(glm::dvec3) { return 0.5; }

constexpr std::array kKinds{Cells::Tetrahedra, Cells::Hexahedra, Cells::Wedges, Cells::All};

TEST(Hanging, UniformCellsHaveNeitherGapsNorOverlaps) {
  for (const Cells cells : kKinds)
    for (const uint32_t k : {2u, 3u})
      for (const glm::dvec3 towards : {glm::dvec3(-1, 0, 0), glm::dvec3(1, 0, 0), glm::dvec3(0, 0, -1)}) {
        agreement::TestScene scene =
            meshScene("hanging_slab", rendered({{0, 3}, {1, 3}}, 0, 1, true), hanging(cells, 3, k, one), 24);
        scene.camera.viewpoint = -4.0 * towards;  // rays in planes of points, too
        scene.camera.viewdirection = towards;
        scene.camera.aov = 0;
        scene.camera.height = 2 * 24.0 / 23;
        scene.settings.background = glm::dvec4(0);
        const Picture picture = agreement::draw(embree(), scene);
        for (int y = 1; y < 23; y++)
          for (int x = 1; x < 23; x++)
            ASSERT_NEAR(picture.rgba[size_t(4 * (24 * y + x) + 3)], -std::expm1(-6.0), 1e-5)
                << nameOf(cells) << " " << k << " " << towards.x << " " << x << " " << y;
      }
}

TEST(Hanging, LinearFieldsAreThoseOfAMeshWithoutHangingPoints) {
  for (const Cells cells : kKinds) {
    agreement::CompareOptions options;
    options.vulkan = cells == Cells::All;
    expectAgreement(embree(), meshScene("hanging", haze(3), hanging(cells, 3, 2, slope), 20), options);
    expectAgreement(embree(),
                    meshScene("hanging_surfaces", surfacesIn({-0.2, 0.3}, {{{0, 1, 0.2}, 0.1}}),
                              hanging(cells, 3, 2, slope), 20),
                    kFirstAlone);
  }
}

TEST(Hanging, CellsHaveTheirValues) {
  for (const Cells cells : kKinds)
    expectAgreement(
        embree(), meshScene("hanging_cells", haze(3), withCellValues(hanging(cells, 3, 2, slope), waves), 24),
        kFirstAlone);
}

// Where faces that coincide are met within a rounding, the t of one side or of the other may be the larger one.
TEST(Hanging, PicturesAreTheSameWithinARoundingOnAnyPartitions) {
  for (const Cells cells : kKinds) {
    TestScene scene = cutScene(hanging(cells, 3, 2, waves), haze(2), 20);
    std::vector<Cut> cuts = arbitraryCuts(81);
    cuts.push_back(lattice(kDomain, {2, 3, 3}, 2));  // in the plane of the hanging points
    for (const bool alongX : {false, true}) {
      if (alongX) orthographic(scene, {1, 0, 0}, 2.2);
      const Picture expected = wholeOnEmbree(scene);
      for (const Cut& cut : cuts) {
        const Picture picture = render(scene, cut);
        for (size_t i = 0; i < expected.rgba.size(); i++)
          ASSERT_NEAR(picture.rgba[i], expected.rgba[i], 1e-6) << nameOf(cells) << ", " << cut.name;
      }
    }
  }
}

}  // namespace
}  // namespace gxy::test
