// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/reference_faces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>

#include "core/reference/cell_map.h"

namespace gxy {
namespace {

using FacesOfType = std::array<ReferenceFace, 6>;

FacesOfType facesOfType(CellType type) {
  const CellShape& shape = shapeOf(type);
  FacesOfType faces{};
  for (size_t f = 0; f < shape.faces; f++) {
    const auto& corner = shape.face[f].corner;
    const glm::dvec3 a = reference::placeOfCorner(type, corner[0]);
    const glm::dvec3 normal = glm::cross(reference::placeOfCorner(type, corner[1]) - a,
                                         reference::placeOfCorner(type, corner[2]) - a);
    double farthest = 0;
    for (size_t k = 0; k < shape.points; k++) {
      const double d = glm::dot(normal, reference::placeOfCorner(type, k) - a);
      if (std::abs(d) > std::abs(farthest)) farthest = d;
    }
    faces[f] = {-glm::dot(normal, a) / farthest, normal / farthest};
  }
  return faces;
}

}  // namespace

std::span<const ReferenceFace> referenceFaces(CellType type) {
  static const std::array<FacesOfType, kCellTypes> kFaces{
      facesOfType(CellType::Tetrahedron), facesOfType(CellType::Pyramid), facesOfType(CellType::Wedge),
      facesOfType(CellType::Hexahedron)};
  return std::span(kFaces[size_t(type)]).first(shapeOf(type).faces);
}

glm::dvec3 intoCell(CellType type, glm::dvec3 p) {
  switch (type) {
    case CellType::Hexahedron:
      return glm::clamp(p, 0.0, 1.0);
    case CellType::Pyramid: {
      const double r = std::clamp(p.z, 0.0, 1.0);
      return {std::clamp(p.x, 0.0, r), std::clamp(p.y, 0.0, r), r};
    }
    case CellType::Wedge: {
      const double x = std::max(p.x, 0.0), y = std::max(p.y, 0.0), all = std::max(x + y, 1.0);
      return {x / all, y / all, std::clamp(p.z, 0.0, 1.0)};
    }
    case CellType::Tetrahedron:
      break;
  }
  const glm::dvec3 q = glm::max(p, 0.0);
  return q / std::max(q.x + q.y + q.z, 1.0);
}

glm::dvec3 ontoFace(CellType type, int face, glm::dvec3 place) {
  const ReferenceFace& f = referenceFaces(type)[size_t(face)];
  return intoCell(type, place - f.distance(place) / glm::dot(f.normal, f.normal) * f.normal);
}

glm::dvec3 acrossFace(CellType from, std::span<const uint32_t> fromPoints, int face, glm::dvec3 place,
                      CellType to, std::span<const uint32_t> toPoints) {
  const reference::OfCorners weight = reference::shapeAt(from, place).weight;
  const CellFace& corners = shapeOf(from).face[size_t(face)];
  glm::dvec3 sum(0);
  double weights = 0;
  for (size_t k = 0; k < corners.corners; k++) {
    const size_t corner = corners.corner[k];
    const auto at = std::find(toPoints.begin(), toPoints.end(), fromPoints[corner]);
    const double w = std::max(weight[corner], 0.0);
    weights += w;
    sum += w * reference::placeOfCorner(to, size_t(at - toPoints.begin()));
  }
  return intoCell(to, sum / weights);
}

}  // namespace gxy
