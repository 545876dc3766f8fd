// SPDX-License-Identifier: Apache-2.0
// The data of cells give one picture, bit for bit, however a mesh is cut into partitions and on however many ranks.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "tests/meshes/cells.h"
#include "tests/meshes/mesh_cuts.h"

namespace gxy::test {
namespace {

MeshPiece holedCells(Cells cells) {
  return withCellValues(cubeOfCells(cells, 6, 0.2, waves), [](glm::dvec3 p) {
    return glm::length(p - glm::dvec3(0.3, 0.2, 0.4)) < 0.4 ? std::numeric_limits<double>::quiet_NaN()
                                                            : waves(p);
  });
}

TEST(CellValueCuts, FlatAndSmooth) {
  for (const Cells cells : {Cells::Tetrahedra, Cells::All})
    for (const CellsShown shown : {CellsShown::Flat, CellsShown::Smooth}) {
      Vis vis = surfacesInHaze();
      vis.cells = shown;
      TestScene scene = cutScene(holedCells(cells), vis, 20);
      expectSameBits(scene, {kdCut(kDomain, 7, 4, 71), octants(kDomain, {0.123, -0.31, 0.217}, 4)},
                     nameOf(cells));
    }
}

TEST(CellValueCuts, PartitionsSmallerThanACell) {
  for (const Cells cells : {Cells::Tetrahedra, Cells::All})
    for (const CellsShown shown : {CellsShown::Flat, CellsShown::Smooth}) {
      Vis vis = haze(2);
      vis.cells = shown;
      expectSameBits(cutScene(withCellValues(cubeOfCells(cells, 2, 0.2, waves), waves), vis),
                     {lattice(kDomain, {9, 9, 9}, 4), kdCut(kDomain, 64, 8, 6)}, nameOf(cells));
    }
}

}  // namespace
}  // namespace gxy::test
