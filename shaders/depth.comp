// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// Computes the distance from the eye, in render space, to the first hit of each pixel's centre ray.
#include "shaders/kernels.glsl"
#include "shaders/rays.glsl"

void main() {
  FrameView f = theFrame;
  if (!hasRay()) return;
  givenPlace = placeOf(GIVEN(shaded));
  if (RAY_SAMPLE_NUMBER(GIVEN(info)) != 0u || !(GIVEN(tLast) < 0.0)) return;
  uint pixel = GIVEN(pixel);
  vec3 o, d;
  double tEnter;
  cameraRay(f, int(pixel % uint(f.width)), int(pixel / uint(f.width)), 0, o, d, tEnter);
  uvec2 distance1 = unpackDouble2x32(tEnter + double(GIVEN(tHit)));
  uint at = DEPTH_WORDS * takePlace(COUNT_DEPTHS);
  depths[at] = pixel;
  depths[at + 1u] = distance1.x;
  depths[at + 2u] = distance1.y;
}
