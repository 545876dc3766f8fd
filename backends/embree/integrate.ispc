// SPDX-License-Identifier: Apache-2.0
// Emission and absorption through the only volume that a scene renders.
#include "backends/embree/kernel.isph"
#include "core/kernels/export.h"

EXPORT void integrateRays(const void* uniform scene, void* uniform rays, uniform int n, uniform int op, uniform int64 counts[]) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  MAP map = s.operator_[op].map;
  CLIPS clips = s.operator_[op].clips;
  VOLUME v = s.field[op];
  MarchCount count = nothingMarched();
  foreach (i = 0 ... n) {
    vec3 o = originOf(r, i), d = directionOf(r, i);
    MarchRange m = marchRange(s, r, i);
    m.tOwnershipEnd = nextBegin(s, o, d, m.tOut, r.tEnd[i]);
    Radiance L = radianceOf(r, i);
    float begun = r.tResume[i];
    integrateVolume(map, v, clippedRay(clips, v, o, d), m, begun, L, count);
    r.tResume[i] = begun;
    setRadiance(s, r, i, L);
  }
  counts[0] += reduce_add((int64)count.samples);
  counts[1] += reduce_add((int64)count.macrocells);
  counts[2] += reduce_add((int64)count.skipped);
  counts[3] += reduce_add((int64)count.segmentsSkipped);
}
