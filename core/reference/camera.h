// SPDX-License-Identifier: Apache-2.0
// From a camera to rays, in double.
#pragma once
#include "core/reference/ray.h"
#include "core/scene/scene.h"

namespace gxy::reference {

/// A camera's orthonormal axes and the size of a pixel.
class View {
 public:
  /// Throws Error when the view direction is zero or parallel to `viewup`, or an image dimension is not
  /// positive.
  explicit View(const Camera& camera);

  /// The ray through image position (x, y) in pixels, (0, 0) the lower left corner of the picture. It starts
  /// at the viewpoint, or for an orthographic camera in the plane through it.
  Ray ray(double x, double y) const;

  /// The world position at an offset (right, up, view) from the eye: where a camera light stands.
  glm::dvec3 position(glm::dvec3 offset) const;

 private:
  glm::dvec3 eye_, right_, up_, view_;
  glm::dvec2 centre_;
  double pixel_;  ///< side of a pixel: in world units for an orthographic camera, else at distance 1
  bool orthographic_;
};

/// Position of ray k (from 0) within its pixel, in [0, 1)^2: point k of the R2 sequence around the centre
/// (Roberts 2018).
glm::dvec2 subpixel(int k);

}  // namespace gxy::reference
