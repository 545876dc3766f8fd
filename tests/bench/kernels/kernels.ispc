// SPDX-License-Identifier: Apache-2.0
// Loops over core/kernels as the backend compiles them, one function each. Rays are 6 floats apart: origin,
// direction.
#include "core/kernels/dialect.h"
#include "core/kernels/all.h"
#include "core/kernels/cells.h"
#include "backends/embree/map_fetch.isph"
#include "backends/embree/volume_fetch.isph"
#include "core/kernels/fields.h"
#include "core/kernels/export.h"

#define USE_VOLUME(name, p)                                                                \
  const uniform VolumeView* uniform name##Pointer = (const uniform VolumeView* uniform)p; \
  const uniform VolumeView& name = *name##Pointer
#define USE_MAP(name, p)                                                             \
  const uniform MapView* uniform name##Pointer = (const uniform MapView* uniform)p; \
  const uniform MapView& name = *name##Pointer

static inline VolumeRay rayOf(VOLUME v, const uniform float rays[], int i) {
  const uniform float* r = rays + 6 * i;
  return volumeRay(v, make_v3(r[0], r[1], r[2]), make_v3(r[3], r[4], r[5]), 0.0f, 1e30f);
}

// `steps` samples along each ray.
EXPORT void sampleRays(const void* uniform volume, const uniform float rays[], uniform int n,
                       uniform int steps, uniform float out[]) {
  USE_VOLUME(v, volume);
  foreach (i = 0 ... n) {
    VolumeRay r = rayOf(v, rays, i);
    float sum = 0.0f, dt = (r.t1 - r.t0) / steps;
    for (uniform int k = 0; k < steps; k++) sum += sampleAt(v, pointAt(r.g, r.t0 + (k + 0.5f) * dt));
    out[i] = sum;
  }
}

// What a point's index on one axis (0: x) adds to its place in memory. `layout` 0: row by row; 1, 2, 3: in bricks of 2, 4,
// 8 points a side; else in Morton order, for sides of at most 1024 points.
static inline int placeAlong(uniform int layout, uniform int side, uniform int axis, int i) {
  if (layout == 0) return axis == 0 ? i : axis == 1 ? i * side : i * (side * side);
  if (layout <= 3) {
    uniform int bricks = (side + (1 << layout) - 1) >> layout;
    uniform int stride = axis == 0 ? 1 : axis == 1 ? bricks : bricks * bricks;
    return (((i >> layout) * stride) << (3 * layout)) | ((i & ((1 << layout) - 1)) << (axis * layout));
  }
  int x = i;
  x = (x | (x << 16)) & 0x030000ff;
  x = (x | (x << 8)) & 0x0300f00f;
  x = (x | (x << 4)) & 0x030c30c3;
  x = (x | (x << 2)) & 0x09249249;
  return x << axis;
}

// Values for side^3 points, each in its place.
EXPORT void arrangePoints(uniform int side, uniform int layout, uniform float out[]) {
  for (uniform int z = 0; z < side; z++)
    for (uniform int y = 0; y < side; y++)
      foreach (x = 0 ... side)
        out[placeAlong(layout, side, 0, x) + placeAlong(layout, side, 1, y) + placeAlong(layout, side, 2, z)] =
            (float)(x ^ y ^ z);
}

// sampleRays of a volume whose points are arranged so.
EXPORT void sampleArranged(const void* uniform volume, const uniform float points[], uniform int side,
                           uniform int layout, const uniform float rays[], uniform int n, uniform int steps, uniform float out[]) {
  USE_VOLUME(v, volume);
  foreach (i = 0 ... n) {
    VolumeRay r = rayOf(v, rays, i);
    float sum = 0.0f, dt = (r.t1 - r.t0) / steps;
    for (uniform int k = 0; k < steps; k++) {
      vec3 p = pointAt(r.g, r.t0 + (k + 0.5f) * dt);
      ivec3 c = cellAt(v, p);
      int x0 = placeAlong(layout, side, 0, c.x), x1 = placeAlong(layout, side, 0, c.x + 1);
      int y0 = placeAlong(layout, side, 1, c.y), y1 = placeAlong(layout, side, 1, c.y + 1);
      int z0 = placeAlong(layout, side, 2, c.z), z1 = placeAlong(layout, side, 2, c.z + 1);
      CellValues corners = {points[x0 + y0 + z0], points[x1 + y0 + z0], points[x0 + y1 + z0], points[x1 + y1 + z0],
                         points[x0 + y0 + z1], points[x1 + y0 + z1], points[x0 + y1 + z1], points[x1 + y1 + z1]};
      sum += valueIn(corners, fractionOf(c, p));
    }
    out[i] = sum;
  }
}

// The walk that looks for isosurfaces; returns the number of cells.
EXPORT uniform int64 findIsosurface(const void* uniform volume, const uniform float rays[], uniform int n,
                                    uniform float out[]) {
  USE_VOLUME(v, volume);
  int cells = 0, skipped = 0;
  IsoStart start;
  start.index = -1;
  start.from = 0;
  foreach (i = 0 ... n) {
    IsoHit hit = firstIsosurface(v, rayOf(v, rays, i), 0.0f, 1e30f, -1.0f, start, cells, skipped);
    out[i] = hit.t;
  }
  return reduce_add((int64)cells);
}

