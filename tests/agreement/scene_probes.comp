// SPDX-License-Identifier: Apache-2.0
// found[(op * SCENE_PROBES + p) * count + i] = sceneProbe(..., p, i) of operator `op`, for the row op * SCENE_PROBES + p of the
// workgroup; `numbers` says where the list of rendered volumes is, and its length.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/kernels.glsl"
#include "tests/agreement/scene_probe.h"

layout(std430, set = LANE_SET, binding = 0) readonly buffer Numbers { uint numbers[]; };
layout(std430, set = LANE_SET, binding = 1) writeonly buffer Found { float found[]; };

void main() {
  int i = int(gl_GlobalInvocationID.x), row = int(gl_WorkGroupID.y), count = push[0];
  if (i >= count) return;
  int op = row / SCENE_PROBES;
  found[row * count + i] = sceneProbe(theScene, theFrame, operators[op], fields[op], numbers[0], int(numbers[1]),
                                      row % SCENE_PROBES, uint(i));
}
