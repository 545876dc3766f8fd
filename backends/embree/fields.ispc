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

// Finds each ray's nearest hit with the isosurfaces of one operator. With anyHit, rays that meet one just
// become opaque (A = 1), as in hitGeometry.
EXPORT void hitIsosurfaces(const void* uniform scene, void* uniform rays, uniform int n, uniform int op,
                           uniform bool anyHit, uniform int64 counts[]) {
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
    bool blocked = r.A[i] >= 1.0f || (anyHit && r.tHit[i] < NO_HIT);
    float tOut = blocked ? -1.0f : min(r.tOut[i], r.tEnd[i]);
    float tLast = behindLast(lastHit(s, r, i), op, ISOSURFACES);
    vec3 o = originOf(r, i), d = directionOf(r, i);
    if (anyHit) {
      IsoHit hit = hitIsosurface(clips, v, o, d, r.tIn[i], tOut, tLast, r.tHit[i], start, true, cells, skipped);
      if (hit.t < NO_HIT) r.A[i] = 1.0f;
    } else {
      IsoHit hit = hitIsosurface(clips, v, o, d, r.tIn[i], tOut, tLast, r.tHit[i], start, false, cells, skipped);
      if (hit.t < NO_HIT) takeHit(r, i, hit.t, HIT_ISOSURFACE, op, hit.index);
    }
  }
  counts[0] += reduce_add((int64)cells);
  counts[1] += reduce_add((int64)skipped);
}
