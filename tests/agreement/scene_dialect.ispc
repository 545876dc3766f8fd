// SPDX-License-Identifier: Apache-2.0
// out[p * count + i] = sceneProbe(..., p, i) of operator `op`. Compiled once for each instruction set, PROBE naming the function.
// clang-format off
#include "core/kernels/dialect.h"
#include "core/kernels/all.h"
#include "core/kernels/cells.h"
#include "backends/embree/map_fetch.isph"
#include "backends/embree/volume_fetch.isph"
#include "core/kernels/fields.h"
#include "core/rays/ray_fields.h"
#include "core/kernels/scene_view.h"
#include "core/kernels/scene_fetch.h"
#include "core/kernels/scene.h"
#include "tests/agreement/scene_probe.h"
#include "core/kernels/export.h"
// clang-format on

EXPORT void PROBE(const void* uniform scene, const void* uniform frame, uniform int op, const uniform int list[],
                  uniform int volumes, uniform int count, uniform float out[]) {
  const uniform SceneView* uniform s = (const uniform SceneView* uniform)scene;
  const uniform FrameView* uniform f = (const uniform FrameView* uniform)frame;
  for (uniform int p = 0; p < SCENE_PROBES; p++) {
    foreach (i = 0 ... count)
      out[p * count + i] = sceneProbe(*s, *f, s->operator_[op], s->field[op], list, volumes, p, (uint)i);
  }
}
