// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// Finds each ray's nearest hit with the slices of one operator, or with the places at equal distances that a sampling asks for.
#include "shaders/kernels.glsl"
#include "shaders/rays.glsl"

void main() {
  if (!hasRay()) return;
  int op = push[PUSH_OPERATOR];
  VolumeView v = fieldOf(op);
  OperatorView view = operatorOf(op);
  vec3 o = rayOrigin(), d = rayDirection();
  VolumeRay ray = clippedRay(view.clips, v, o, d);
  float tOut = min(GIVEN(tOut), GIVEN(tEnd));
  NearestHit nearest = givenHit();
  LastHit last = lastHit();
  for (int k = 0; k < view.slices; k++) {
    // A ray that starts on this slice cannot meet it again.
    bool mine = RAY_START(GIVEN(info)) == START_SLICE && GIVEN(start) == uint((op << 16) | k);
    if (!mine && GIVEN(A) < 1.0) {  // the ray is not blocked yet
      float offset = tableReal(view.slice + 4u * uint(k) + 3u);
      float tLast = behindLast(last, op, uint(k));
      float t = hitSlice(v, ray, o, d, sliceNormal(view, uint(k)), offset, GIVEN(tIn), tOut, tLast);
      if (t < NO_HIT) takeHit(nearest, t, HIT_SLICE, op, uint(k));
    }
  }
  if (view.every > 0.0 && GIVEN(A) < 1.0) {
    float t = hitStep(v, ray, view.every, GIVEN(tIn), tOut, behindLast(last, op, STEPS));
    if (t < NO_HIT) takeHit(nearest, t, HIT_STEP, op, STEPS);
  }
  endStage();
}
