// SPDX-License-Identifier: Apache-2.0
// found[i] = entryOf(case i), cases being 13 numbers each: box, origin, direction, nearest.
#version 450
#extension GL_GOOGLE_include_directive : require
#define GXY_GLSL
#include "shaders/layout.h"
#include "core/kernels/dialect.h"
#include "core/kernels/all.h"
#include "shaders/box_entry.glsl"

layout(constant_id = SPEC_ROUNDS_RIGHT) const bool ROUNDS_RIGHT = false;  // for cmake/MakeShader.cmake

layout(local_size_x = BLOCK_RAYS) in;
layout(std430, set = LANE_SET, binding = 0) readonly buffer Cases { float cases[]; };
layout(std430, set = LANE_SET, binding = 1) writeonly buffer Found { float found[]; };
layout(push_constant) uniform Size { int count; };

vec3 numbers(int k) { return vec3(cases[k], cases[k + 1], cases[k + 2]); }

void main() {
  int i = int(gl_GlobalInvocationID.x);
  if (i >= count) return;
  vec3 d = numbers(13 * i + 9), rd = vec3(perLength(d.x), perLength(d.y), perLength(d.z));
  found[i] = entryOf(numbers(13 * i), numbers(13 * i + 3), numbers(13 * i + 6), rd, 0.0, cases[13 * i + 12]);
}
