// SPDX-License-Identifier: Apache-2.0
// The act of a sampling: what is recorded where its rays meet surfaces, and which rays go on behind them.
#include "backends/embree/kernel.isph"
#include "core/kernels/sampling_view.h"
#include "core/kernels/export.h"

#define SAMPLING const uniform SamplingView&

// The value of field f where ray i has met operator `op`.
static inline float fieldMet(SCENE s, SAMPLING w, RAYS r, uniform int f, uniform int op, int i) {
  VOLUME v = w.field[f];
  float value = floatbits(0x7fc00000u);
  if (w.isovalueOf[op * w.fields + f] != 0 && r.hitKind[i] == HIT_ISOSURFACE)
    value = isovalueOf(s.field[op], r.hitPrimitive[i]);
  else if (v.samples != NULL)
    value = valueMet(v, originOf(r, i), directionOf(r, i), r.tHit[i]);
  return value;
}

// Records hit k of n, which ray i has made of operator `op`. Returns its number among the ray's hits; -1 if it does not count.
static inline int recordHit(SCENE s, SAMPLING w, RAYS r, uniform int op, int i, int k, uniform int n, uniform float value[],
                            uniform float gradient[]) {
  for (uniform int f = 0; f < w.fields; f++) value[f * n + k] = fieldMet(s, w, r, f, op, i);
  bool counts = true;
  for (uniform int c = 0; c < w.conditions; c++) {
    if (w.conditionOperator[c] == op) {
      float x = value[w.conditionField[c] * n + k];
      counts = counts && inRange(x, w.conditionRange[2 * c], w.conditionRange[2 * c + 1]);
    }
  }
  if (w.gradient != 0) {
    float none = floatbits(0x7fc00000u);
    vec3 g = make_v3(none, none, none);
    if (s.operator_[op].kind == KIND_VOLUME) {
      VOLUME v = s.field[op];
      g = gradientMet(v, originOf(r, i), directionOf(r, i), r.tHit[i]);
    }
    gradient[3 * k] = g.x;
    gradient[3 * k + 1] = g.y;
    gradient[3 * k + 2] = g.z;
  }
  int hits = RAY_HITS(r.info[i]);
  int number = counts ? hits : -1;
  int hitsNow = counts ? hits + 1 : hits;
  r.info[i] = (r.info[i] & ~0xffffu) | (unsigned int)hitsNow;
  r.next[i] = counts && hitsNow >= w.hits[op] ? END_DONE : END_ACTIVE;
  return number;
}

// Records the hits of rays which[0 ... n): the values of all fields (n of each), gradients (3 per hit, if asked for), and the number
// of the hit on its ray, -1 if it does not count. Takes the rays behind the surfaces; `next` says which of them go on.
EXPORT void sampleHits(const void* uniform scene, const void* uniform sampling, void* uniform rays, const uniform int which[],
                       uniform int n, uniform float value[], uniform float gradient[], uniform int32 hit[]) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  const uniform SamplingView* uniform samplingPointer = (const uniform SamplingView* uniform)sampling;
  SAMPLING w = *samplingPointer;
  foreach (k = 0 ... n) {
    int i = which[k];
    int hitOperator = r.hitOperator[i];
    int number = -1;
    foreach_unique (op in hitOperator) number = recordHit(s, w, r, op, i, k, n, value, gradient);
    hit[k] = number;
    r.tLast[i] = r.tHit[i];
    r.lastOperator[i] = hitOperator;
    r.lastPrimitive[i] = numberOf(r.hitKind[i], r.hitPrimitive[i]);
    r.tResume[i] = -1.0f;
  }
}
