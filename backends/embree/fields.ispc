// SPDX-License-Identifier: Apache-2.0
// Surfaces in volumes: slices and isosurfaces.
#include "kernel.isph"

static inline void takeHit(RAYS r, int i, float t, uniform int kind, uniform int op, int primitive) {
  if (t < r.tHit[i] || (t == r.tHit[i] && op < r.hitOperator[i])) {
    r.tHit[i] = t;
    r.hitKind[i] = kind;
    r.hitOperator[i] = op;
    r.hitPrimitive[i] = primitive;
  }
}

export void hitSlices(const void* uniform scene, void* uniform rays, uniform int n, uniform int op) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  const uniform OperatorView& view = s.operator_[op];
  VOLUME v = s.field[op];
  foreach (i = 0 ... n) {
    vec3 o = originOf(r, i), d = directionOf(r, i);
    float clip0, clip1;
    clipInterval(v, o, d, clip0, clip1);
    VolumeRay ray = volumeRay(v, o, d, clip0, clip1);
    float tOut = min(r.tOut[i], r.tEnd[i]);
    for (uniform int k = 0; k < view.slices; k++) {
      const uniform float* uniform p = view.slice + 4 * k;
      float along = (p[0] * d.x + p[1] * d.y) + p[2] * d.z;
      float t = (p[3] - ((p[0] * o.x + p[1] * o.y) + p[2] * o.z)) / along;
      bool mine = RAY_START(r.info[i]) == START_SLICE && r.start[i] == ((op << 16) | k);  // a line meets a plane once
      if (abs(along) > 1e-20f && !mine && t >= r.tIn[i] && t < tOut && t > r.tLast[i] && t >= ray.t0 && t <= ray.t1) {
        float value = sampleAt(v, pointAt(ray.g, t));
        if (value - value == 0.0f) takeHit(r, i, t, HIT_SLICE, op, k);
      }
    }
  }
}

export void hitIsosurfaces(const void* uniform scene, void* uniform rays, uniform int n, uniform int op,
                           uniform int64 counts[]) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  VOLUME v = s.field[op];
  int cells = 0, skipped = 0;
  foreach (i = 0 ... n) {
    vec3 o = originOf(r, i), d = directionOf(r, i);
    float clip0, clip1;
    clipInterval(v, o, d, clip0, clip1);
    VolumeRay ray = volumeRay(v, o, d, 0.0f, 1e30f);
    IsoStart start;
    start.index = -1;
    start.from = 0;
    if (RAY_START(r.info[i]) == START_ISOSURFACE && (r.start[i] >> 16) == op) {
      start.index = r.start[i] & 0xffff;
      start.from = RAY_SIDE(r.info[i]) != 0 ? 1 : -1;
    }
    float tOut = min(min(r.tOut[i], r.tEnd[i]), r.tHit[i] * 1.0000005f);
    // a hit on the clip plane itself is kept: the interval is closed there
    float tIn = max(r.tIn[i], clip0);
    IsoHit hit = firstIsosurface(v, ray, tIn, min(tOut, asReal(asUint(max(clip1, 0.0f)) + 1)), r.tLast[i], start, cells, skipped);
    if (hit.t < NO_HIT && hit.t < min(r.tOut[i], r.tEnd[i])) takeHit(r, i, hit.t, HIT_ISOSURFACE, op, hit.index);
  }
  counts[0] += reduce_add((int64)cells);
  counts[1] += reduce_add((int64)skipped);
}
