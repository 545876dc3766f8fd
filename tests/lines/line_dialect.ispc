// SPDX-License-Identifier: Apache-2.0
// out[f * count + i] = lineProbe(f, i). Compiled once for each instruction set, PROBE naming the function.
// clang-format off
#include "core/kernels/dialect.h"
#include "core/kernels/all.h"
#include "core/kernels/trilinear.h"
#include "core/kernels/cubic.h"
#include "core/kernels/lines.h"
#include "tests/lines/line_probe.h"
#include "core/kernels/export.h"
// clang-format on

EXPORT void PROBE(uniform int count, uniform float out[]) {
  for (uniform int f = 0; f < LINE_PROBES; f++) {
    foreach (i = 0 ... count) out[f * count + i] = lineProbe(f, (uint)i);
  }
}
