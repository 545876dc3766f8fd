// SPDX-License-Identifier: Apache-2.0
// ParaView camera files: the .pvcc XML that ParaView's "Configure camera" dialog saves, and its conversion to
// JSON.
#pragma once
#include <string>
#include <string_view>

#include "core/scene/scene.h"

namespace gxy {

/// Reads either form (JSON starts with `{`): PVCameraConfiguration / Proxy / Property elements with
/// CameraPosition, CameraFocalPoint, CameraViewUp (all required), CameraViewAngle, CameraParallelProjection
/// and CameraParallelScale; a parallel projection becomes aov 0 with its height. Throws Error naming
/// `sourceName` and what is missing.
Camera parseParaViewCamera(std::string_view text, const std::string& sourceName);

}  // namespace gxy
