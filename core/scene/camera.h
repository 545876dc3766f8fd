// SPDX-License-Identifier: Apache-2.0
// The rays of a camera, in double, in a form that every backend computes bit for bit alike.
#pragma once
#include <glm/vec3.hpp>

#include "core/scene/scene.h"

namespace gxy {

/// A camera as kernels use it, in world coordinates. Pixel coordinates (x, y) run from (0, 0), the window's lower left
/// corner, to (width, height). The centre of pixel (i, j) is (i + 0.5, j + 0.5); row 0 is at the bottom. Kernels evaluate
///     p = (corner + x * du) + y * dv
/// per component in that order without contraction. The ray then is
///     perspective   origin eye, direction p
///     orthographic  origin p,   direction view
/// Directions of perspective rays are not normalised. `view`, du and dv are orthogonal, and `view` has length 1.
struct CameraBasis {
  glm::dvec3 eye{0};
  glm::dvec3 corner{0};     ///< direction (perspective) or origin (orthographic) at (0, 0)
  glm::dvec3 du{0}, dv{0};  ///< change per pixel to the right and up
  glm::dvec3 view{0};
  bool orthographic = false;
};

struct CameraRay {
  glm::dvec3 origin, direction;
};

/// Throws Error with the name of the parameter unless viewpoint, viewdirection and viewup are finite,
/// viewdirection is not zero, aov is 0 or in (0, 180) degrees, height is finite and > 0, both dimensions are
/// in [1, 65536] and the image has at most 2^31 pixels.
void validate(const Camera& camera);

/// Computes the basis, after validate(). `aov` or `height` spans the smaller image dimension. A viewup that
/// is zero, or parallel to viewdirection within 1e-6 radian, is replaced by the axis farthest from
/// viewdirection (ties: x, y, z).
CameraBasis cameraBasis(const Camera& camera);

/// Returns the ray through pixel coordinates (x, y).
inline CameraRay cameraRay(const CameraBasis& basis, double x, double y) {
  const glm::dvec3 p = (basis.corner + x * basis.du) + y * basis.dv;
  return basis.orthographic ? CameraRay{p, basis.view} : CameraRay{basis.eye, p};
}

}  // namespace gxy
