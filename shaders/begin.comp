// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// Begins rays of a sampling: finds the first partition of each. Rays that begin in this partition go to the list of rays that
// go on, which is traced next; the others leave, for partitions of any rank. Those that meet no visible partition end.
#include "shaders/kernels.glsl"
#include "shaders/rays.glsl"

#define SET_BEGINNING(list)              \
  RAY_OF(list, i, pixel) = GIVEN(pixel); \
  RAY_OF(list, i, info) = GIVEN(info);   \
  RAY_OF(list, i, start) = GIVEN(start); \
  RAY_OF(list, i, ox) = o.x;             \
  RAY_OF(list, i, oy) = o.y;             \
  RAY_OF(list, i, oz) = o.z;             \
  RAY_OF(list, i, dx) = d.x;             \
  RAY_OF(list, i, dy) = d.y;             \
  RAY_OF(list, i, dz) = d.z;             \
  RAY_OF(list, i, tLast) = -1.0;         \
  RAY_OF(list, i, tResume) = -1.0;       \
  RAY_OF(list, i, tMax) = GIVEN(tMax);   \
  RAY_OF(list, i, A) = 0.0;              \
  RAY_OF(list, i, r) = 0.0;              \
  RAY_OF(list, i, g) = 0.0;              \
  RAY_OF(list, i, b) = 0.0;              \
  RAY_OF(list, i, sr) = GIVEN(sr);       \
  RAY_OF(list, i, sg) = GIVEN(sg);       \
  RAY_OF(list, i, sb) = GIVEN(sb);       \
  RAY_OF(list, i, packet) = GIVEN(packet);

void main() {
  SceneView s = theScene;
  if (!hasRay()) return;
  vec3 o = rayOrigin(), d = rayDirection();
  int next = firstPartition(s, o, d, min(domainExit(s, o, d), GIVEN(tMax)));
  endStage();
  if (next < 0) return;
  if (next == push[PUSH_PARTITION]) {
    uint i = takePlace(COUNT_ACTIVE_SECONDARIES);
    SET_BEGINNING(activeRays)
    RAY_OF(activeRays, i, step) = 0;
  } else if (LEAVES) {
    uint i = takePlace(COUNT_LEAVING);
    if (staysHere(next)) {
      SET_BEGINNING(stayingRays)
      RAY_OF(leavingRays, i, info) = GIVEN(info);
      RAY_OF(leavingRays, i, packet) = GIVEN(packet);
    } else {
      SET_BEGINNING(leavingRays)
    }
    RAY_OF(leavingRays, i, next) = next;
  }
}
