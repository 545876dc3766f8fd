// SPDX-License-Identifier: Apache-2.0
// Emission and absorption through several volumes at once.
//
// In each macrocell each volume has equal segments of its plan (volume.h), and counts as what is seen at their middle; or,
// in each cell of one that goes cell by cell, equal segments along which the value is linear, halved where the map is not
// as good as constant over them. Where volumes overlap, extinction and source add over the merged segments (numerics.md
// section 3). A merged segment belongs to the partition that contains its end. What a volume has in a segment is a
// function of that segment alone, so the partition behind a border finds the same numbers again.
//
// Each dialect supplies VOLUMES, a list of the operators that are volume rendered, VOLUME_AT(s, list, k), its k-th volume,
// and holdsSamples(v), whether this partition has it.

#define MANY_VOLUMES 8

// Where a ray is in one volume: part [a, b) of segment `index` of the `count` equal ones of a stretch, with its extinction
// and source. A stretch is the ray in a macrocell, or in a cell of it.
struct Cursor {
  VolumeRay ray;
  MacroWalk walk;
  ivec3 cell;                       // of a macrocell that goes cell by cell
  real from, to, dt, count, index;  // of the stretch: its ends, segment length, number of segments, segment
  bool holds;                       // whether there are data in the segment of a cell, and if so
  real s0, rise;                    // its value at the start, and what that changes by
  real begin, part;  // where the part begins and its length, in segments: multiples of powers of 2
  real a, b;         // ends of the part; b is NO_HIT behind the volume
  real sigma;
  vec3 source;
  // macrocells entered, and skipped of them: here, since counters that the loop carries cost what registers hold
  int entered, skipped;
};

FN bool goesByCells(VOLUME v, int plan) { return someByCells(v) && plan != 0 && !byMidpoints(plan); }
FN real macrocellEnd(Cursor c) { return min(min3(c.walk.far), c.ray.t1); }
FN real segmentStart(Cursor c) { return c.index > R(0.0) ? c.from + c.index * c.dt : c.from; }
FN real segmentEnd(Cursor c) {
  return c.index + R(1.0) < c.count ? c.from + (c.index + R(1.0)) * c.dt : c.to;
}

// Sets up the stretch that t is in, in the macrocell of the walk.
FN void enterStretch(VOLUME v, INOUT(Cursor) c, real t) {
  int plan = planAt(v, c.walk.index);
  put(c.from, c.walk.t);
  put(c.to, macrocellEnd(c));
  if (goesByCells(v, plan)) {
    GridRay g = c.ray.g;
    ivec3 n = gridCells(v);
    put(c.cell,
        make_i3(locateCell(t, g.po.x, g.pd.x, g.rpd.x, n.x), locateCell(t, g.po.y, g.pd.y, g.rpd.y, n.y),
                locateCell(t, g.po.z, g.pd.z, g.rpd.z, n.z)));
    vec3 near = make_v3(planeCrossing(nearPlane(c.cell.x, g.rpd.x), g.po.x, g.rpd.x),
                        planeCrossing(nearPlane(c.cell.y, g.rpd.y), g.po.y, g.rpd.y),
                        planeCrossing(nearPlane(c.cell.z, g.rpd.z), g.po.z, g.rpd.z));
    vec3 far = make_v3(planeCrossing(farPlane(c.cell.x, g.rpd.x), g.po.x, g.rpd.x),
                       planeCrossing(farPlane(c.cell.y, g.rpd.y), g.po.y, g.rpd.y),
                       planeCrossing(farPlane(c.cell.z, g.rpd.z), g.po.z, g.rpd.z));
    put(c.from, max(max3(near), c.walk.t));
    if (min3(far) > t) put(c.to, min(min3(far), c.to));  // rounding may leave no cell behind t
  }
  put(c.index, R(0.0));
  put(c.count, R(1.0));
  if (plan != 0) {
    real n = (c.to - c.from) * c.ray.cells / planStep(plan);
    // midpoint segments may be a twentieth longer than planned: a tenth of the error
    put(c.count, max(ceil(goesByCells(v, plan) ? n : R(0.95) * n), R(1.0)));
  }
  put(c.dt, (c.to - c.from) / c.count);
}

