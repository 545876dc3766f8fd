// SPDX-License-Identifier: Apache-2.0
// Writes where push[0] says, which may be outside the buffer.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/layout.h"

layout(local_size_x = BLOCK_RAYS) in;
layout(std430, set = LANE_SET, binding = 0) writeonly buffer Words { uint words[]; };
layout(push_constant) uniform Place { int place; };

void main() { words[place] = 1u; }
