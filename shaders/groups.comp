// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// How many workgroups the next stages take for a list whose length only the device knows.
#include "kernels.glsl"
#include "rays.glsl"

void main() {
  if (gl_GlobalInvocationID.x != 0u) return;
  counts[COUNT_GROUPS] = (counts[~push[PUSH_RAYS]] + uint(BLOCK_RAYS) - 1u) / uint(BLOCK_RAYS);
  counts[COUNT_GROUPS + 1] = 1u;
  counts[COUNT_GROUPS + 2] = 1u;
}
