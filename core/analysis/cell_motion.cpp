// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/cell_motion.h"

#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <span>

namespace gxy {

namespace {

/// A part of splitmix64 (Steele, Lea & Flood 2014).
uint64_t mixedBits(uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

}  // namespace

CellMotion::CellMotion(const Mesh& mesh, const MeshBlock& block, uint32_t cell, double sign)
    : corners_(block, cell) {
  const std::span<const uint32_t> points = block.cells.pointsOf(cell);
  glm::dvec3 lo(std::numeric_limits<double>::infinity()), hi = -lo, zero(0);
  for (size_t k = 0; k < points.size(); k++) {
    for (int a = 0; a < 3; a++)
      velocity_[k][a] =
          sign * (mesh.shift + mesh.scale * double(block.values[3 * size_t(points[k]) + size_t(a)]));
    lo = glm::min(lo, velocity_[k]), hi = glm::max(hi, velocity_[k]);
    zero += velocity_[k] - velocity_[k];
  }
  for (size_t a = 0; a < 3 && !block.cellValues.empty(); a++) {
    const double own = block.cellValues[3 * size_t(cell) + a];
    zero += glm::dvec3(own - own);
  }
  hasData_ = zero == glm::dvec3(0);
  spread_ = glm::length(hi - lo);
  if (type() != CellType::Tetrahedron) return;
  const reference::Jacobian jacobian(reference::shapeAt(type(), glm::dvec3(0)), corners_.points());
  if (!jacobian.isRegular()) return;
  rates_.emplace();
  for (size_t k = 0; k < 4; k++) (*rates_)[k] = jacobian.inReference(velocity_[k]);
}

glm::dvec3 CellMotion::worldAt(glm::dvec3 place) const {
  return reference::shapeAt(type(), place).mean(corners_.points());
}

glm::dvec3 CellMotion::velocityAt(glm::dvec3 place) const {
  return reference::shapeAt(type(), place).mean(std::span(velocity_).first(corners_.points().size()));
}

double CellMotion::speedAt(glm::dvec3 place) const { return glm::length(velocityAt(place)); }

std::optional<glm::dvec3> CellMotion::rateAt(glm::dvec3 q) const {
  if (type() == CellType::Tetrahedron) {
    if (!rates_) return std::nullopt;
    const auto& r = *rates_;
    return (1 - q.x - q.y - q.z) * r[0] + q.x * r[1] + q.y * r[2] + q.z * r[3];
  }
  const reference::ShapeFunctions shape = reference::shapeAt(type(), q);
  const std::span<const glm::dvec3> points = corners_.points();
  const reference::Jacobian jacobian(shape, points);
  if (!jacobian.isRegular()) return std::nullopt;
  return jacobian.inReference(shape.mean(std::span(velocity_).first(points.size())));
}

uint64_t keyOf(const MeshBlock& block, uint32_t cell) {
  uint64_t key = 0;
  for (const uint32_t point : block.cells.pointsOf(cell))
    for (int a = 0; a < 3; a++)  // -0 counts as 0
      key = mixedBits(key + 0x9e3779b97f4a7c15 + std::bit_cast<uint64_t>(block.points[point][a] + 0.0));
  return key;
}

}  // namespace gxy
