// SPDX-License-Identifier: Apache-2.0
// What a frame adds to its scene: the camera and the lights, in render space.
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
  int firstSample = 0;  ///< the first one's index: another one continues the sequence of sub-pixel positions
  uint32_t number = 0;  ///< continues the ambient-occlusion sequence
  bool depth = false;   ///< hit distances are wanted
  double worldPerRender = 1;
  std::vector<std::array<float, 4>> lights;  ///< 0: directional, x y z of its travel; 1: point, its position
};

CompiledFrame compileFrame(const CompiledScene& scene, const Camera& camera, uint32_t number, bool depth);

}  // namespace gxy
