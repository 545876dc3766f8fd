// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// Computes where each ray enters and leaves this partition, and sets its hit to none.
#include "shaders/kernels.glsl"
#include "shaders/rays.glsl"

void main() {
  if (!hasRay()) return;
  SceneView s = theScene;
  vec3 o = rayOrigin(), d = rayDirection();
  float tIn, tOut;
  partitionSpan(s, o, d, tIn, tOut);
  RAY(tIn) = tIn;
  RAY(tOut) = tOut;
  RAY(tEnd) = min(domainExit(s, o, d), GIVEN(tMax));
  RAY(tHit) = NO_HIT;
  RAY(hitKind) = HIT_NONE;
}
