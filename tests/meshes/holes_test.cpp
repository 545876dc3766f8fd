// SPDX-License-Identifier: Apache-2.0
// Rays leave out bricks of cells of which the map shows nothing, and pictures have the same bits as with them.
#include <gtest/gtest.h>

#include <bit>
#include <glm/geometric.hpp>

#include "tests/meshes/cells.h"
#include "tests/meshes/mesh_cuts.h"

namespace gxy::test {
namespace {

double distance(glm::dvec3 p) { return glm::length(p); }

/// A shell, of values from 0.5 to 0.6.
Vis shellMap() { return rendered({{0.5, 0}, {0.52, 15}, {0.58, 15}, {0.6, 0}}, 0, 1.8, true); }

/// The scene in one partition. `everyCell`: as if cells overlapped, so that rays go through all.
std::vector<RankScene> compiledWhole(const TestScene& scene, bool everyCell) {
  const auto partitioning = std::make_shared<const Partitioning>(Partitioning::single(kDomain));
  auto mesh = std::make_shared<Mesh>(
      *cut(*std::get<std::shared_ptr<const WholeMesh>>(scene.data.at(0)), *partitioning, 1).at(0));
  mesh->report.foldedFaces = everyCell ? 1 : 0;
  std::vector<OperatorData> data(1);
  data[0].mesh = std::move(mesh);
  const auto compiled = compileScene(scene.visualization, std::move(data), partitioning, scene.settings);
  return {{compiled, embree().makeScene(compiled, 0)}};
}

/// How many bricks rays leave out in a partition, and how many there are.
std::pair<size_t, size_t> bricksOf(const std::vector<RankScene>& scene) {
  const GeometryInPartition& part = *scene.at(0).compiled->operators.at(0).parts.at(0).geometry;
  size_t unseen = 0;
  for (const uint32_t word : part.unseen) unseen += size_t(std::popcount(word));
  return {unseen, part.arrays().bricks.size()};
}

void expectSameWithoutBricks(MeshPiece piece, const std::string& what) {
  const TestScene scene = cutScene(std::move(piece), shellMap(), 40);
  const auto some = compiledWhole(scene, false), all = compiledWhole(scene, true);
  const auto [unseen, bricks] = bricksOf(some);
  EXPECT_GT(4 * unseen, bricks) << what << ": " << bricks;
  EXPECT_EQ(bricksOf(all).first, 0u) << what;
  EXPECT_EQ(difference(render(scene, 1, all), render(scene, 1, some), Sameness::Bits), "") << what;
}

TEST(MeshHoles, WhereTheMapShowsNothingChangeNoBit) {
  expectSameWithoutBricks(cubeMesh(20, 0.17, distance), "tetrahedra");
  for (const Cells cells : {Cells::Hexahedra, Cells::All})
    expectSameWithoutBricks(cubeOfCells(cells, 20, 0.15, distance), nameOf(cells));
}

TEST(MeshHoles, ChangeNoBitOfConstantCells) {
  TestScene scene = cutScene(withCellValues(cubeMesh(20, 0.17, distance), distance), shellMap());
  EXPECT_GT(bricksOf(compiledWhole(scene, false)).first, 0u);
  expectSameBits(scene, arbitraryCuts(7), "flat");
}

TEST(MeshHoles, HideNothingOfSurfacesAndRaysThatBeginInThem) {
  TestScene scene = cutScene(cubeOfCells(Cells::Hexahedra, 14, 0.15, distance), shellMap());
  scene.visualization.operators[0].isovalues = {0.3};
  scene.visualization.operators[0].opacity = 0.6;
  scene.camera.viewpoint = {0.02, 0.01, 0.03};
  scene.camera.viewdirection = {0.4, 0.5, -1};
  scene.camera.aov = 80;
  EXPECT_GT(bricksOf(compiledWhole(scene, false)).first, 0u);
  addLights(scene);
  addOcclusion(scene);
  expectSameBits(scene, arbitraryCuts(17), "inside");
}

}  // namespace
}  // namespace gxy::test
