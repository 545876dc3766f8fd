// SPDX-License-Identifier: Apache-2.0
// Surfaces in volumes: slices and isosurfaces.
#include "backends/embree/kernel.isph"
#include "core/kernels/export.h"

static inline void takeHit(RAYS r, int i, float t, uniform int kind, uniform int op, int primitive) {
  if (t < r.tHit[i] || (t == r.tHit[i] && op < r.hitOperator[i])) {
    r.tHit[i] = t;
    r.hitKind[i] = kind;
    r.hitOperator[i] = op;
    r.hitPrimitive[i] = primitive;
  }
}

EXPORT void hitSlices(const void* uniform scene, void* uniform rays, uniform int n, uniform int op) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  const uniform OperatorView& view = s.operator_[op];
  VOLUME v = s.field[op];
  foreach (i = 0 ... n) {
    vec3 o = originOf(r, i), d = directionOf(r, i);
    VolumeRay ray = clippedRay(view.clips, v, o, d);
    float tOut = min(r.tOut[i], r.tEnd[i]);
    for (uniform int k = 0; k < view.slices; k++) {
      const uniform float* uniform p = view.slice + 4 * k;
      // A ray from this slice cannot meet it again.
      bool mine = RAY_START(r.info[i]) == START_SLICE && r.start[i] == ((op << 16) | k);
      if (!mine && r.A[i] < 1.0f) {  // the ray is not blocked yet
        float tLast = behindLast(lastHit(s, r, i), op, k);
        float t = hitSlice(v, ray, o, d, make_v3(p[0], p[1], p[2]), p[3], r.tIn[i], tOut, tLast);
        if (t < NO_HIT) takeHit(r, i, t, HIT_SLICE, op, k);
      }
    }
    if (view.every > 0.0f && r.A[i] < 1.0f) {
      float t = hitStep(v, ray, view.every, r.tIn[i], tOut, behindLast(lastHit(s, r, i), op, STEPS));
      if (t < NO_HIT) takeHit(r, i, t, HIT_STEP, op, STEPS);
    }
  }
}

EXPORT void hitIsosurfaces(const void* uniform scene, void* uniform rays, uniform int n, uniform int op,
                           uniform int64 counts[]) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  CLIPS clips = s.operator_[op].clips;
  VOLUME v = s.field[op];
  int cells = 0, skipped = 0;
  foreach (i = 0 ... n) {
    IsoStart start;
    start.index = -1;
    start.from = 0;
    if (RAY_START(r.info[i]) == START_ISOSURFACE && (r.start[i] >> 16) == op) {
      start.index = r.start[i] & 0xffff;
      start.from = RAY_SIDE(r.info[i]) != 0 ? 1 : -1;
    }
    // Nothing to find for a ray that is blocked.
    float tOut = r.A[i] < 1.0f ? min(r.tOut[i], r.tEnd[i]) : -1.0f;
    float tLast = behindLast(lastHit(s, r, i), op, ISOSURFACES);
    IsoHit hit =
      hitIsosurface(clips, v, originOf(r, i), directionOf(r, i), r.tIn[i], tOut, tLast, r.tHit[i], start, cells, skipped);
    if (hit.t < NO_HIT) takeHit(r, i, hit.t, HIT_ISOSURFACE, op, hit.index);
  }
  counts[0] += reduce_add((int64)cells);
  counts[1] += reduce_add((int64)skipped);
}