// What is seen at t, for a midpoint segment.
FN void evaluateAt(VOLUME v, GridRay g, real t, INOUT(real) sigma, INOUT(vec3) source, INOUT(int) samples) {
  samples += 1;
  real s = sampleAt(v, pointAt(g, t));
  if (s - s == R(0.0)) {
    MapPlace p = mapPlace(v, s);
    MapPiece m = mapPiece(v, p.k);
    sigma = sigmaAt(m, p.f);
    vec3 color = colorAt(m, p.f);
    source = make_v3(sigma * color.x, sigma * color.y, sigma * color.z);
  }
}

// Evaluates the part that begins at c.begin; one of a cell's segment is halved until it does not matter against tMin that
// extinction and colour are called constant along it: they go up or down by `uneven` and `shaded`, which its front and the
// other volumes hide; nothing does where a surface may cut it off.
FN void evaluatePart(VOLUME v, INOUT(Cursor) c, real tMin, INOUT(int) samples) {
  real start = segmentStart(c), end = segmentEnd(c);
  real part = c.part, sigma = R(0.0);
  vec3 source = make_v3(R(0.0), R(0.0), R(0.0));
  int plan = planAt(v, c.walk.index);
  if (goesByCells(v, plan) && c.holds) {
    bool more = true;
    while (more) {
      samples += 1;
      MapMean m = meanAlong(v, c.s0 + c.begin * c.rise, c.s0 + (c.begin + part) * c.rise);
      real length = part * c.dt;
      real tau = m.sigma * length;
      real uneven = max(abs(m.sigma - m.sigmaFront), abs(m.sigma - m.sigmaBack)) * length;
      real shaded =
          max(max(abs(m.front.x - m.back.x), abs(m.front.y - m.back.y)), abs(m.front.z - m.back.z)) *
          min(tau, R(1.0));
      real hidden = min(tau + v.hidden * length, R(1.0));
      more = (uneven + shaded) * hidden > R(3.0) * tMin && part > R(0.000244140625);
      if (more) part = R(0.5) * part;
      sigma = m.sigma;
      source = make_v3(m.sigma * m.color.x, m.sigma * m.color.y, m.sigma * m.color.z);
    }
  } else if (plan != 0 && !goesByCells(v, plan)) {
    evaluateAt(v, c.ray.g, R(0.5) * (start + end), sigma, source, samples);
  }
  put(c.part, part);
  put(c.sigma, sigma);
  put(c.source, source);
  put(c.a, c.begin > R(0.0) ? start + c.begin * c.dt : start);
  put(c.b, c.begin + part < R(1.0) ? start + (c.begin + part) * c.dt : end);
}

// Evaluates the current part over [a, b] alone.
FN void evaluateBetween(VOLUME v, INOUT(Cursor) c, real a, real b, INOUT(int) samples) {
  int plan = planAt(v, c.walk.index);
  real sigma = c.sigma;
  vec3 source = c.source;
  if (byMidpoints(plan)) {
    sigma = R(0.0);
    source = make_v3(R(0.0), R(0.0), R(0.0));
    evaluateAt(v, c.ray.g, R(0.5) * (a + b), sigma, source, samples);
  } else if (goesByCells(v, plan) && c.holds && c.dt > R(0.0)) {
    samples += 1;
    real start = segmentStart(c), rate = c.rise / c.dt;
    MapMean m = meanAlong(v, c.s0 + (a - start) * rate, c.s0 + (b - start) * rate);
    sigma = m.sigma;
    source = make_v3(m.sigma * m.color.x, m.sigma * m.color.y, m.sigma * m.color.z);
  }
  put(c.sigma, sigma);
  put(c.source, source);
}

