// SPDX-License-Identifier: Apache-2.0
// Emission and absorption through the one volume that a scene renders.
#include "kernel.isph"

export void integrateRays(const void* uniform scene, void* uniform rays, uniform int n, uniform int op, uniform int64 counts[]) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  VOLUME v = s.field[op];
  MarchCount count;
  count.samples = 0;
  count.macrocells = 0;
  count.skipped = 0;
  foreach (i = 0 ... n) {
    vec3 o = originOf(r, i), d = directionOf(r, i);
    float clip0, clip1;
    clipInterval(v, o, d, clip0, clip1);
    VolumeRay ray = volumeRay(v, o, d, clip0, clip1);
    MarchRange m;
    m.tIn = r.tIn[i];
    m.tOut = r.tOut[i];
    float own = m.tOut;
    m.tOwn = nextPartition(s, o, d, own, r.tEnd[i]) == END_DONE ? NO_HIT : own;
    m.tStart = r.tLast[i];
    m.tStop = min(r.tHit[i], r.tMax[i]);
    m.tMin = s.tMin;
    Radiance L;
    L.rgb = make_v3(r.r[i], r.g[i], r.b[i]);
    L.A = r.A[i];
    float begun = r.tBegun[i];
    integrateVolume(v, ray, m, begun, L, count);
    r.tBegun[i] = begun;
    r.r[i] = L.rgb.x;
    r.g[i] = L.rgb.y;
    r.b[i] = L.rgb.z;
    r.A[i] = L.A;
    if (1.0f - L.A < s.tMin) r.hitKind[i] = HIT_NONE;  // nothing behind is seen
  }
  counts[0] += reduce_add((int64)count.samples);
  counts[1] += reduce_add((int64)count.macrocells);
  counts[2] += reduce_add((int64)count.skipped);
}
