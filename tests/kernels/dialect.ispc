// SPDX-License-Identifier: Apache-2.0
// out[f * count + i] = probe(f, i). Compiled once for each instruction set, PROBE naming the function.
// clang-format off
#include "core/kernels/dialect.h"
#include "core/kernels/all.h"
#include "core/kernels/philox.h"
#include "core/kernels/random_line.h"
#include "tests/kernels/probe.h"
#include "core/kernels/export.h"
// clang-format on

EXPORT void PROBE(uniform int count, uniform float out[]) {
  for (uniform int f = 0; f < PROBES; f++) {
    foreach (i = 0 ... count) out[f * count + i] = probe(f, (uint)i);
  }
}
