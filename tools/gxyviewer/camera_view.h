// SPDX-License-Identifier: Apache-2.0
// Galaxy's cameras as VTK's and back, so that VTK's interaction moves them.
#pragma once
#include "core/scene/scene.h"

class vtkCamera;

namespace gxy {

/// Makes `view` look as `camera`. The point it turns about is viewpoint + viewdirection.
void show(const Camera& camera, vtkCamera& view);

/// The camera that looks as `view` in a window of `dimensions`, with the annotation given.
Camera cameraOf(vtkCamera& view, glm::ivec2 dimensions, const std::string& annotation);

}  // namespace gxy
