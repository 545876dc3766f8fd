// SPDX-License-Identifier: Apache-2.0
// Small data for the tests of the reference renderer.
#pragma once
#include <cmath>
#include <cstring>
#include <functional>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>

#include "core/data/bricks.h"
#include "core/reference/reference.h"

namespace gxy::reference {

/// A volume of floats with field(world position) at its samples, whole in partition 0.
inline std::shared_ptr<Volume> makeVolume(const Grid& grid, const std::function<double(glm::dvec3)>& field) {
  auto volume = std::make_shared<Volume>();
  volume->name = "test";
  volume->grid = grid;
  VolumeBlock& block = volume->blocks[0];
  block.extent.points = grid.points;
  block.samples.resize(size_t(block.extent.count()) * sizeof(float));
  std::byte* out = block.samples.data();
  for (int64_t k = 0; k < grid.points[2]; k++) {
    for (int64_t j = 0; j < grid.points[1]; j++) {
      for (int64_t i = 0; i < grid.points[0]; i++) {
        const float value = float(field(grid.origin + grid.spacing * glm::dvec3(i, j, k)));
        std::memcpy(out, &value, sizeof value);
        out += sizeof value;
      }
    }
  }
  putIntoBricks(block.samples, grid.points, sizeof(float));
  return volume;
}

/// n^3 points that span [lo, hi]^3.
inline Grid cube(int64_t n, double lo = -1, double hi = 1) {
  return {glm::dvec3(lo), glm::dvec3((hi - lo) / double(n - 1)), {n, n, n}};
}

/// The test signal of Marschner and Lobb (1994), on [-1, 1]^3.
inline double marschnerLobb(glm::dvec3 p) {
  const double pi = std::numbers::pi, r = std::sqrt(p.x * p.x + p.y * p.y);
  return (1 - std::sin(pi * p.z / 2) + 0.25 * (1 + std::cos(12 * pi * std::cos(pi * r / 2)))) / 2.5;
}

/// A Vis whose every value has one colour.
inline Vis plain(VisType type, glm::dvec3 colour) {
  Vis vis;
  vis.type = type;
  vis.colormap.points = {{0, colour}};
  return vis;
}

/// An orthographic camera of one pixel, whose only ray is the given one.
inline Camera along(glm::dvec3 origin, glm::dvec3 direction) {
  Camera camera;
  camera.viewpoint = origin;
  camera.viewdirection = direction;
  camera.viewup = std::abs(glm::normalize(direction).y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
  camera.aov = 0;
  camera.dimensions = {1, 1};
  return camera;
}

/// Only ambient light, so that a surface shows its colour.
inline Lighting ambientOnly() {
  Lighting lighting;
  lighting.sources.clear();
  lighting.Ka = 1;
  return lighting;
}

/// Repeatable pseudo-random numbers in [0, 1).
class Uniform {
 public:
  explicit Uniform(uint64_t seed) : state_(seed) {}
  double operator()() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return double(state_ >> 11) * 0x1p-53;
  }
  double in(double lo, double hi) { return lo + (hi - lo) * (*this)(); }
  glm::dvec3 inCube(double half) {
    const double x = in(-half, half), y = in(-half, half), z = in(-half, half);
    return {x, y, z};
  }

 private:
  uint64_t state_;
};

}  // namespace gxy::reference
