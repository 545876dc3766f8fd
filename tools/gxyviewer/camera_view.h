// SPDX-License-Identifier: Apache-2.0
// Converts Galaxy's cameras to VTK's and back, so that VTK's interaction can move them.
#pragma once
#include "core/scene/scene.h"

class vtkCamera;

namespace gxy {

/// Sets `view` to `camera`. Its focal point, around which the user rotates it, is viewpoint + viewdirection.
void show(const Camera& camera, vtkCamera& view);

/// Returns the camera for `view` in a window of `dimensions` pixels, with the given annotation.
Camera cameraOf(vtkCamera& view, glm::ivec2 dimensions, const std::string& annotation);

}  // namespace gxy
