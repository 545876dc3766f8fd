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

}  // namespace

bool isPassed(const std::array<double, 4>& levels) {
  return std::ranges::max(levels) > 0 && std::ranges::min(levels) <= 0;
}

MeshSurface::MeshSurface(std::vector<LevelCell> cells) : cells_(std::move(cells)) {
  std::vector<Box> boxes;
  for (const LevelCell& cell : cells_) boxes.push_back(boxAround(cell.corners));
  tree_.emplace(boxes);
}

std::optional<MeshCrossing> MeshSurface::crossing(uint32_t cell, const Ray& ray) const {
  const LevelCell& in = cells_[cell];
  const auto passage = passageThrough(in.corners, ray);
  if (!passage) return std::nullopt;
  const auto& [front, back] = *passage;
  const double level0 = front.mean(in.levels), level1 = back.mean(in.levels);
  if ((level0 > 0) == (level1 > 0)) return std::nullopt;
  const double u = level0 / (level0 - level1), value0 = front.mean(in.values), value1 = back.mean(in.values);
  return MeshCrossing{front.t + u * (back.t - front.t), value0 + u * (value1 - value0), cell};
}

std::vector<MeshCrossing> MeshSurface::along(const Ray& ray, Interval range) const {
  std::vector<MeshCrossing> found;
  tree_->traverse(
      ray, range.lo, [&] { return range.hi; },
      [&](uint32_t cell) {
        const auto one = crossing(cell, ray);
        if (one && range.contains(one->t)) found.push_back(*one);
      });
  std::sort(found.begin(), found.end(), [](const MeshCrossing& a, const MeshCrossing& b) {
    return std::tie(a.t, a.cell) < std::tie(b.t, b.cell);
  });
  return found;
}

glm::dvec3 MeshSurface::upwards(uint32_t cell, glm::dvec3 flat) const {
  const auto [volume, gradient] = gradientOf(cells_[cell].corners, cells_[cell].levels);
  const double length = glm::length(gradient);
  if (!(length > 0 && std::isfinite(length))) return flat;
  return (volume < 0 ? -1.0 : 1.0) / length * gradient;
}

double MeshSurface::valueNear(const MeshCrossing& crossing, glm::dvec3 aside) const {
  const LevelCell& cell = cells_[crossing.cell];
  const auto [volume, gradient] = gradientOf(cell.corners, cell.values);
  const double rise = glm::dot(gradient, aside) / volume;
  const auto [low, high] = std::minmax_element(cell.values.begin(), cell.values.end());
  return std::clamp(crossing.value + (std::isfinite(rise) ? rise : 0), *low, *high);
}

}  // namespace gxy::reference
