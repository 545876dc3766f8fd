// SPDX-License-Identifier: Apache-2.0
// Emission and absorption through several volumes at once.
//
// In each macrocell each volume has equal segments of its plan (volume.h), with constant extinction and colour; where they
// overlap, extinction and source add over the merged segments (numerics.md section 3). A merged segment belongs to the
// partition that contains its end. What a volume has in a segment is a function of that segment alone, so the partition
// behind a border finds the same numbers again.
//
// Each dialect supplies VOLUMES, a list of the operators that are volume rendered, VOLUME_AT(s, list, k), its k-th volume,
// and holdsSamples(v), whether this partition has it.

#define MANY_VOLUMES 8

// Where a ray is in one volume: segment [a, b) of the macrocell's `count`, with its extinction and source.
struct Cursor {
  VolumeRay ray;
  MacroWalk walk;
  real tb, dt, count, index;  // of the macrocell: end, segment length, number of segments, segment
  real b;                     // end of the current segment; NO_HIT behind the volume
  real sigma;
  vec3 source;
};

FN real segmentEnd(Cursor c) {
  return c.index + R(1.0) < c.count ? c.walk.t + (c.index + R(1.0)) * c.dt : c.tb;
}

// Sets up the macrocell that the walk is in.
FN void enterMacrocell(VOLUME v, INOUT(Cursor) c) {
  int plan = planAt(v, c.walk.index);
  c.tb = min(min3(c.walk.far), c.ray.t1);
  c.index = R(0.0);
  c.count = R(1.0);
  // pre-integrated segments are not cut further here, neither at cell faces nor where their front hides their back
  if (plan != 0) {
    real n = (c.tb - c.walk.t) * c.ray.cells / planStep(plan);
    if (!byMidpoints(plan)) n = R(4.0) * n;
    c.count = max(floor(n + R(0.5)), R(1.0));
  }
  c.dt = (c.tb - c.walk.t) / c.count;
}

// Evaluates the current segment.
FN void evaluateSegment(VOLUME v, INOUT(Cursor) c, INOUT(int) samples) {
  c.b = segmentEnd(c);
  c.sigma = R(0.0);
  c.source = make_v3(R(0.0), R(0.0), R(0.0));
  int plan = planAt(v, c.walk.index);
  if (plan != 0) {
    real a = c.index > R(0.0) ? c.walk.t + c.index * c.dt : c.walk.t;
    samples += 1;
    if (someByCells(v) && !byMidpoints(plan)) {
      real s0 = sampleAt(v, pointAt(c.ray.g, a)), s1 = sampleAt(v, pointAt(c.ray.g, c.b));
      if (!((s0 - s0) + (s1 - s1) ==
            R(0.0))) {  // an end on the face of the macrocell was looked up behind it
        s0 = sampleAt(v, pointAt(c.ray.g, R(0.5) * (a + c.b)));
        s1 = s0;
      }
      if (s0 - s0 == R(0.0)) {
        MapMean m = meanAlong(v, s0, s1);
        c.sigma = m.sigma;
        c.source = make_v3(m.sigma * m.color.x, m.sigma * m.color.y, m.sigma * m.color.z);
      }
    } else {
      real s = sampleAt(v, pointAt(c.ray.g, R(0.5) * (a + c.b)));
      if (s - s == R(0.0)) {
        MapPlace p = mapPlace(v, s);
        MapPiece m = mapPiece(v, p.k);
        c.sigma = sigmaAt(m, p.f);
        vec3 color = colorAt(m, p.f);
        c.source = make_v3(c.sigma * color.x, c.sigma * color.y, c.sigma * color.z);
      }
    }
  }
}

// No segment: up to `b` there is nothing.
FN void evaluateNothing(INOUT(Cursor) c, real b) {
  c.b = b;
  c.sigma = R(0.0);
  c.source = make_v3(R(0.0), R(0.0), R(0.0));
}

