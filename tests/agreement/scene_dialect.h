// SPDX-License-Identifier: Apache-2.0
// sceneProbe in GLSL.
#pragma once
#include <vector>

#include "core/rays/compiled_frame.h"
#include "core/rays/compiled_scene.h"

namespace gxy::agreement {

/// sceneProbe(..., p, i) of operator op at (op * probes + p) * inputs + i, on the device of Vulkan's tests. The scene is uploaded
/// as the backend does.
std::vector<float> sceneProbesInGlsl(const CompiledScene& scene, const CompiledFrame& frame, int probes,
                                     int inputs);

}  // namespace gxy::agreement
