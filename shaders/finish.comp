// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// Decides where each traced ray goes: into its pixel, on behind a translucent surface, or to the next
// partition. It also lists the rays that are to be shaded or, in a sampling, that are to record what they have met (sample.comp).
#include "shaders/kernels.glsl"
#include "shaders/rays.glsl"

#define COPY_FIELD(type, name, primary, secondary) \
  if (primary + secondary > 0) RAY_OF(COPY_TO, i, name) = GIVEN(name);

void settle(SceneView s, float opacity) {
  if (1.0 - opacity < s.tMin) countUp(COUNT_ENDED, 1u);
  float A = min(opacity, 1.0);
  if (RAY_KIND(GIVEN(info)) == RAY_PRIMARY)
    deposit(GIVEN(pixel), ivec4(units(GIVEN(r)), units(GIVEN(g)), units(GIVEN(b)), units(A)));
  else
    deposit(GIVEN(pixel), ivec4(-lossOf(GIVEN(sr), A, s.tMin), -lossOf(GIVEN(sg), A, s.tMin), -lossOf(GIVEN(sb), A, s.tMin), 0));
}

#define SAMPLED ((SURFACES & SURFACE_SAMPLED) != 0)

void main() {
  if (!hasRay()) return;
  SceneView s = theScene;
  bool primary = RAY_KIND(GIVEN(info)) == RAY_PRIMARY;
  float A = GIVEN(A);
  int next = END_DONE;
  if (GIVEN(hitKind) != HIT_NONE) {
    if (primary || SAMPLED) {
      uint i = takePlace(COUNT_SHADED);
      RAY_OF(rays, i, shaded) = rayBlock * BLOCK_RAYS + gl_LocalInvocationIndex;
    }
    A = opacityBehind(A, operatorOf(GIVEN(hitOperator)).opacity);
    if (GOES_ON && !(1.0 - A < s.tMin)) next = END_ACTIVE;
    if (SAMPLED) next = END_SURFACE;
  } else if (!(1.0 - A < s.tMin || GIVEN(tOut) >= GIVEN(tEnd))) {
    float t = GIVEN(tOut);
    if (LEAVES) {
      next = nextPartition(s, rayOrigin(), rayDirection(), t, GIVEN(tEnd));
      endStage();
    }
  }
  if (next == END_DONE) {
    if (!SAMPLED) settle(s, A);
  } else if (GOES_ON && next == END_ACTIVE) {
    uint i = primary ? takePlace(COUNT_ACTIVE_PRIMARIES) : takePlace(COUNT_ACTIVE_SECONDARIES);
#define COPY_TO activeRays
    GXY_RAY_FIELDS(COPY_FIELD)
    RAY_OF(activeRays, i, A) = A;
    RAY_OF(activeRays, i, tLast) = GIVEN(tHit);
    RAY_OF(activeRays, i, lastOperator) = GIVEN(hitOperator);
    RAY_OF(activeRays, i, lastPrimitive) = numberOf(GIVEN(hitKind), GIVEN(hitPrimitive));
    RAY_OF(activeRays, i, tResume) = -1.0;
    RAY_OF(activeRays, i, packet) = GIVEN(packet);
    RAY_OF(activeRays, i, step) = 0;
#undef COPY_TO
  } else if (LEAVES && next >= 0) {
    uint i = takePlace(COUNT_LEAVING);
    if (staysHere(next)) {
#define COPY_TO stayingRays
      GXY_RAY_FIELDS(COPY_FIELD)
#undef COPY_TO
      RAY_OF(leavingRays, i, info) = GIVEN(info);
    } else {
#define COPY_TO leavingRays
      GXY_RAY_FIELDS(COPY_FIELD)
#undef COPY_TO
    }
    RAY_OF(leavingRays, i, packet) = GIVEN(packet);
    RAY_OF(leavingRays, i, next) = next;
  }
}
