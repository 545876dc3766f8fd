// SPDX-License-Identifier: Apache-2.0
#include "core/reference/mesh_surface.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <tuple>

namespace gxy::reference {
namespace {

/// The volume of a tetrahedron and the volume times the gradient of what is linear in it, both times six and with the same sign.
struct ScaledGradient {
  double volume;
  glm::dvec3 gradient;
};

ScaledGradient gradientOf(const Tetrahedron& corners, const std::array<double, 4>& values) {
  const glm::dvec3 b = corners[1] - corners[0], c = corners[2] - corners[0], d = corners[3] - corners[0];
  const glm::dvec3 acrossB = glm::cross(c, d), acrossC = glm::cross(d, b), acrossD = glm::cross(b, c);
  return {glm::dot(b, acrossB), (values[1] - values[0]) * acrossB + (values[2] - values[0]) * acrossC +
                                    (values[3] - values[0]) * acrossD};
}

/// The gradient at a place in reference coordinates; not finite where there is none.
glm::dvec3 gradientAt(const BentCell& cell, glm::dvec3 place, const OfCorners& values) {
  const ShapeFunctions shape = shapeAt(cell.type, place);
  return Jacobian(shape, cell.corners()).inSpace(derivativesOf(shape, values));
}

/// The place `aside` from another one, to first order.
glm::dvec3 placeNear(const BentCell& cell, glm::dvec3 place, glm::dvec3 aside) {
  const Jacobian jacobian(shapeAt(cell.type, place), cell.corners());
  return jacobian.isRegular() ? place + jacobian.inReference(aside) : place;
}

}  // namespace

bool isPassed(std::span<const double> levels) {
  return std::ranges::max(levels) > 0 && std::ranges::min(levels) <= 0;
}

MeshSurface::MeshSurface(std::vector<LevelCell> tetrahedra, std::vector<LevelBentCell> others, LevelKind kind)
    : tetrahedra_(std::move(tetrahedra)), others_(std::move(others)), kind_(kind) {
  std::vector<Box> boxes;
  for (const LevelCell& cell : tetrahedra_) boxes.push_back(boxAround(cell.corners));
  for (const LevelBentCell& one : others_) boxes.push_back(boxAround(one.cell.corners()));
  tree_.emplace(boxes);
}

std::vector<MeshCrossing> MeshSurface::crossings(uint32_t cell, const Ray& ray) const {
  if (isBent(cell)) return crossingsOfBent(cell, ray);
  const LevelCell& in = tetrahedra_[cell];
  const auto passage = passageThrough(in.corners, ray);
  if (!passage) return {};
  const auto& [front, back] = *passage;
  const double level0 = front.mean(in.levels), level1 = back.mean(in.levels);
  if ((level0 > 0) == (level1 > 0)) return {};
  const double u = level0 / (level0 - level1), value0 = front.mean(in.values), value1 = back.mean(in.values);
  const double t = front.t + u * (back.t - front.t);
  return {{t, value0 + u * (value1 - value0), cell, ray.at(t)}};
}

std::vector<MeshCrossing> MeshSurface::crossingsOfBent(uint32_t cell, const Ray& ray) const {
  const LevelBentCell& one = bent(cell);
  const CellOnRay on(one.cell, ray);
  std::vector<MeshCrossing> found;
  for (const CellPassage& passage : on.passages()) {
    std::vector<CellRoot> roots;
    if (kind_ == LevelKind::Values) {
      roots = on.roots(passage, one.levels);
    } else {
      const double level0 = passage.in.mean(one.levels), level1 = passage.out.mean(one.levels);
      if ((level0 > 0) == (level1 > 0)) continue;
      const double t = passage.in.t + level0 / (level0 - level1) * (passage.out.t - passage.in.t);
      roots.push_back({t, on.placeAt(passage, t)});
    }
    for (const CellRoot& root : roots)
      found.push_back(
          {root.t, shapeAt(one.cell.type, root.place).mean(one.values), cell, ray.at(root.t), root.place});
  }
  std::ranges::stable_sort(found, {}, &MeshCrossing::t);  // the passages of a tangled cell may overlap
  return found;
}

std::vector<MeshCrossing> MeshSurface::along(const Ray& ray, Interval range) const {
  std::vector<MeshCrossing> found;
  tree_->traverse(
      ray, range.lo, [&] { return range.hi; },
      [&](uint32_t cell) {
        for (const MeshCrossing& one : crossings(cell, ray))
          if (range.contains(one.t)) found.push_back(one);
      });
  std::sort(found.begin(), found.end(), [](const MeshCrossing& a, const MeshCrossing& b) {
    return std::tie(a.t, a.cell) < std::tie(b.t, b.cell);
  });
  return found;
}

glm::dvec3 MeshSurface::upwards(const MeshCrossing& crossing, glm::dvec3 flat, glm::dvec3 aside) const {
  ScaledGradient scaled{};
  if (isBent(crossing.cell)) {
    const LevelBentCell& one = bent(crossing.cell);
    scaled = {1, gradientAt(one.cell, placeNear(one.cell, crossing.place, aside), one.levels)};
  } else {
    const LevelCell& cell = tetrahedra_[crossing.cell];
    scaled = gradientOf(cell.corners, cell.levels);
  }
  const auto [volume, gradient] = scaled;
  const double length = glm::length(gradient);
  if (!(length > 0 && std::isfinite(length))) return flat;
  return (volume < 0 ? -1.0 : 1.0) / length * gradient;
}

glm::dvec3 MeshSurface::smoothUpwards(const MeshCrossing& crossing, glm::dvec3 flat, glm::dvec3 aside) const {
  glm::dvec3 mean(0);
  if (isBent(crossing.cell)) {
    const LevelBentCell& one = bent(crossing.cell);
    const size_t corners = one.cell.corners().size();
    mean = shapeAt(one.cell.type, placeNear(one.cell, crossing.place, aside))
               .mean(std::span(one.gradients).first(corners));
  } else {
    // Of each component the mean is linear, as what has its values at the corners.
    const LevelCell& cell = tetrahedra_[crossing.cell];
    const glm::dvec3 place = crossing.position + aside;
    for (int a = 0; a < 3; a++) {
      std::array<double, 4> component;
      for (size_t k = 0; k < 4; k++) component[k] = cell.gradients[k][a];
      const auto [volume, slope] = gradientOf(cell.corners, component);
      mean[a] = component[0] + glm::dot(slope, place - cell.corners[0]) / volume;
    }
  }
  const double length = glm::length(mean);
  return length > 0 && std::isfinite(length) ? mean / length : flat;
}

double MeshSurface::valueNear(const MeshCrossing& crossing, glm::dvec3 aside) const {
  double rise = 0;
  OfCorners values{};
  size_t corners = 4;
  if (isBent(crossing.cell)) {
    const LevelBentCell& one = bent(crossing.cell);
    corners = one.cell.corners().size();
    values = one.values;
    rise = glm::dot(gradientAt(one.cell, crossing.place, values), aside);
  } else {
    const LevelCell& cell = tetrahedra_[crossing.cell];
    std::copy(cell.values.begin(), cell.values.end(), values.begin());
    const auto [volume, gradient] = gradientOf(cell.corners, cell.values);
    rise = glm::dot(gradient, aside) / volume;
  }
  const auto [low, high] = std::minmax_element(values.begin(), values.begin() + ptrdiff_t(corners));
  return std::clamp(crossing.value + (std::isfinite(rise) ? rise : 0), *low, *high);
}

double MeshSurface::farthest(uint32_t cell) const {
  const auto corners =
      isBent(cell) ? bent(cell).cell.corners() : std::span<const glm::dvec3>(tetrahedra_[cell].corners);
  double largest = 0;
  for (const glm::dvec3& p : corners)
    largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  return largest;
}

}  // namespace gxy::reference
