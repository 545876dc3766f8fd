// SPDX-License-Identifier: Apache-2.0
#include "insitu/plan/cells.h"

#include <cmath>
#include <iterator>

#include "core/comm/error.h"

namespace gxy::insitu {

namespace {

struct NamedType {
  int type;
  const char* name;
};
constexpr NamedType kNotTaken[] = {{0, "empty cell"},
                                   {1, "vertex"},
                                   {2, "poly-vertex"},
                                   {10, "tetrahedron"},
                                   {11, "voxel"},
                                   {12, "hexahedron"},
                                   {13, "wedge"},
                                   {14, "pyramid"},
                                   {15, "pentagonal prism"},
                                   {16, "hexagonal prism"},
                                   {21, "quadratic edge"},
                                   {22, "quadratic triangle"},
                                   {23, "quadratic quad"},
                                   {24, "quadratic tetrahedron"},
                                   {25, "quadratic hexahedron"},
                                   {26, "quadratic wedge"},
                                   {27, "quadratic pyramid"},
                                   {42, "polyhedron"}};

std::string nameOf(int type) {
  for (const NamedType& named : kNotTaken)
    if (named.type == type) return std::to_string(type) + " (" + named.name + ")";
  return std::to_string(type);
}

const char* nameOf(Mesh::Shape shape) { return shape == Mesh::Shape::Lines ? "lines" : "triangles"; }

bool isFinite(const glm::dvec3& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

}  // namespace

Mesh::Shape shapeOf(int type, const std::string& what) {
  if (becomesLines(type)) return Mesh::Shape::Lines;
  if (becomesTriangles(type)) return Mesh::Shape::Triangles;
  const bool isSolid = (type >= 10 && type <= 16) || (type >= 24 && type <= 27) || type == 42;
  throw Error(what + ": cells of type " + nameOf(type) + " are not supported" +
              (isSolid ? " yet, nor are others with a volume" : "") +
              ", expected lines (3, 4), or triangles, strips, polygons, pixels and quads (5 to 9)");
}

Mesh::Shape check(const Cells& cells, Mesh::Shape shape, const std::string& what,
                  const std::function<glm::dvec3(size_t point)>& position) {
  const auto at = [&](size_t cell) { return what + ", cell " + std::to_string(cell); };
  // The offsets come first: where one is wrong, the simulation sends no corners.
  for (size_t c = 0; c < cells.count(); c++)
    if (cells.ends[c] == kNoPlace || (c > 0 && cells.ends[c] < cells.ends[c - 1]))
      throw Error(at(c) +
                  ": its offsets do not ascend, or are negative, or above 2^32 - 2, expected offsets that "
                  "ascend from 0");
  size_t begin = 0;
  for (size_t c = 0; c < cells.count(); c++) {
    const int type = cells.types[c];
    const Mesh::Shape own = shapeOf(type, at(c));
    if (shape == Mesh::Shape::Unknown) shape = own;
    if (own != shape)
      throw Error(at(c) + ": type " + std::to_string(type) + ", of " + nameOf(own) + ", in a mesh of " +
                  nameOf(shape) + ", expected one of both in a mesh");
    const size_t end = cells.ends[c];
    if (end > cells.connectivity.size())
      throw Error(at(c) + ": it ends at " + std::to_string(end) + " of " +
                  std::to_string(cells.connectivity.size()) + " numbers of points, expected all in cells");
    const size_t count = end - begin, expected = pointsOfEach(DrawnCellType(type));
    if (expected > 0 && count != expected)
      throw Error(at(c) + ": " + std::to_string(count) + " points, expected " + std::to_string(expected) +
                  " for type " + std::to_string(type));
    for (; begin < end; begin++) {
      const uint32_t point = cells.connectivity[begin];
      if (point >= cells.points)
        throw Error(at(c) + ": point " +
                    (point == kNoPlace ? "number negative, or above 2^32 - 2" : std::to_string(point)) +
                    ", expected one of the " + std::to_string(cells.points) + " points of its rank, from 0");
      if (!isFinite(position(point)))
        throw Error(at(c) + ": the coordinates of point " + std::to_string(point) +
                    " are not finite, expected finite ones");
    }
  }
  if (begin != cells.connectivity.size())
    throw Error(what + ": the cells end at " + std::to_string(begin) + " of " +
                std::to_string(cells.connectivity.size()) + " numbers of points, expected all in cells");
  return shape;
}

uint64_t primitivesOf(const Cells& cells) {
  uint64_t count = 0;
  for (size_t c = 0; c < cells.count(); c++)
    count += gxy::primitivesOf(DrawnCellType(cells.types[c]), cells.corners(c).size());
  return count;
}

}  // namespace gxy::insitu
