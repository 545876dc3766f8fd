// SPDX-License-Identifier: Apache-2.0
// out[f * count + i] = fieldProbe(map, view, f, ray i), rays being 8 numbers each. Compiled once for each instruction set, PROBE
// naming the function.
// clang-format off
#include "core/kernels/dialect.h"
#include "core/kernels/all.h"
#include "core/kernels/cells.h"
#include "backends/embree/map_fetch.isph"
#include "backends/embree/volume_fetch.isph"
#include "core/kernels/fields.h"
#include "tests/rays/field_probe.h"
#include "core/kernels/export.h"
// clang-format on

EXPORT void PROBE(const void* uniform map, const void* uniform view, uniform int count, const uniform float rays[],
                  uniform float out[]) {
  const uniform MapView* uniform m = (const uniform MapView* uniform)map;
  const uniform VolumeView* uniform v = (const uniform VolumeView* uniform)view;
  for (uniform int f = 0; f < FIELD_PROBES; f++) {
    foreach (i = 0 ... count) {
      ProbeRay r;
      r.o = make_v3(rays[8 * i], rays[8 * i + 1], rays[8 * i + 2]);
      r.d = make_v3(rays[8 * i + 3], rays[8 * i + 4], rays[8 * i + 5]);
      r.a = rays[8 * i + 6];
      r.b = rays[8 * i + 7];
      out[f * count + i] = fieldProbe(*m, *v, f, r);
    }
  }
}
