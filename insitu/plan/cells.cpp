// SPDX-License-Identifier: Apache-2.0
#include "insitu/plan/cells.h"

#include <cmath>

#include "core/comm/error.h"
#include "core/data/mesh.h"
#include "core/data/mesh_kinds.h"

namespace gxy::insitu {

namespace {

bool isFinite(const glm::dvec3& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

}  // namespace

Mesh::Shape shapeOf(int type, const std::string& what) {
  if (becomesLines(type)) return Mesh::Shape::Lines;
  if (becomesTriangles(type)) return Mesh::Shape::Triangles;
  if (meshCellOf(type)) return Mesh::Shape::Volume;
  const char* plural = pluralOfKind(type);
  throw Error(
      what + ": cells of type " + std::to_string(type) + (plural ? " (" + std::string(plural) + ")" : "") +
      " are not supported, expected lines (3, 4), triangles, strips, polygons, pixels and quads (5 to 9), "
      "or tetrahedra, voxels, hexahedra, wedges and pyramids (10 to 14)");
}

size_t pointsOfEach(int type) {
  if (const auto cell = meshCellOf(type)) return gxy::shapeOf(*cell).points;
  return gxy::pointsOfEach(DrawnCellType(type));
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
                  nameOf(shape) + ", expected the same for all cells of a mesh");
    const size_t end = cells.ends[c];
    if (end > cells.connectivity.size())
      throw Error(at(c) + ": it ends at " + std::to_string(end) + " of " +
                  std::to_string(cells.connectivity.size()) + " numbers of points, expected all in cells");
    const size_t count = end - begin, expected = pointsOfEach(type);
    if (expected > 0 && count != expected)
      throw Error(at(c) + ": " + std::to_string(count) + " points, expected " + std::to_string(expected) +
                  " for type " + std::to_string(type));
    for (; begin < end; begin++) {
      const uint32_t point = cells.connectivity[begin];
      if (point >= cells.points)
        throw Error(at(c) + ": its point " + std::to_string(count - (end - begin)) + " is " +
                    (point == kNoPlace ? "negative or above 2^32 - 2" : std::to_string(point)) +
                    " in connectivity, expected one of the " + std::to_string(cells.points) +
                    " points of its rank, from 0");
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
