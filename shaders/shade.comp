// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// Shades the hits of primaries (the list that finish.comp makes): what they add to their pixels, and the
// secondary rays that take away what is blocked, each with the partition that it starts in.
#include "shaders/kernels.glsl"
#include "shaders/rays.glsl"

Surface surfaceHit(int op, VolumeView v, vec3 o, vec3 d) {
  OperatorView view = operatorOf(op);
  uint p = GIVEN(hitPrimitive);
  float after = justBefore(GIVEN(tHit));
  Surface surface;
  if ((SURFACES & SURFACE_FIELDS) != 0 && view.kind == KIND_VOLUME)
    surface = fieldSurface(view, v, GIVEN(hitKind), p, o, d, GIVEN(tHit));
  if ((SURFACES & SURFACE_PARTICLES) != 0 && view.kind == KIND_PARTICLES) surface = sphereSurface(view, p, o, d, after);
  if ((SURFACES & SURFACE_PATHLINES) != 0 && view.kind == KIND_PATHLINES) surface = tubeSurface(view, p, o, d, after);
  if ((SURFACES & SURFACE_TRIANGLES) != 0 && view.kind == KIND_TRIANGLES) surface = triangleSurface(view, p, o, d, after);
  if ((SURFACES & SURFACE_CELLS) != 0 && view.kind == KIND_MESH) surface = cellSurface(view, p, o, d, GIVEN(tHit));
  if ((SURFACES & SURFACE_HEXES) != 0 && view.kind == KIND_HEX_MESH) surface = hexSurface(view, p, o, d, GIVEN(tHit));
  return surfaceSeen(surface, d, view.twoSided != 0);
}

#define SET_SECONDARY(list)                                                              \
  RAY_OF(list, i, pixel) = GIVEN(pixel);                                                   \
  RAY_OF(list, i, info) = RAY_SAMPLE_NUMBER(GIVEN(info)) | (uint(kind) << 16) | startBits;        \
  RAY_OF(list, i, start) = start;                                                        \
  RAY_OF(list, i, ox) = from.x;                                                          \
  RAY_OF(list, i, oy) = from.y;                                                          \
  RAY_OF(list, i, oz) = from.z;                                                          \
  RAY_OF(list, i, dx) = term.toward.x;                                                  \
  RAY_OF(list, i, dy) = term.toward.y;                                                  \
  RAY_OF(list, i, dz) = term.toward.z;                                                  \
  RAY_OF(list, i, tLast) = -1.0;                                                         \
  RAY_OF(list, i, tResume) = -1.0;                                                        \
  RAY_OF(list, i, tMax) = term.reach;                                                   \
  RAY_OF(list, i, A) = 0.0;                                                              \
  RAY_OF(list, i, r) = 0.0;  /* secondaries gather no radiance */                        \
  RAY_OF(list, i, g) = 0.0;                                                              \
  RAY_OF(list, i, b) = 0.0;                                                              \
  RAY_OF(list, i, sr) = term.r;                                                         \
  RAY_OF(list, i, sg) = term.g;                                                         \
  RAY_OF(list, i, sb) = term.b;                                                         \
  RAY_OF(list, i, packet) = GIVEN(packet);

// Adds a secondary ray to the list of rays that start here, which is traced next without the host, or to the
// list of rays that leave.
void addSecondary(SceneView s, LightTerm term, int kind, vec3 from, uint startBits, uint start) {
  int next = firstPartition(s, from, term.toward, min(domainExit(s, from, term.toward), term.reach));
  if (next < 0) return;  // the ray leaves the visible domain at once
  countUp(COUNT_MADE, 1u);
  if (next == push[PUSH_PARTITION]) {
    uint i = takePlace(COUNT_HERE);
    SET_SECONDARY(hereRays)
    RAY_OF(hereRays, i, step) = 0;
  } else if (LEAVES) {
    uint i = takePlace(COUNT_LEAVING);
    if (staysHere(next)) {
      SET_SECONDARY(stayingRays)
      RAY_OF(leavingRays, i, info) = uint(kind) << 16;
      RAY_OF(leavingRays, i, packet) = GIVEN(packet);
    } else {
      SET_SECONDARY(leavingRays)
    }
    RAY_OF(leavingRays, i, next) = next;
  }
}

void main() {
  SceneView s = theScene;
  FrameView f = theFrame;
  if (!hasRay()) return;
  givenPlace = placeOf(GIVEN(shaded));
  int op = GIVEN(hitOperator);
  VolumeView v = fieldOf(op);
  vec3 o = rayOrigin(), d = rayDirection();
  Surface surface = surfaceHit(op, v, o, d);
  OperatorView view = operatorOf(op);
  vec3 color = surfaceColor(view, surface);
  float opacity = view.opacity;
  float weight = (1.0 - GIVEN(A)) * opacity;
  vec3 toEye = vec3(-d.x, -d.y, -d.z);
  vec3 from = offsetOrigin(surface.point, surface.geometric, surface.size);
  uint start = (uint(op) << 16) | GIVEN(hitPrimitive);
  ivec4 sum = ivec4(0);
  int rayCount = f.lights + max(s.occlusionRays, 1);
  for (int q = 0; q < rayCount; q++) {
    LightTerm term = lightTermOf(s, f, q, surface, from, toEye, color, opacity, weight, GIVEN(pixel), RAY_SAMPLE_NUMBER(GIVEN(info)));
    limitLightTerm(term, sum.x, sum.y, sum.z);
    sum += ivec4(term.r, term.g, term.b, 0);
    if ((SURFACES & SURFACE_CASTS) != 0 && term.wanted)
      addSecondary(s, term, q < f.lights ? RAY_SHADOW : RAY_OCCLUSION, startOf(term, surface, from), startBitsOf(term, surface), start);
  }
  deposit(GIVEN(pixel), sum);
  endStage();
}
