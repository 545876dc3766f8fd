// SPDX-License-Identifier: Apache-2.0
// found[f * count + i] = fieldProbe(operators[0].map, fields[0], f, ray i), rays being 8 numbers each, for f = the row of the workgroup.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/kernels.glsl"
#include "tests/rays/field_probe.h"

layout(std430, set = LANE_SET, binding = 0) readonly buffer Rays { float rays[]; };
layout(std430, set = LANE_SET, binding = 1) writeonly buffer Found { float found[]; };

void main() {
  readMapAhead(operators[0].map);
  int i = int(gl_GlobalInvocationID.x), f = int(gl_WorkGroupID.y), count = push[0];
  if (i >= count) return;
  ProbeRay r;
  r.o = vec3(rays[8 * i], rays[8 * i + 1], rays[8 * i + 2]);
  r.d = vec3(rays[8 * i + 3], rays[8 * i + 4], rays[8 * i + 5]);
  r.a = rays[8 * i + 6];
  r.b = rays[8 * i + 7];
  found[f * count + i] = fieldProbe(operators[0].map, fields[0], f, r);
}