// The segment that ends after t; before the volume, nothing up to it, with index -1.
FN void seekSegment(VOLUME v, INOUT(Cursor) c, real t, INOUT(int) samples) {
  if (t >= c.ray.t1 || c.ray.t0 >= c.ray.t1) {
    evaluateNothing(c, NO_HIT);
  } else {
    real from = max(t, c.ray.t0);
    c.walk = startMacroWalk(v, c.ray, from);
    enterMacrocell(v, c);
    if (c.walk.t < from && c.dt > R(0.0)) c.index = segmentBehind(from, c.walk.t, c.dt, c.count);
    if (t < c.ray.t0) {
      evaluateNothing(c, c.ray.t0);
      c.index = R(-1.0);
    } else {
      evaluateSegment(v, c, samples);
    }
  }
}

// The segment behind the current one.
FN void nextSegment(VOLUME v, INOUT(Cursor) c, INOUT(int) samples) {
  bool more = true;
  if (c.index + R(1.0) < c.count) {
    c.index += R(1.0);
  } else if (c.b < c.ray.t1) {
    stepMacroWalk(v, c.ray, c.walk);
    enterMacrocell(v, c);
  } else {
    more = false;
  }
  if (more)
    evaluateSegment(v, c, samples);
  else
    evaluateNothing(c, NO_HIT);
}

// Several volumes, count <= MANY_VOLUMES: all that are volume rendered, those that this partition does not hold, too, as a
// merged segment may begin where one of them has ended. m.tStop is also where a light or a radius ends the ray.
FN void integrateMany(SCENE s, VOLUMES list, UNIFORM int count, vec3 o, vec3 d, MarchRange m,
                      INOUT(Radiance) L, INOUT(int) samples) {
  Cursor cursor[MANY_VOLUMES];
  real t = max(max(m.tIn, m.tStart), R(0.0)), end = R(0.0);
  for (UNIFORM int k = 0; k < count; k++) {
    VOLUME v = VOLUME_AT(s, list, k);
    cursor[k].ray = clippedRay(v, o, d);
    if (cursor[k].ray.t0 < cursor[k].ray.t1) end = max(end, cursor[k].ray.t1);
  }
  // A hit exactly at tIn may end a segment that began before it.
  bool go = t <= m.tStop && t < min(end, m.tOut) && R(1.0) - L.A >= m.tMin;
  end = min(end, m.tStop);
  // The merged segment that contains t may begin before it: at the latest earlier segment end of any volume, which is
  // where the partition before stopped.
  real a = t;
  if (go) {
    real begin = R(0.0);
    for (UNIFORM int k = 0; k < count; k++) {
      VOLUME v = VOLUME_AT(s, list, k);
      if (!holdsSamples(v)) {  // not in this partition: all behind it, or all before it
        evaluateNothing(cursor[k], NO_HIT);
      } else {
        seekSegment(v, cursor[k], t, samples);
      }
      real from = R(0.0);
      if (cursor[k].b == NO_HIT)
        from = cursor[k].ray.t1 <= t ? cursor[k].ray.t1 : R(0.0);
      else if (cursor[k].index > R(0.0))
        from = cursor[k].walk.t + cursor[k].index * cursor[k].dt;
      else if (cursor[k].index == R(0.0))
        from = cursor[k].walk.t;
      if (cursor[k].ray.t0 < cursor[k].ray.t1) begin = max(begin, from);
    }
    a = max(begin, m.tStart);
  }
  while (go) {
    real b = m.tStop, sigma = R(0.0);
    vec3 source = make_v3(R(0.0), R(0.0), R(0.0));
    for (UNIFORM int k = 0; k < count; k++) {
      b = min(b, cursor[k].b);
      sigma += cursor[k].sigma;
      source.x += cursor[k].source.x;
      source.y += cursor[k].source.y;
      source.z += cursor[k].source.z;
    }
    if (b > m.tOut) {
      go = false;  // the next partition's
    } else {
      if (sigma > R(0.0) && b > a) {
        real per = R(1.0) / sigma;
        addSegment(L, sigma * (b - a), make_v3(source.x * per, source.y * per, source.z * per), m.tMin);
      }
      a = b;
      if (b >= end || R(1.0) - L.A < m.tMin || b >= m.tOut) go = false;
      for (UNIFORM int k = 0; k < count; k++) {
        VOLUME v = VOLUME_AT(s, list, k);
        if (go && cursor[k].b <= b && holdsSamples(v)) nextSegment(v, cursor[k], samples);
      }
    }
  }
}
