// SPDX-License-Identifier: Apache-2.0
// result[f * count + i] = lineProbe(f, i), for i = the invocation.
#version 450
#extension GL_GOOGLE_include_directive : require
#define GXY_GLSL
#include "shaders/layout.h"
#include "core/kernels/dialect.h"
#include "core/kernels/all.h"
#include "core/kernels/trilinear.h"
#include "core/kernels/cubic.h"
#include "core/kernels/lines.h"
#include "tests/lines/line_probe.h"

layout(constant_id = SPEC_ROUNDS_RIGHT) const bool ROUNDS_RIGHT = false;  // for cmake/MakeShader.cmake

layout(local_size_x = BLOCK_RAYS) in;
layout(std430, set = LANE_SET, binding = 0) buffer Result { float result[]; };
layout(push_constant) uniform Size { int count; };

void main() {
  int i = int(gl_GlobalInvocationID.x);
  if (i >= count) return;
  for (int f = 0; f < LINE_PROBES; f++) result[f * count + i] = lineProbe(f, uint(i));
}