// Cubics by their Bernstein coefficients, four each.
EXPORT void findRoots(const uniform float cubics[], uniform int n, uniform float out[]) {
  foreach (i = 0 ... n) {
    vec4 b = {cubics[4 * i], cubics[4 * i + 1], cubics[4 * i + 2], cubics[4 * i + 3]};
    RootQuery q;
    q.tIn = 0.0f;
    q.tOut = 1.0f;
    q.tAfter = -1.0f;
    q.from = 0;
    q.start = false;
    q.entry = false;
    Bracket found = firstBracket(b, 0.0f, 0.0f, q);
    out[i] = found.lo > found.hi ? NO_HIT : rootTime(rootIn(b, found), 0.0f, 1.0f);
  }
}

EXPORT void evaluateMap(const void* uniform mapData, const uniform float values[], uniform int n,
                        uniform float out[]) {
  USE_MAP(map, mapData);
  foreach (i = 0 ... n) {
    MapPlace p = mapPlace(map, values[i]);
    MapPiece piece = mapPiece(map, p.k);
    vec3 c = colorAt(piece, p.f);
    out[i] = sigmaAt(piece, p.f) * (c.x + c.y + c.z);
  }
}

// The map's mean between each value and the next, as pre-integrated segments take it.
EXPORT void integrateMap(const void* uniform mapData, const uniform float values[], uniform int n,
                         uniform float out[]) {
  USE_MAP(map, mapData);
  foreach (i = 0 ... n - 1) {
    MapMean mean = meanAlong(map, values[i], values[i + 1]);
    out[i] = mean.sigma + mean.color.x;
  }
}

EXPORT void marchRays(const void* uniform mapData, const void* uniform volume, const uniform float rays[], uniform int n,
                      uniform float out[]) {
  USE_MAP(map, mapData);
  USE_VOLUME(v, volume);
  MarchRange m;
  m.tIn = 0.0f;
  m.tOut = 1e30f;
  m.tOwnershipEnd = 1e30f;
  m.tStart = 0.0f;
  m.tStop = 1e30f;
  m.tMin = 0.0f;
  MarchCount count = nothingMarched();
  foreach (i = 0 ... n) {
    Radiance L;
    L.rgb = make_v3(0.0f, 0.0f, 0.0f);
    L.A = 0.0f;
    float begun = -1.0f;
    integrateVolume(map, v, rayOf(v, rays, i), m, begun, L, count);
    out[i] = L.A;
  }
}

// Every ray against the same `count` primitives, 8 floats each, as a packet meets the primitives of a leaf.
EXPORT void hitBoxes(const uniform float rays[], uniform int n, const uniform float boxes[],
                     uniform int count, uniform float out[]) {
  foreach (i = 0 ... n) {
    const uniform float* r = rays + 6 * i;
    vec3 o = make_v3(r[0], r[1], r[2]), d = make_v3(r[3], r[4], r[5]);
    float nearest = 1e30f;
    for (uniform int k = 0; k < count; k++) {
      const uniform float* uniform b = boxes + 8 * k;
      float t0, t1;
      if (boxSpan(make_v3(b[0], b[1], b[2]), make_v3(b[4], b[5], b[6]), o, d, 0.0f, nearest, t0, t1))
        nearest = t0;
    }
    out[i] = nearest;
  }
}

EXPORT void hitSpheres(const uniform float rays[], uniform int n, const uniform float spheres[],
                       uniform int count, uniform float out[]) {
  foreach (i = 0 ... n) {
    const uniform float* r = rays + 6 * i;
    vec3 o = make_v3(r[0], r[1], r[2]), d = make_v3(r[3], r[4], r[5]), normal;
    float nearest = 1e30f, t;
    for (uniform int k = 0; k < count; k++) {
      const uniform float* uniform s = spheres + 8 * k;
      if (hitSphere(o, d, make_v3(s[0], s[1], s[2]), s[3], 0.0f, t, normal)) nearest = min(nearest, t);
    }
    out[i] = nearest;
  }
}

EXPORT void hitTubes(const uniform float rays[], uniform int n, const uniform float tubes[],
                     uniform int count, uniform float out[]) {
  foreach (i = 0 ... n) {
    const uniform float* r = rays + 6 * i;
    vec3 o = make_v3(r[0], r[1], r[2]), d = make_v3(r[3], r[4], r[5]);
    float nearest = 1e30f, t, axial;
    vec3 normal;
    for (uniform int k = 0; k < count; k++) {
      const uniform float* uniform p = tubes + 8 * k;
      vec3 a = make_v3(p[0], p[1], p[2]), b = make_v3(p[4], p[5], p[6]);
      if (hitRoundCone(o, d, a, b, p[3], p[7], 0.0f, t, normal, axial)) nearest = min(nearest, t);
    }
    out[i] = nearest;
  }
}

EXPORT void hitTriangles(const uniform float rays[], uniform int n, const uniform float corners[],
                         uniform int count, uniform float out[]) {
  foreach (i = 0 ... n) {
    const uniform float* r = rays + 6 * i;
    vec3 o = make_v3(r[0], r[1], r[2]), d = make_v3(r[3], r[4], r[5]);
    float nearest = 1e30f, t, wb, wc;
    for (uniform int k = 0; k < count; k++) {
      const uniform float* uniform p = corners + 8 * k;
      vec3 a = make_v3(p[0], p[1], p[2]), b = make_v3(p[4], p[5], p[6]), c = make_v3(p[1], p[6], p[0]);
      if (hitTriangle(o, d, a, b, c, 0.0f, t, wb, wc)) nearest = min(nearest, t);
    }
    out[i] = nearest;
  }
}
