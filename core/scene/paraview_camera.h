// SPDX-License-Identifier: Apache-2.0
// Reads ParaView camera files: the .pvcc XML that ParaView's "Configure camera" dialog saves, and its
// conversion to JSON.
#pragma once
#include <string>
#include <string_view>

#include "core/scene/scene.h"

namespace gxy {

/// Reads either form; JSON starts with `{`. The text has PVCameraConfiguration / Proxy / Property elements.
/// CameraPosition, CameraFocalPoint and CameraViewUp are required; CameraViewAngle, CameraParallelProjection
/// and CameraParallelScale are optional. A parallel projection becomes aov 0 with its height. Throws Error
/// with `sourceName` and what is missing.
Camera parseParaViewCamera(std::string_view text, const std::string& sourceName);

}  // namespace gxy
