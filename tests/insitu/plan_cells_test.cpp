// SPDX-License-Identifier: Apache-2.0
// Cells that are taken, and those that are refused.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "core/comm/error.h"
#include "insitu/plan/cells.h"

namespace gxy::insitu {
namespace {

/// Three triangles, a quad and a strip of five points.
struct Arrays {
  std::vector<glm::dvec3> points = std::vector<glm::dvec3>(6);
  std::vector<uint8_t> types{5, 5, 5, 9, 6};
  std::vector<uint32_t> ends{3, 6, 9, 13, 18},
      connectivity{0, 1, 2, 1, 2, 3, 2, 3, 4, 0, 1, 2, 5, 0, 1, 2, 3, 4};
  Cells cells() const { return {points.size(), types, ends, connectivity}; }
};

Mesh::Shape shapeOf(const Arrays& a, Mesh::Shape known = Mesh::Shape::Unknown) {
  return check(a.cells(), known, "mesh", [&](size_t point) { return a.points[point]; });
}

void expectRefused(const std::function<void(Arrays&)>& change, const std::string& why,
                   Mesh::Shape known = Mesh::Shape::Unknown) {
  Arrays a;
  change(a);
  std::string error;
  try {
    shapeOf(a, known);
  } catch (const Error& e) {
    error = e.what();
  }
  EXPECT_EQ(error, why);
}

TEST(PlanCells, SayWhatTheyBecome) {
  EXPECT_EQ(shapeOf({}), Mesh::Shape::Triangles);
  EXPECT_EQ(primitivesOf(Arrays().cells()), 3u + 2 + 3);
  Arrays lines;
  lines.types = {3, 4, 4, 4};
  lines.ends = {2, 2, 3, 18};
  EXPECT_EQ(shapeOf(lines), Mesh::Shape::Lines);
  EXPECT_EQ(primitivesOf(lines.cells()), 1u + 0 + 0 + 14);
  Arrays solid;
  solid.types = {10, 14, 10, 14};
  solid.ends = {4, 9, 13, 18};
  EXPECT_EQ(shapeOf(solid), Mesh::Shape::Volume);
  EXPECT_EQ(check({}, Mesh::Shape::Unknown, "mesh", {}), Mesh::Shape::Unknown);
  EXPECT_EQ(check({}, Mesh::Shape::Lines, "mesh", {}), Mesh::Shape::Lines);
}

TEST(PlanCells, ThatAreWrongAreRefusedWithTheirNumber) {
  const std::string taken =
      " are not supported, expected lines (3, 4), triangles, strips, polygons, pixels and quads (5 to 9), or "
      "tetrahedra, voxels, hexahedra, wedges and pyramids (10 to 14)";
  expectRefused([](Arrays& a) { a.types[2] = 24; },
                "mesh, cell 2: cells of type 24 (quadratic tetrahedra)" + taken);
  expectRefused([](Arrays& a) { a.types[0] = 42; }, "mesh, cell 0: cells of type 42 (polyhedra)" + taken);
  expectRefused([](Arrays& a) { a.types[4] = 1; }, "mesh, cell 4: cells of type 1 (vertices)" + taken);
  expectRefused([](Arrays& a) { a.types[4] = 200; }, "mesh, cell 4: cells of type 200" + taken);
  expectRefused(
      [](Arrays& a) { a.types[3] = 10; },
      "mesh, cell 3: type 10, of cells with a volume, in a mesh of triangles, expected the same for all "
      "cells of a mesh");
  expectRefused(
      [](Arrays& a) { a.types[1] = 4; },
      "mesh, cell 1: type 4, of lines, in a mesh of triangles, expected the same for all cells of a mesh");
  expectRefused(
      [](Arrays&) {},
      "mesh, cell 0: type 5, of triangles, in a mesh of lines, expected the same for all cells of a mesh",
      Mesh::Shape::Lines);
  const std::string offsets =
      ": its offsets do not ascend, or are negative, or above 2^32 - 2, expected offsets that ascend from 0";
  expectRefused([](Arrays& a) { a.ends[3] = 8; }, "mesh, cell 3" + offsets);
  expectRefused([](Arrays& a) { a.ends[1] = kNoPlace; }, "mesh, cell 1" + offsets);
  expectRefused([](Arrays& a) { a.ends[4] = 19; },
                "mesh, cell 4: it ends at 19 of 18 numbers of points, expected all in cells");
  expectRefused([](Arrays& a) { a.connectivity.push_back(0); },
                "mesh: the cells end at 18 of 19 numbers of points, expected all in cells");
  expectRefused([](Arrays& a) { a.ends[0] = 2; }, "mesh, cell 0: 2 points, expected 3 for type 5");
  expectRefused([](Arrays& a) { a.types[4] = 9; }, "mesh, cell 4: 5 points, expected 4 for type 9");
  expectRefused(
      [](Arrays& a) { a.connectivity[12] = 6; },
      "mesh, cell 3: its point 3 is 6 in connectivity, expected one of the 6 points of its rank, from 0");
  expectRefused([](Arrays& a) { a.connectivity[0] = kNoPlace; },
                "mesh, cell 0: its point 0 is negative or above 2^32 - 2 in connectivity, "
                "expected one of the 6 points of its rank, from 0");
  expectRefused([](Arrays& a) { a.points[5].y = NAN; },
                "mesh, cell 3: the coordinates of point 5 are not finite, expected finite ones");
}

TEST(PlanCells, CellsWithAVolumeHaveTheNumberOfPointsOfTheirType) {
  const size_t points[] = {4, 8, 8, 6, 5};
  for (int type = 10; type <= 14; type++) {
    EXPECT_EQ(pointsOfEach(type), points[type - 10]);
    Arrays a;
    a.types = {uint8_t(type)};
    a.ends = {uint32_t(pointsOfEach(type))};
    a.connectivity.assign(pointsOfEach(type), 5);
    EXPECT_EQ(shapeOf(a), Mesh::Shape::Volume);
    a.ends[0]--;
    a.connectivity.pop_back();
    EXPECT_THROW(shapeOf(a), Error);
  }
}

TEST(PlanCells, APointThatNoCellUsesMayBeAnything) {
  Arrays a;
  a.points.push_back(glm::dvec3(NAN));
  EXPECT_EQ(shapeOf(a), Mesh::Shape::Triangles);
}

}  // namespace
}  // namespace gxy::insitu
