// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// Where each traced ray goes: into its pixel, on behind a translucent surface, or to the next partition.
#include "kernels.glsl"
#include "rays.glsl"

#define COPY_FIELD(type, name, primary, secondary) \
  if (primary + secondary > 0) RAY_OF(COPY_TO, i, name) = RAY(name);

void settle(SceneView s) {
  if (1.0 - RAY(A) < s.tMin) atomicAdd(counts[COUNT_ENDED], 1u);
  float A = min(RAY(A), 1.0);
  if (RAY_KIND(RAY(info)) == RAY_PRIMARY)
    deposit(RAY(pixel), ivec4(units(RAY(r)), units(RAY(g)), units(RAY(b)), units(A)));
  else
    deposit(RAY(pixel), ivec4(-lossOf(RAY(sr), A, s.tMin), -lossOf(RAY(sg), A, s.tMin), -lossOf(RAY(sb), A, s.tMin), 0));
}

void main() {
  if (!hasRay()) return;
  SceneView s = theScene;
  int next = END_DONE;
  if (RAY(hitKind) != HIT_NONE) {
    // primaries have been shaded; secondaries lose the surface's share
    if (RAY_KIND(RAY(info)) != RAY_PRIMARY) RAY(A) = opacityBehind(RAY(A), operators[RAY(hitOperator)].opacity);
    RAY(tLast) = RAY(tHit);
    RAY(tBegun) = -1.0;
    if (!(1.0 - RAY(A) < s.tMin)) next = END_ACTIVE;
  } else if (!(1.0 - RAY(A) < s.tMin || RAY(tOut) >= RAY(tEnd))) {
    float t = RAY(tOut);
    next = nextPartition(s, rayOrigin(), rayDirection(), t, RAY(tEnd));
  }
  if (next == END_DONE) {
    settle(s);
  } else if (next == END_ACTIVE) {
    bool primary = RAY_KIND(RAY(info)) == RAY_PRIMARY;
    uint i = atomicAdd(counts[primary ? COUNT_ACTIVE_PRIMARIES : COUNT_ACTIVE_SECONDARIES], 1u);
#define COPY_TO activeRays
    GXY_RAY_FIELDS(COPY_FIELD)
    RAY_OF(activeRays, i, packet) = RAY(packet);
    RAY_OF(activeRays, i, step) = 0;
#undef COPY_TO
  } else {
    uint i = atomicAdd(counts[COUNT_LEAVING], 1u);
#define COPY_TO leavingRays
    GXY_RAY_FIELDS(COPY_FIELD)
#undef COPY_TO
    RAY_OF(leavingRays, i, packet) = RAY(packet);
    RAY_OF(leavingRays, i, next) = next;
  }
}
