// SPDX-License-Identifier: Apache-2.0
// Emission and absorption through several volumes at once.
#include "backends/embree/kernel.isph"
#include "core/kernels/export.h"

// `volumes` are the `count` operators that are volume rendered, count <= MANY_VOLUMES.
EXPORT void integrateRaysOfVolumes(const void* uniform scene, void* uniform rays, uniform int n,
                                const uniform int volumes[], uniform int count, uniform int64 counts[]) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  MarchCount counted = nothingMarched();
  foreach (i = 0 ... n) {
    Radiance L = radianceOf(r, i);
    integrateVolumes(s, volumes, count, originOf(r, i), directionOf(r, i), marchRange(s, r, i), L, counted);
    setRadiance(s, r, i, L);
  }
  counts[0] += reduce_add((int64)counted.samples);
  counts[1] += reduce_add((int64)counted.macrocells);
  counts[2] += reduce_add((int64)counted.skipped);
}
