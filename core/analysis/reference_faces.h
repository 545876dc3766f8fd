// SPDX-License-Identifier: Apache-2.0
// The faces of cells in reference coordinates (reference/cell_map.h), where they are planes.
#pragma once
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <span>

#include "core/data/mesh.h"

namespace gxy {

/// A face as a plane: distance() is 0 on it, positive inside the cell, and 1 at the corner that is the farthest away.
struct ReferenceFace {
  double offset;
  glm::dvec3 normal;
  double distance(glm::dvec3 place) const { return offset + glm::dot(normal, place); }
};

/// The faces of a type, in the order of shapeOf().
std::span<const ReferenceFace> referenceFaces(CellType type);

/// Moves a place that is outside by rounding into the cell.
glm::dvec3 intoCell(CellType type, glm::dvec3 place);

/// Moves a place that is near a face onto it, up to rounding, and into the cell.
glm::dvec3 ontoFace(CellType type, int face, glm::dvec3 place);

/// Of a place on a face of a cell of type `from`, returns the place in the neighbour, of type `to`, that has the face too. The points are
/// the numbers of each cell's.
glm::dvec3 acrossFace(CellType from, std::span<const uint32_t> fromPoints, int face, glm::dvec3 place,
                      CellType to, std::span<const uint32_t> toPoints);

}  // namespace gxy
