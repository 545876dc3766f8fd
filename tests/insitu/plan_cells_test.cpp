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
  EXPECT_EQ(check({}, Mesh::Shape::Unknown, "mesh", {}), Mesh::Shape::Unknown);
  EXPECT_EQ(check({}, Mesh::Shape::Lines, "mesh", {}), Mesh::Shape::Lines);
}

TEST(PlanCells, ThatAreWrongAreRefusedWithTheirNumber) {
  const std::string taken =
      ", expected lines (3, 4), or triangles, strips, polygons, pixels and quads (5 to 9)";
  expectRefused(
      [](Arrays& a) { a.types[2] = 10; },
      "mesh, cell 2: cells of type 10 (tetrahedron) are not supported yet, nor are others with a volume" +
          taken);
  expectRefused(
      [](Arrays& a) { a.types[0] = 42; },
      "mesh, cell 0: cells of type 42 (polyhedron) are not supported yet, nor are others with a volume" +
          taken);
  expectRefused([](Arrays& a) { a.types[4] = 1; },
                "mesh, cell 4: cells of type 1 (vertex) are not supported" + taken);
  expectRefused([](Arrays& a) { a.types[4] = 200; },
                "mesh, cell 4: cells of type 200 are not supported" + taken);
  expectRefused([](Arrays& a) { a.types[1] = 4; },
                "mesh, cell 1: type 4, of lines, in a mesh of triangles, expected one of both in a mesh");
  expectRefused([](Arrays&) {},
                "mesh, cell 0: type 5, of triangles, in a mesh of lines, expected one of both in a mesh",
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
  expectRefused([](Arrays& a) { a.connectivity[12] = 6; },
                "mesh, cell 3: point 6, expected one of the 6 points of its rank, from 0");
  expectRefused([](Arrays& a) { a.connectivity[0] = kNoPlace; },
                "mesh, cell 0: point number negative, or above 2^32 - 2, expected one of the 6 points of its "
                "rank, from 0");
  expectRefused([](Arrays& a) { a.points[5].y = NAN; },
                "mesh, cell 3: the coordinates of point 5 are not finite, expected finite ones");
}

TEST(PlanCells, APointThatNoCellUsesMayBeAnything) {
  Arrays a;
  a.points.push_back(glm::dvec3(NAN));
  EXPECT_EQ(shapeOf(a), Mesh::Shape::Triangles);
}

}  // namespace
}  // namespace gxy::insitu
