// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// Copies rays that the device has kept into the list that is traced.
#include "shaders/kernels.glsl"
#include "shaders/rays.glsl"

#define takenRays RaysAt(pushedAddress(PUSH_TAKEN)).block
#define TAKE_FIELD(type, name, primary, secondary) \
  if (primary + secondary > 0) RAY_OF(rays, i, name) = RAY_OF(takenRays, from, name);

void main() {
  uint k = rayBlock * BLOCK_RAYS + gl_LocalInvocationIndex;
  if (k >= uint(push[PUSH_RAYS])) return;
  uint from = Words(pushedAddress(PUSH_PLACES)).word[k], i = uint(push[PUSH_FIRST]) + k;
  GXY_RAY_FIELDS(TAKE_FIELD)
  RAY_OF(rays, i, packet) = uint(push[PUSH_PACKET]);
  RAY_OF(rays, i, step) = 0;
}
