// SPDX-License-Identifier: Apache-2.0
#include "core/reference/camera.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "core/comm/error.h"

namespace gxy::reference {

View::View(const Camera& camera) : eye_(camera.viewpoint), orthographic_(camera.aov == 0) {
  const glm::ivec2 n = camera.dimensions;
  if (n.x <= 0 || n.y <= 0) throw Error("camera: dimensions must be positive");
  view_ = glm::normalize(camera.viewdirection);
  right_ = glm::normalize(glm::cross(view_, glm::normalize(camera.viewup)));
  if (!(glm::dot(right_, right_) > 0)) {
    throw Error("camera: viewdirection and viewup must be non-zero and not parallel");
  }
  up_ = glm::cross(right_, view_);
  centre_ = 0.5 * glm::dvec2(n);
  const double window = orthographic_ ? camera.height : 2 * std::tan(camera.aov * std::numbers::pi / 360);
  pixel_ = window / std::min(n.x, n.y);
}

Ray View::ray(double x, double y) const {
  const glm::dvec3 across = (x - centre_.x) * pixel_ * right_ + (y - centre_.y) * pixel_ * up_;
  return orthographic_ ? Ray{eye_ + across, view_} : Ray{eye_, glm::normalize(view_ + across)};
}

glm::dvec3 View::position(glm::dvec3 offset) const {
  return eye_ + offset.x * right_ + offset.y * up_ + offset.z * view_;
}

glm::dvec2 subpixel(int k) {
  auto fraction = [](double x) { return x - std::floor(x); };
  return {fraction(0.5 + k * 0.7548776662466927), fraction(0.5 + k * 0.5698402909980532)};
}

}  // namespace gxy::reference
