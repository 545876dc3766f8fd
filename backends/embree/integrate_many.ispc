// SPDX-License-Identifier: Apache-2.0
// Emission and absorption through several volumes at once.
//
// In each macrocell each volume has equal segments of its plan (volume.h), with constant extinction and colour; where they
// overlap, extinction and source add over the merged segments (numerics.md section 3). A merged segment belongs to the
// partition that contains its end. What a volume has in a segment is a function of that segment alone, so the partition
// behind a border finds the same numbers again.
#include "kernel.isph"

#define MANY_VOLUMES 8

// Where a ray is in one volume: segment [a, b) of the macrocell's `count`, with its extinction and source.
struct Cursor {
  VolumeRay ray;
  MacroWalk walk;
  float tb, dt, count, index;  // of the macrocell: end, segment length, number of segments, segment
  float b;                     // end of the current segment; NO_HIT behind the volume
  float sigma;
  vec3 source;
};

static inline float segmentEnd(const Cursor& c) {
  return c.index + 1.0f < c.count ? c.walk.t + (c.index + 1.0f) * c.dt : c.tb;
}

// Sets up the macrocell that the walk is in.
static inline void enterMacrocell(VOLUME v, Cursor& c) {
  int plan = planAt(v, c.walk.index);
  c.tb = min(min3(c.walk.far), c.ray.t1);
  c.index = 0.0f;
  c.count = 1.0f;
  // pre-integrated segments are not cut further here, neither at cell faces nor where their front hides their back
  if (plan != 0) {
    float n = (c.tb - c.walk.t) * c.ray.cells / planStep(plan);
    c.count = max(floor((byMidpoints(plan) ? n : 4.0f * n) + 0.5f), 1.0f);
  }
  c.dt = (c.tb - c.walk.t) / c.count;
}

// Evaluates the current segment.
static inline void evaluate(VOLUME v, Cursor& c, int& samples) {
  c.b = segmentEnd(c);
  c.sigma = 0.0f;
  c.source = make_v3(0.0f, 0.0f, 0.0f);
  int plan = planAt(v, c.walk.index);
  if (plan != 0) {
    float a = c.index > 0.0f ? c.walk.t + c.index * c.dt : c.walk.t;
    samples += 1;
    if (!byMidpoints(plan)) {
      float s0 = sampleAt(v, pointAt(c.ray.g, a)), s1 = sampleAt(v, pointAt(c.ray.g, c.b));
      if (!((s0 - s0) + (s1 - s1) == 0.0f)) {  // an end on the face of the macrocell was looked up behind it
        s0 = sampleAt(v, pointAt(c.ray.g, 0.5f * (a + c.b)));
        s1 = s0;
      }
      if (s0 - s0 == 0.0f) {
        MapMean m = meanAlong(v, s0, s1);
        c.sigma = m.sigma;
        c.source = make_v3(m.sigma * m.color.x, m.sigma * m.color.y, m.sigma * m.color.z);
      }
    } else {
      float s = sampleAt(v, pointAt(c.ray.g, 0.5f * (a + c.b)));
      if (s - s == 0.0f) {
        MapPlace p = mapPlace(v, s);
        MapPiece m = mapPiece(v, p.k);
        c.sigma = sigmaAt(m, p.f);
        vec3 color = colorAt(m, p.f);
        c.source = make_v3(c.sigma * color.x, c.sigma * color.y, c.sigma * color.z);
      }
    }
  }
}

// The segment that ends after t.
static inline void seek(VOLUME v, Cursor& c, float t, int& samples) {
  if (t >= c.ray.t1 || c.ray.t0 >= c.ray.t1) {
    c.b = NO_HIT;
    c.sigma = 0.0f;
    c.source = make_v3(0.0f, 0.0f, 0.0f);
  } else if (t < c.ray.t0) {
    c.b = c.ray.t0;  // nothing, up to the volume
    c.index = -1.0f;
    c.sigma = 0.0f;
    c.source = make_v3(0.0f, 0.0f, 0.0f);
  } else {
    c.walk = startMacroWalk(v, c.ray, t);
    enterMacrocell(v, c);
    if (c.walk.t < t && c.dt > 0.0f) {
      float i = clamp(floor((t - c.walk.t) / c.dt), 0.0f, c.count - 1.0f);
      while (i > 0.0f && c.walk.t + i * c.dt > t) i -= 1.0f;
      while (i < c.count - 1.0f && c.walk.t + (i + 1.0f) * c.dt <= t) i += 1.0f;
      c.index = i;
    }
    evaluate(v, c, samples);
  }
}

