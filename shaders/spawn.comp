// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// The primary rays of a tile, in its order; `next` is END_DONE where a pixel has none.
#include "kernels.glsl"
#include "rays.glsl"

void main() {
  int i = int(gl_GlobalInvocationID.x);
  int x = push[PUSH_TILE] + tileColumn(i), y = push[PUSH_TILE + 1] + tileRow(i), sampleIndex = push[PUSH_TILE + 4];
  SceneView s = theScene;
  FrameView f = theFrame;
  int next = END_DONE;
  if (x < push[PUSH_TILE + 2] && y < push[PUSH_TILE + 3]) {
    vec3 o, d;
    double tEnter;
    if (cameraRay(f, x, y, sampleIndex, o, d, tEnter)) {
      next = firstPartition(s, o, d, domainExit(s, o, d));
      RAY_OF(leavingRays, i, pixel) = uint(y * f.width + x);
      RAY_OF(leavingRays, i, info) = uint(sampleIndex);
      RAY_OF(leavingRays, i, start) = 0u;
      RAY_OF(leavingRays, i, ox) = o.x;
      RAY_OF(leavingRays, i, oy) = o.y;
      RAY_OF(leavingRays, i, oz) = o.z;
      RAY_OF(leavingRays, i, dx) = d.x;
      RAY_OF(leavingRays, i, dy) = d.y;
      RAY_OF(leavingRays, i, dz) = d.z;
      RAY_OF(leavingRays, i, tLast) = -1.0;
      RAY_OF(leavingRays, i, tBegun) = -1.0;
      RAY_OF(leavingRays, i, tMax) = NO_HIT;
      RAY_OF(leavingRays, i, A) = 0.0;
      RAY_OF(leavingRays, i, r) = 0.0;
      RAY_OF(leavingRays, i, g) = 0.0;
      RAY_OF(leavingRays, i, b) = 0.0;
    }
  }
  RAY_OF(leavingRays, i, next) = next;
}
