// SPDX-License-Identifier: Apache-2.0
#include "core/reference/cell_map.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

namespace gxy::reference {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

ShapeFunctions hexahedronAt(glm::dvec3 p) {
  const double u = p.x, v = p.y, w = p.z, ru = 1 - u, rv = 1 - v, rw = 1 - w;
  ShapeFunctions at;
  at.weight = {ru * rv * rw, u * rv * rw, u * v * rw, ru * v * rw,
               ru * rv * w,  u * rv * w,  u * v * w,  ru * v * w};
  at.slope = {glm::dvec3(-rv * rw, -ru * rw, -ru * rv),
              {rv * rw, -u * rw, -u * rv},
              {v * rw, u * rw, -u * v},
              {-v * rw, ru * rw, -ru * v},
              {-rv * w, -ru * w, ru * rv},
              {rv * w, -u * w, u * rv},
              {v * w, u * w, u * v},
              {-v * w, ru * w, ru * v}};
  return at;
}

ShapeFunctions wedgeAt(glm::dvec3 p) {
  const std::array<double, 3> f{1 - p.x - p.y, p.x, p.y};
  const std::array<glm::dvec3, 3> slope{glm::dvec3(-1, -1, 0), {1, 0, 0}, {0, 1, 0}};
  ShapeFunctions at;
  for (size_t k = 0; k < 3; k++) {
    at.weight[k] = f[k] * (1 - p.z), at.weight[k + 3] = f[k] * p.z;
    at.slope[k] = slope[k] * (1 - p.z) - glm::dvec3(0, 0, f[k]);
    at.slope[k + 3] = slope[k] * p.z + glm::dvec3(0, 0, f[k]);
  }
  return at;
}

ShapeFunctions pyramidAt(glm::dvec3 p) {
  const double u = p.z > 0 ? p.x / p.z : 0.5, v = p.z > 0 ? p.y / p.z : 0.5, uv = u * v, both = uv * p.z;
  ShapeFunctions at;
  at.weight = {p.z - p.x - p.y + both, p.x - both, both, p.y - both, 1 - p.z};
  at.slope = {glm::dvec3(v - 1, u - 1, 1 - uv), {1 - v, -u, uv}, {v, u, -uv}, {-v, 1 - u, uv}, {0, 0, -1}};
  return at;
}

/// A place that is not too far from the cell.
glm::dvec3 near(CellType type, glm::dvec3 place) {
  constexpr double kBeyond = 0.5;
  if (type != CellType::Pyramid) return glm::clamp(place, -kBeyond, 1 + kBeyond);
  const double r = std::clamp(place.z, 0.0, 1 + kBeyond);
  return {std::clamp(place.x, -kBeyond * r, (1 + kBeyond) * r),
          std::clamp(place.y, -kBeyond * r, (1 + kBeyond) * r), r};
}

bool isInside(CellType type, glm::dvec3 p, double slack) {
  const double most = type == CellType::Pyramid ? p.z : 1;
  return std::min({p.x, p.y, p.z}) >= -slack && std::max(p.x, p.y) <= most + slack && p.z <= 1 + slack &&
         (type != CellType::Wedge || p.x + p.y <= 1 + slack) &&
         (type != CellType::Tetrahedron || p.x + p.y + p.z <= 1 + slack);
}

double largest(glm::dvec3 v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

}  // namespace

double ShapeFunctions::mean(const OfCorners& values) const {
  double sum = 0;
  for (size_t k = 0; k < 8; k++) sum += weight[k] * values[k];
  return sum;
}

glm::dvec3 ShapeFunctions::mean(std::span<const glm::dvec3> points) const {
  glm::dvec3 sum(0);
  for (size_t k = 0; k < points.size(); k++) sum += weight[k] * points[k];
  return sum;
}

ShapeFunctions shapeAt(CellType type, glm::dvec3 place) {
  switch (type) {
    case CellType::Hexahedron:
      return hexahedronAt(place);
    case CellType::Wedge:
      return wedgeAt(place);
    case CellType::Pyramid:
      return pyramidAt(place);
    case CellType::Tetrahedron:
      break;
  }
  ShapeFunctions linear;
  linear.weight = {1 - place.x - place.y - place.z, place.x, place.y, place.z};
  linear.slope = {glm::dvec3(-1), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  return linear;
}

glm::dvec3 placeOfCorner(CellType type, size_t corner) {
  const auto square = [](size_t k) { return glm::dvec3(k == 1 || k == 2, k >= 2, 0); };
  switch (type) {
    case CellType::Hexahedron:
      return square(corner % 4) + glm::dvec3(0, 0, corner / 4);
    case CellType::Wedge:
      return {corner % 3 == 1, corner % 3 == 2, corner / 3};
    case CellType::Pyramid:
      return corner == 4 ? glm::dvec3(0) : square(corner) + glm::dvec3(0, 0, 1);
    case CellType::Tetrahedron:
      break;
  }
  return {corner == 1, corner == 2, corner == 3};
}

Jacobian::Jacobian(const ShapeFunctions& shape, std::span<const glm::dvec3> points) : column_{} {
  for (size_t k = 0; k < points.size(); k++)
    for (int a = 0; a < 3; a++) column_[size_t(a)] += shape.slope[k][a] * points[k];
  for (size_t a = 0; a < 3; a++) across_[a] = glm::cross(column_[(a + 1) % 3], column_[(a + 2) % 3]);
  determinant_ = glm::dot(column_[0], across_[0]);
}

bool Jacobian::isRegular() const { return determinant_ != 0 && std::isfinite(1 / determinant_); }

glm::dvec3 Jacobian::inReference(glm::dvec3 step) const {
  return glm::dvec3(glm::dot(across_[0], step), glm::dot(across_[1], step), glm::dot(across_[2], step)) /
         determinant_;
}

glm::dvec3 Jacobian::inSpace(glm::dvec3 d) const {
  return (d.x * across_[0] + d.y * across_[1] + d.z * across_[2]) / determinant_;
}

double Jacobian::inverseNorm() const {
  double squares = 0;
  for (const glm::dvec3& a : across_) squares += glm::dot(a, a);
  return std::sqrt(squares) / std::abs(determinant_);
}

glm::dvec3 derivativesOf(const ShapeFunctions& shape, const OfCorners& values) {
  glm::dvec3 sum(0);
  for (size_t k = 0; k < 8; k++) sum += shape.slope[k] * values[k];
  return sum;
}

std::optional<MapInverse> invert(CellType type, std::span<const glm::dvec3> points, glm::dvec3 target,
                                 glm::dvec3 guess, double slack) {
  double size = largest(target);
  for (const glm::dvec3& p : points) size = std::max(size, largest(p));
  const double floor = 4 * kEpsilon * size;
  glm::dvec3 place = near(type, guess);
  ShapeFunctions shape = shapeAt(type, place);
  glm::dvec3 missing = target - shape.mean(points);
  double noise = 0;
  for (int i = 0; i < 60; i++) {
    const Jacobian jacobian(shape, points);
    if (!jacobian.isRegular()) break;
    noise = floor * jacobian.inverseNorm();
    const glm::dvec3 step = jacobian.inReference(missing);
    if (largest(missing) <= 0.25 * floor || largest(step) <= 0.25 * kEpsilon) break;
    bool nearer = false;
    for (double part = 1; part > 1e-3 && !nearer; part *= 0.5) {
      const glm::dvec3 next = near(type, place + part * step);
      const ShapeFunctions there = shapeAt(type, next);
      const glm::dvec3 still = target - there.mean(points);
      nearer = glm::dot(still, still) < glm::dot(missing, missing);
      if (nearer) place = next, shape = there, missing = still;
      if (!nearer && largest(missing) <= floor) break;
    }
    if (!nearer) break;
  }
  if (!(largest(missing) <= 16 * floor) || !isInside(type, place, slack + noise)) return std::nullopt;
  return MapInverse{place, noise};
}

}  // namespace gxy::reference
