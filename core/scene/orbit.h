// SPDX-License-Identifier: Apache-2.0
// Cameras on a sphere around what they look at.
#pragma once
#include <glm/vec3.hpp>

#include "core/scene/scene.h"

namespace gxy {

/// Returns the camera moved around `center`, in world coordinates, as a rigid body. It is first raised by `theta` degrees towards
/// its `viewup`, about its own horizontal axis, and then turned by `phi` degrees about its original `viewup`, counterclockwise
/// for one who looks down that axis. Its distance from `center` stays the same, and so does the place of `center` in the picture,
/// also at the poles. With both angles 0 the camera is returned as it is. Throws Error as validate() does (camera.h).
Camera orbited(Camera camera, double phi, double theta, const glm::dvec3& center);

}  // namespace gxy