// The segment behind the current one.
static inline void advance(VOLUME v, Cursor& c, int& samples) {
  float t = c.b;
  if (c.index >= 0.0f && c.index + 1.0f < c.count) {
    c.index += 1.0f;
    evaluate(v, c, samples);
  } else if (c.index >= 0.0f && t < c.ray.t1) {
    stepMacroWalk(v, c.ray, c.walk);
    enterMacrocell(v, c);
    evaluate(v, c, samples);
  } else {
    seek(v, c, t, samples);
  }
}

// volumes[0 ... count): all operators that are volume rendered, count <= MANY_VOLUMES; those that this partition does
// not hold, too, as a merged segment may begin where one of them has ended.
export void integrateMany(const void* uniform scene, void* uniform rays, uniform int n, const uniform int volumes[],
                          uniform int count, uniform int64 counts[]) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  int samples = 0;
  foreach (i = 0 ... n) {
    vec3 o = originOf(r, i), d = directionOf(r, i);
    float tIn = r.tIn[i], tOut = r.tOut[i], tStart = r.tLast[i], tStop = min(r.tHit[i], r.tMax[i]);
    Radiance L;
    L.rgb = make_v3(r.r[i], r.g[i], r.b[i]);
    L.A = r.A[i];
    Cursor cursor[MANY_VOLUMES];
    float t = max(max(tIn, tStart), 0.0f), end = 0.0f;
    for (uniform int k = 0; k < count; k++) {
      VOLUME v = s.field[volumes[k]];
      float clip0, clip1;
      clipInterval(v, o, d, clip0, clip1);
      cursor[k].ray = volumeRay(v, o, d, clip0, clip1);
      if (cursor[k].ray.t0 < cursor[k].ray.t1) end = max(end, cursor[k].ray.t1);
    }
    // A hit exactly at tIn may end a segment that began before it.
    bool go = t <= tStop && t < min(end, tOut) && 1.0f - L.A >= s.tMin;
    end = min(end, tStop);
    // The merged segment that contains t may begin before it: at the latest earlier segment end of any volume, which is
    // where the partition before stopped.
    float a = t;
    if (go) {
      float begin = 0.0f;
      for (uniform int k = 0; k < count; k++) {
        VOLUME v = s.field[volumes[k]];
        if (v.samples == NULL) {  // not in this partition: all behind it, or all before it
          cursor[k].b = NO_HIT;
          cursor[k].sigma = 0.0f;
          cursor[k].source = make_v3(0.0f, 0.0f, 0.0f);
        } else {
          seek(v, cursor[k], t, samples);
        }
        float from = 0.0f;
        if (cursor[k].b == NO_HIT) from = cursor[k].ray.t1 <= t ? cursor[k].ray.t1 : 0.0f;
        else if (cursor[k].index > 0.0f) from = cursor[k].walk.t + cursor[k].index * cursor[k].dt;
        else if (cursor[k].index == 0.0f) from = cursor[k].walk.t;
        if (cursor[k].ray.t0 < cursor[k].ray.t1) begin = max(begin, from);
      }
      a = max(begin, tStart);
    }
    while (go) {
      float b = tStop, sigma = 0.0f;
      vec3 source = make_v3(0.0f, 0.0f, 0.0f);
      for (uniform int k = 0; k < count; k++) {
        b = min(b, cursor[k].b);
        sigma += cursor[k].sigma;
        source.x += cursor[k].source.x;
        source.y += cursor[k].source.y;
        source.z += cursor[k].source.z;
      }
      if (b > tOut) {
        go = false;  // the next partition's
      } else {
        if (sigma > 0.0f && b > a) {
          float inverse = 1.0f / sigma;
          addSegment(L, sigma * (b - a), make_v3(source.x * inverse, source.y * inverse, source.z * inverse), s.tMin);
        }
        a = b;
        if (b >= end || 1.0f - L.A < s.tMin || b >= tOut) go = false;
        for (uniform int k = 0; k < count; k++) {
          VOLUME v = s.field[volumes[k]];
          if (go && cursor[k].b <= b && v.samples != NULL) advance(v, cursor[k], samples);
        }
      }
    }
    r.r[i] = L.rgb.x;
    r.g[i] = L.rgb.y;
    r.b[i] = L.rgb.z;
    r.A[i] = L.A;
    if (1.0f - L.A < s.tMin) r.hitKind[i] = HIT_NONE;
  }
  counts[0] += reduce_add((int64)samples);
}
