// SPDX-License-Identifier: Apache-2.0
// CompiledFrame: what a frame adds to its scene, the camera and the lights, in render space.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "core/rays/compiled_scene.h"
#include "core/scene/camera.h"

namespace gxy {

struct CompiledFrame {
  CameraBasis basis;  ///< lengths in render space
  int width = 0, height = 0;
  int samples = 1;      ///< rays per pixel
  int firstSample = 0;  ///< index of the first sample in the sequence of sub-pixel positions
  uint32_t number = 0;  ///< number in the sequence of ambient-occlusion directions
  bool depth = false;   ///< hit distances are wanted
  double worldPerRender = 1;
  /// Per light: 0 and the unit vector along which a directional light travels, or 1 and the position of a
  /// point light.
  std::vector<std::array<float, 4>> lights;
};

/// Compiles a camera and the scene's lights. Point lights that are very far away become directional.
CompiledFrame compileFrame(const CompiledScene& scene, const Camera& camera, uint32_t number, bool depth);

}  // namespace gxy