// Evaluates the first part of the current segment.
FN void evaluateSegment(VOLUME v, INOUT(Cursor) c, real tMin, INOUT(int) samples) {
  put(c.begin, R(0.0));
  put(c.part, R(1.0));
  if (goesByCells(v, planAt(v, c.walk.index))) {
    Corners k = cellCorners(v, c.cell);
    real start = segmentStart(c), end = segmentEnd(c);
    put(c.holds, end > start && holdsData(k));
    if (c.holds) {
      put(c.s0, valueIn(k, fractionIn(c.cell, pointAt(c.ray.g, start))));
      put(c.rise, valueIn(k, fractionIn(c.cell, pointAt(c.ray.g, end))) - c.s0);
    }
  }
  evaluatePart(v, c, tMin, samples);
}

// The next part of the current segment; false behind the last.
FN bool nextPart(VOLUME v, INOUT(Cursor) c, real tMin, INOUT(int) samples) {
  put(c.begin, c.begin + c.part);
  bool more = c.begin < R(1.0);
  if (more) {
    put(c.part, min(R(2.0) * c.part, R(1.0) - c.begin));
    evaluatePart(v, c, tMin, samples);
  }
  return more;
}

// No segment: up to `b` there is nothing.
FN void evaluateNothing(INOUT(Cursor) c, real b) {
  put(c.b, b);
  put(c.sigma, R(0.0));
  put(c.source, make_v3(R(0.0), R(0.0), R(0.0)));
}

FN void countMacrocell(VOLUME v, INOUT(Cursor) c) {
  put(c.entered, c.entered + 1);
  if (planAt(v, c.walk.index) == 0) put(c.skipped, c.skipped + 1);
}

// The part that ends after t; before the volume, nothing up to it, with index -1. If the ray enters the volume from tOut
// on only, this partition may not have the macrocell there.
FN void seekPart(VOLUME v, INOUT(Cursor) c, real t, real tOut, real tMin, INOUT(int) samples) {
  put(c.index, R(-1.0));
  if (t >= c.ray.t1 || c.ray.t0 >= c.ray.t1) {
    evaluateNothing(c, NO_HIT);
  } else if (t < c.ray.t0 && c.ray.t0 >= tOut) {
    evaluateNothing(c, c.ray.t0);
  } else {
    real from = max(t, c.ray.t0);
    c.walk = startMacroWalk(v, c.ray, from);
    enterStretch(v, c, max(from, c.walk.t));
    if (c.from < from && c.dt > R(0.0)) put(c.index, segmentBehind(from, c.from, c.dt, c.count));
    if (t < c.ray.t0) {
      evaluateNothing(c, c.ray.t0);
      put(c.index, R(-1.0));
    } else {
      countMacrocell(v, c);
      evaluateSegment(v, c, tMin, samples);
      bool more = c.b <= t;
      while (more) more = nextPart(v, c, tMin, samples) && c.b <= t;
    }
  }
}

// The part behind the current one.
FN void advance(VOLUME v, INOUT(Cursor) c, real tMin, INOUT(int) samples) {
  if (c.index >= R(0.0) && nextPart(v, c, tMin, samples)) return;
  bool more = true;
  if (c.index + R(1.0) < c.count) {
    if (c.index < R(0.0)) countMacrocell(v, c);
    put(c.index, c.index + R(1.0));
  } else if (c.to < macrocellEnd(c)) {
    enterStretch(v, c, c.to);
  } else if (c.b < c.ray.t1) {
    int index = c.walk.index;
    vec3 plane = c.walk.plane, far = c.walk.far;
    real t = c.walk.t;
    stepMacroWalk(v, c.ray, index, plane, far, t);
    put(c.walk.index, index);
    put(c.walk.plane, plane);
    put(c.walk.far, far);
    put(c.walk.t, t);
    enterStretch(v, c, c.walk.t);
    countMacrocell(v, c);
  } else {
    more = false;
  }
  if (more)
    evaluateSegment(v, c, tMin, samples);
  else
    evaluateNothing(c, NO_HIT);
}

