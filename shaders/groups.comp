// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// Computes how many workgroups the next stages need for a list whose length only the device knows. After a
// step that was cut (resumable.glsl) nothing is done until that step has been resumed; the number of
// workgroups of its own list must stay until then.
#include "shaders/kernels.glsl"
#include "shaders/rays.glsl"

void main() {
  if (gl_GlobalInvocationID.x != 0u || counts[COUNT_CUT] != 0u) return;
  uint rays = counts[~push[PUSH_RAYS]], each = uint(BLOCK_RAYS) * GROUP_ROWS;
  counts[COUNT_GROUPS] = (rays + each - 1u) / each * GROUP_ROWS;
  counts[COUNT_GROUPS + 1] = 1u;
  counts[COUNT_GROUPS + 2] = 1u;
}
