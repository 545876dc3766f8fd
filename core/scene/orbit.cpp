// SPDX-License-Identifier: Apache-2.0
#include "core/scene/orbit.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "core/scene/camera.h"

namespace gxy {
namespace {

/// Rotates `v` about a unit axis by degrees, after Rodrigues.
glm::dvec3 rotated(const glm::dvec3& v, const glm::dvec3& axis, double degrees) {
  const double angle = degrees * (std::numbers::pi / 180), cosine = std::cos(angle), sine = std::sin(angle);
  return v * cosine + glm::cross(axis, v) * sine + axis * (glm::dot(axis, v) * (1 - cosine));
}

/// The axis that the camera is turned about: its `viewup`, or what stands for one that is zero or parallel to the view.
glm::dvec3 turningAxis(const Camera& camera, const CameraBasis& basis) {
  const double largest =
      std::max({std::abs(camera.viewup.x), std::abs(camera.viewup.y), std::abs(camera.viewup.z)});
  if (largest > 0) {
    const glm::dvec3 up = glm::normalize(camera.viewup / largest);
    if (glm::length(glm::cross(basis.view, up)) > 1e-6) return up;
  }
  return glm::normalize(basis.dv);
}

}  // namespace

Camera orbited(Camera camera, double phi, double theta, const glm::dvec3& center) {
  const CameraBasis basis = cameraBasis(camera);
  if (phi == 0 && theta == 0) return camera;
  const glm::dvec3 up = turningAxis(camera, basis), right = glm::normalize(basis.du);
  const auto turned = [&](const glm::dvec3& v) { return rotated(rotated(v, right, -theta), up, phi); };
  camera.viewpoint = center + turned(camera.viewpoint - center);
  camera.viewdirection = turned(camera.viewdirection);
  camera.viewup = turned(up);
  return camera;
}

}  // namespace gxy