// Several volumes, count <= MANY_VOLUMES: all that are volume rendered, those that this partition does not hold, too, as a
// merged segment may begin where one of them has ended. m.tStop is also where a light or a radius ends the ray.
FN void integrateMany(SCENE s, VOLUMES list, UNIFORM int count, vec3 o, vec3 d, MarchRange m,
                      INOUT(Radiance) L, INOUT(MarchCount) n) {
  Cursor cursor[MANY_VOLUMES];
  vec3 rgb = L.rgb;
  real A = L.A;
  int samples = 0;
  real t = max(max(m.tIn, m.tStart), R(0.0)), end = R(0.0);
  for (UNIFORM int k = 0; k < count; k++) {
    VOLUME v = VOLUME_AT(s, list, k);
    cursor[k].ray = clippedRay(v, o, d);
    cursor[k].entered = 0;
    cursor[k].skipped = 0;
    if (cursor[k].ray.t0 < cursor[k].ray.t1) end = max(end, cursor[k].ray.t1);
  }
  // A hit exactly at tIn may end a segment that began before it.
  bool go = t <= m.tStop && t < min(end, m.tOut) && R(1.0) - A >= m.tMin;
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
        cursor[k].index = R(-1.0);
      } else {
        seekPart(v, cursor[k], t, m.tOut, m.tMin, samples);
      }
      real from = R(0.0);
      if (cursor[k].b == NO_HIT)
        from = cursor[k].ray.t1 <= t ? cursor[k].ray.t1 : R(0.0);
      else if (cursor[k].index >= R(0.0))
        from = cursor[k].a;
      if (cursor[k].ray.t0 < cursor[k].ray.t1) begin = max(begin, from);
    }
    a = max(begin, m.tStart);
  }
  while (go) {
    real next = NO_HIT, sigma = R(0.0);
    vec3 source = make_v3(R(0.0), R(0.0), R(0.0));
    for (UNIFORM int k = 0; k < count; k++) {
      next = min(next, cursor[k].b);
      sigma += cursor[k].sigma;
      source.x += cursor[k].source.x;
      source.y += cursor[k].source.y;
      source.z += cursor[k].source.z;
    }
    real b = min(m.tStop, next);
    if (b < next && b <= m.tOut) {
      // a surface cuts parts off: what counts is what is left of them
      sigma = R(0.0);
      source = make_v3(R(0.0), R(0.0), R(0.0));
      for (UNIFORM int k = 0; k < count; k++) {
        VOLUME v = VOLUME_AT(s, list, k);
        if (cursor[k].index >= R(0.0) && cursor[k].b < NO_HIT) evaluateBetween(v, cursor[k], a, b, samples);
        sigma += cursor[k].sigma;
        source.x += cursor[k].source.x;
        source.y += cursor[k].source.y;
        source.z += cursor[k].source.z;
      }
    }
    if (b > m.tOut) {
      go = false;  // the next partition's
    } else {
      if (sigma > R(0.0) && b > a) {
        real per = R(1.0) / sigma;
        addSegment(rgb, A, sigma * (b - a), make_v3(source.x * per, source.y * per, source.z * per), m.tMin);
      }
      a = b;
      if (b >= end || R(1.0) - A < m.tMin || b >= m.tOut) go = false;
      for (UNIFORM int k = 0; k < count; k++) {
        VOLUME v = VOLUME_AT(s, list, k);
        if (go && cursor[k].b <= b && holdsSamples(v)) advance(v, cursor[k], m.tMin, samples);
      }
    }
  }
  L.rgb = rgb;
  L.A = A;
  n.samples += samples;
  for (UNIFORM int k = 0; k < count; k++) {
    n.macrocells += cursor[k].entered - cursor[k].skipped;
    n.skipped += cursor[k].skipped;
  }
}
