// SPDX-License-Identifier: Apache-2.0
// Shading of hits: the light that they add to their pixels, and the secondary rays that take away blocked
// light (light_terms.h).
#include "backends/embree/kernel.isph"
#include "core/kernels/export.h"

static inline Surface geometrySurface(OPERATOR op, unsigned int p, vec3 o, vec3 d, float t) {
  Surface f;
  float after = justBefore(t);
  if (op.kind == KIND_PARTICLES)
    f = sphereSurface(op, p, o, d, after);
  else if (op.kind == KIND_PATHLINES)
    f = tubeSurface(op, p, o, d, after);
  else if (op.kind == KIND_MESH)
    f = cellSurface(op, p, o, d, t);
  else if (op.kind == KIND_HEX_MESH)
    f = hexSurface(op, p, o, d, t);
  else
    f = triangleSurface(op, p, o, d, after);
  return f;
}

// Computes the surface, colour and opacity that ray i has hit, of operator `op`.
static inline void surfaceHit(SCENE s, RAYS r, uniform int op, int i, vec3 o, vec3 d, Surface& surface, vec3& color, float& opacity) {
  const uniform OperatorView& view = s.operator_[op];
  VOLUME v = s.field[op];
  Surface hit;
  if (view.kind == KIND_VOLUME) {
    hit = fieldSurface(view, v, r.hitKind[i], r.hitPrimitive[i], o, d, r.tHit[i]);
  } else {
    hit = geometrySurface(view, r.hitPrimitive[i], o, d, r.tHit[i]);
  }
  surface = surfaceSeen(hit, d, view.twoSided != 0);
  color = surfaceColor(view, surface);
  opacity = view.opacity;
}

static inline void depositLightTerm(uniform int32 sum[], int k, LightTerm term) {
  sum[4 * k] += term.r;
  sum[4 * k + 1] += term.g;
  sum[4 * k + 2] += term.b;
}

// Shades the hits which[0 ... n) of primaries. `sum` (4 per hit, zeroed by the caller) receives what the
// pixel gains, and the rays' A gains what the surface hides. `out` receives the secondary rays and has room
// for n * (lights + occlusion rays). Returns the number of secondary rays.
EXPORT uniform int shadeHits(const void* uniform scene, const void* uniform frame, void* uniform rays,
                             const uniform int which[], uniform int n, uniform int32 sum[], void* uniform out) {
  USE_SCENE(s, scene);
  USE_FRAME(f, frame);
  USE_RAYS(r, rays);
  USE_RAYS(w, out);
  uniform int made = 0;
  foreach (k = 0 ... n) {
    int i = which[k];
    vec3 o = originOf(r, i), d = directionOf(r, i);
    Surface surface;
    vec3 color;
    float opacity;
    int hitOperator = r.hitOperator[i];
    uniform int op;
    if (reduce_equal(hitOperator, &op))  // the usual case, in which no lane is masked
      surfaceHit(s, r, op, i, o, d, surface, color, opacity);
    else
      foreach_unique (one in hitOperator) surfaceHit(s, r, one, i, o, d, surface, color, opacity);
    float weight = (1.0f - r.A[i]) * opacity;
    r.A[i] = opacityBehind(r.A[i], opacity);
    vec3 toEye = make_v3(-d.x, -d.y, -d.z);
    vec3 from = offsetOrigin(surface.point, surface.geometric, surface.size);
    unsigned int start = ((unsigned int)hitOperator << 16) | r.hitPrimitive[i];

    uniform int rayCount = f.lights + max(s.occlusionRays, 1);
    for (uniform int q = 0; q < rayCount; q++) {
      LightTerm term = lightTermOf(s, f, q, surface, from, toEye, color, opacity, weight, r.pixel[i],
                                   RAY_SAMPLE_NUMBER(r.info[i]));
      limitLightTerm(term, sum[4 * k], sum[4 * k + 1], sum[4 * k + 2]);
      depositLightTerm(sum, k, term);
      uniform int kind = q < f.lights ? RAY_SHADOW : RAY_OCCLUSION;
      if (term.wanted) {
        vec3 origin = startOf(term, surface, from);
        unsigned int bits = startBitsOf(term, surface);
        unsigned int startBits = (bits & (START_ISOSURFACE | START_SLICE) << 18) | (bits & (1 << 20));
        packed_store_active(w.pixel + made, r.pixel[i]);
        packed_store_active(w.info + made, RAY_SAMPLE_NUMBER(r.info[i]) | ((unsigned int)kind << 16) | startBits);
        packed_store_active(w.start + made, start);
        packed_store_active((uniform int* uniform)(w.ox + made), intbits(origin.x));
        packed_store_active((uniform int* uniform)(w.oy + made), intbits(origin.y));
        packed_store_active((uniform int* uniform)(w.oz + made), intbits(origin.z));
        packed_store_active((uniform int* uniform)(w.dx + made), intbits(term.toward.x));
        packed_store_active((uniform int* uniform)(w.dy + made), intbits(term.toward.y));
        packed_store_active((uniform int* uniform)(w.dz + made), intbits(term.toward.z));
        packed_store_active((uniform int* uniform)(w.tLast + made), intbits(-1.0f));
        packed_store_active((uniform int* uniform)(w.tResume + made), intbits(-1.0f));
        packed_store_active((uniform int* uniform)(w.tMax + made), intbits(term.reach));
        packed_store_active((uniform int* uniform)(w.A + made), intbits(0.0f));
        packed_store_active(w.sr + made, term.r);
        packed_store_active(w.sg + made, term.g);
        made += packed_store_active(w.sb + made, term.b);
      }
    }
  }
  return made;
}

// Computes what the pixel of a ray that has ended gains (primaries) or loses (secondaries): 4 numbers per
// ray.
EXPORT void settleRays(const void* uniform scene, void* uniform rays, const uniform int which[], uniform int n, uniform int32 sum[]) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  foreach (k = 0 ... n) {
    int i = which[k];
    float A = min(r.A[i], 1.0f);
    if (RAY_KIND(r.info[i]) == RAY_PRIMARY) {
      sum[4 * k] = units(r.r[i]);
      sum[4 * k + 1] = units(r.g[i]);
      sum[4 * k + 2] = units(r.b[i]);
      sum[4 * k + 3] = units(A);
    } else {
      sum[4 * k] = -lossOf(r.sr[i], A, s.tMin);
      sum[4 * k + 1] = -lossOf(r.sg[i], A, s.tMin);
      sum[4 * k + 2] = -lossOf(r.sb[i], A, s.tMin);
      sum[4 * k + 3] = 0;
    }
  }
}

// Takes rays that hit a surface on behind it, or ends them there. Secondaries lose the surface's share;
// primaries have been shaded. `opacity` is per operator.
EXPORT void passSurfaces(const void* uniform scene, void* uniform rays, uniform int n) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  foreach (i = 0 ... n) {
    if (r.next[i] == END_SURFACE) {
      if (RAY_KIND(r.info[i]) != RAY_PRIMARY) {
        for (uniform int op = 0; op < s.operators; op++)
          if (r.hitOperator[i] == op) {
            r.A[i] = opacityBehind(r.A[i], s.operator_[op].opacity);
          }
      }
      r.tLast[i] = r.tHit[i];
      r.lastOperator[i] = r.hitOperator[i];
      r.lastPrimitive[i] = numberOf(r.hitKind[i], r.hitPrimitive[i]);
      r.tResume[i] = -1.0f;
      r.next[i] = 1.0f - r.A[i] < s.tMin ? END_DONE : END_ACTIVE;
    }
  }
}
