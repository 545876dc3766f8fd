// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// Regenerates origin and direction of primaries that came over the wire.
#include "shaders/kernels.glsl"
#include "shaders/rays.glsl"

void main() {
  FrameView f = theFrame;
  if (!hasRay()) return;
  uint pixel = GIVEN(pixel);
  vec3 o, d;
  double tEnter;
  cameraRay(f, int(pixel % uint(f.width)), int(pixel / uint(f.width)), int(RAY_SAMPLE_NUMBER(GIVEN(info))), o, d, tEnter);
  RAY(ox) = o.x;
  RAY(oy) = o.y;
  RAY(oz) = o.z;
  RAY(dx) = d.x;
  RAY(dy) = d.y;
  RAY(dz) = d.z;
  RAY(tMax) = NO_HIT;
}
