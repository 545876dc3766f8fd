// SPDX-License-Identifier: Apache-2.0
#include "core/scene/camera.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>

#include "core/comm/error.h"

namespace gxy {
namespace {

bool finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
double largestComponent(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// Scales the vector first, so that vectors as short as 1e-300 or as long as 1e300 keep their direction.
/// `v` is not zero.
glm::dvec3 normalized(const glm::dvec3& v) {
  const glm::dvec3 scaled = v / largestComponent(v);
  return scaled / std::sqrt(glm::dot(scaled, scaled));
}

glm::dvec3 farthestAxis(const glm::dvec3& view) {
  int axis = 0;
  for (int i = 1; i < 3; ++i) {
    if (std::abs(view[i]) < std::abs(view[axis])) axis = i;
  }
  glm::dvec3 out{0};
  out[axis] = 1;
  return out;
}

/// Unit vector to the right of the view.
glm::dvec3 rightOf(const glm::dvec3& view, const glm::dvec3& viewup) {
  constexpr double kParallel = 1e-6;
  if (largestComponent(viewup) > 0) {
    const glm::dvec3 right = glm::cross(view, normalized(viewup));
    if (std::sqrt(glm::dot(right, right)) > kParallel) return normalized(right);
  }
  return normalized(glm::cross(view, farthestAxis(view)));
}

std::string text(const glm::ivec2& d) { return "[" + std::to_string(d.x) + ", " + std::to_string(d.y) + "]"; }

}  // namespace

void validate(const Camera& camera) {
  if (!finite(camera.viewpoint)) throw Error("camera `viewpoint`: expected finite coordinates");
  if (!finite(camera.viewup)) throw Error("camera `viewup`: expected finite components");
  if (!finite(camera.viewdirection) || largestComponent(camera.viewdirection) == 0) {
    throw Error(
        "camera `viewdirection`: expected a finite vector that is not zero (viewcenter is not viewpoint)");
  }
  if (camera.aov != 0 && !(camera.aov > 0 && camera.aov < 180)) {
    throw Error("camera `aov`: expected degrees above 0 and below 180, or 0 for orthographic, found " +
                std::to_string(camera.aov));
  }
  if (!(camera.height > 0 && std::isfinite(camera.height))) {
    throw Error("camera `height`: expected a number > 0, found " + std::to_string(camera.height));
  }
  constexpr int kLargestDimension = 65536;
  constexpr int64_t kMostPixels = int64_t{1} << 31;
  const auto [lo, hi] = std::minmax(camera.dimensions.x, camera.dimensions.y);
  if (lo < 1 || hi > kLargestDimension || int64_t{lo} * hi > kMostPixels) {
    throw Error(
        "camera `dimensions`: expected [width, height] of 1 to 65536 each and at most 2^31 pixels, found " +
        text(camera.dimensions));
  }
}

CameraBasis cameraBasis(const Camera& camera) {
  validate(camera);
  CameraBasis basis;
  basis.orthographic = camera.aov == 0;
  basis.eye = camera.viewpoint;
  basis.view = normalized(camera.viewdirection);
  const glm::dvec3 right = rightOf(basis.view, camera.viewup);
  const glm::dvec3 up = normalized(glm::cross(right, basis.view));

  const double width = camera.dimensions.x, height = camera.dimensions.y;
  const double extent =
      basis.orthographic ? camera.height : 2 * std::tan(camera.aov * (std::numbers::pi / 180) / 2);
  const double perPixel = extent / std::min(width, height);
  basis.du = right * perPixel;
  basis.dv = up * perPixel;
  const glm::dvec3 centre = basis.orthographic ? basis.eye : basis.view;
  basis.corner = centre - basis.du * (width / 2) - basis.dv * (height / 2);
  return basis;
}

}  // namespace gxy
