// SPDX-License-Identifier: Apache-2.0
// Emission and absorption through several volumes at once.
//
// In each macrocell each volume has equal segments of its plan (volume.h), each evaluated at its middle. In
// each cell of a macrocell that goes cell by cell it has equal segments along which the value is linear;
// these are halved where the map is not as good as constant over them. Where volumes overlap, extinction and
// source add up over the merged segments (docs/numerics.md, "Methods"). A merged segment belongs to the
// partition that contains its end. The extinction and source of a volume in a segment depend only on that
// segment, so the partition behind a border finds the same numbers again.
//
// Each dialect supplies VOLUMES, a list of the operators that are volume rendered, OPERATOR_AT(s, list, k) and
// VOLUME_AT(s, list, k), its k-th operator and the volume of that, and holdsSamples(v), whether this partition
// has samples of it.

// The position of a ray in one volume: part [a, b) of segment `index` of the `count` equal ones of a stretch,
// with its extinction and source. A stretch is the ray in a macrocell, or in a cell of a macrocell that goes
// cell by cell.
struct Cursor {
  VolumeRay ray;
  MacroWalk walk;
  ivec3 cell;  // the present cell, in a macrocell that goes cell by cell
  // The stretch's ends, segment length, number of segments, and present segment.
  real from, to, dt, count, index;
  bool holds;        // whether a cell's segment has data; only then:
  real s0, rise;     // value at the segment's start, and its change up to the end
  real begin, part;  // where the part begins, and its length, in segments; multiples of powers of 2
  real a, b;         // ends of the part; b is NO_HIT behind the volume
  real sigma;
  vec3 source;
  // Macrocells entered, and how many of them were skipped. They are counted here because counters that the
  // loop carries would take registers.
  int entered, skipped;
};

FN bool isCellwise(VOLUME v, int plan) { return anyCellwise(v) && plan != 0 && !isMidpoint(plan); }
FN real macrocellEnd(Cursor c) { return min(min3(c.walk.far), c.ray.t1); }
FN real segmentStart(Cursor c) { return c.index > R(0.0) ? c.from + c.index * c.dt : c.from; }
FN real segmentEnd(Cursor c) {
  return c.index + R(1.0) < c.count ? c.from + (c.index + R(1.0)) * c.dt : c.to;
}

// Sets up the stretch that t is in, in the walk's macrocell.
FN void enterStretch(VOLUME v, INOUT(Cursor) c, real t) {
  int plan = planAt(v, c.walk.index);
  blendInto(c.from, c.walk.t);
  blendInto(c.to, macrocellEnd(c));
  if (isCellwise(v, plan)) {
    GridRay g = c.ray.g;
    ivec3 n = gridCells(v);
    blendInto(c.cell, make_i3(locateCell(t, g.po.x, g.pd.x, g.rpd.x, n.x),
                              locateCell(t, g.po.y, g.pd.y, g.rpd.y, n.y),
                              locateCell(t, g.po.z, g.pd.z, g.rpd.z, n.z)));
    vec3 near = make_v3(planeCrossing(nearPlane(c.cell.x, g.rpd.x), g.po.x, g.rpd.x),
                        planeCrossing(nearPlane(c.cell.y, g.rpd.y), g.po.y, g.rpd.y),
                        planeCrossing(nearPlane(c.cell.z, g.rpd.z), g.po.z, g.rpd.z));
    vec3 far = make_v3(planeCrossing(farPlane(c.cell.x, g.rpd.x), g.po.x, g.rpd.x),
                       planeCrossing(farPlane(c.cell.y, g.rpd.y), g.po.y, g.rpd.y),
                       planeCrossing(farPlane(c.cell.z, g.rpd.z), g.po.z, g.rpd.z));
    blendInto(c.from, max(max3(near), c.walk.t));
    if (min3(far) > t) blendInto(c.to, min(min3(far), c.to));  // rounding may leave no cell behind t
  }
  blendInto(c.index, R(0.0));
  blendInto(c.count, R(1.0));
  if (plan != 0) {
    real n = (c.to - c.from) * c.ray.cells / planStep(plan);
    // Midpoint segments may be a twentieth longer than planned, which costs a tenth of the error.
    blendInto(c.count, max(ceil(isCellwise(v, plan) ? n : R(0.95) * n), R(1.0)));
  }
  blendInto(c.dt, (c.to - c.from) / c.count);
}

// Evaluates extinction and source at t, for a midpoint segment.
FN void evaluateAt(MAP map, VOLUME v, GridRay g, real t, INOUT(real) sigma, INOUT(vec3) source,
                   INOUT(int) samples) {
  samples += 1;
  real s = sampleAt(v, pointAt(g, t));
  if (s - s == R(0.0)) {
    MapPlace p = mapPlace(map, s);
    MapPiece m = mapPiece(map, p.k);
    sigma = sigmaAt(m, p.f);
    vec3 color = colorAt(m, p.f);
    source = make_v3(sigma * color.x, sigma * color.y, sigma * color.z);
  }
}

// Evaluates the part that begins at c.begin. A part of a cell's segment is halved until it does not matter
// against tMin that extinction and colour are taken as constant along it. They vary by `extinctionSpread` and `colorSpread`.
// Its front and the other volumes hide some of that variation, but nothing does where a surface may cut the
// part off.
FN void evaluatePart(OPERATOR op, VOLUME v, INOUT(Cursor) c, real tMin, INOUT(int) samples) {
  real start = segmentStart(c), end = segmentEnd(c);
  real part = c.part, sigma = R(0.0);
  vec3 source = make_v3(R(0.0), R(0.0), R(0.0));
  int plan = planAt(v, c.walk.index);
  if (isCellwise(v, plan) && c.holds) {
    bool more = true;
    while (more) {
      samples += 1;
      MapMean m = meanAlong(op.map, c.s0 + c.begin * c.rise, c.s0 + (c.begin + part) * c.rise);
      real length = part * c.dt;
      real tau = m.sigma * length;
      real extinctionSpread = max(abs(m.sigma - m.sigmaFront), abs(m.sigma - m.sigmaBack)) * length;
      real colorSpread =
          max(max(abs(m.front.x - m.back.x), abs(m.front.y - m.back.y)), abs(m.front.z - m.back.z)) *
          min(tau, R(1.0));
      real occluded = min(tau + op.occludingExtinction * length, R(1.0));
      more = (extinctionSpread + colorSpread) * occluded > R(3.0) * tMin && part > R(0.000244140625);
      if (more) part = R(0.5) * part;
      sigma = m.sigma;
      source = make_v3(m.sigma * m.color.x, m.sigma * m.color.y, m.sigma * m.color.z);
    }
  } else if (plan != 0 && !isCellwise(v, plan)) {
    evaluateAt(op.map, v, c.ray.g, R(0.5) * (start + end), sigma, source, samples);
  }
  blendInto(c.part, part);
  blendInto(c.sigma, sigma);
  blendInto(c.source, source);
  blendInto(c.a, c.begin > R(0.0) ? start + c.begin * c.dt : start);
  blendInto(c.b, c.begin + part < R(1.0) ? start + (c.begin + part) * c.dt : end);
}

// Evaluates the current part over [a, b] only.
FN void evaluateBetween(OPERATOR op, VOLUME v, INOUT(Cursor) c, real a, real b, INOUT(int) samples) {
  int plan = planAt(v, c.walk.index);
  real sigma = c.sigma;
  vec3 source = c.source;
  if (isMidpoint(plan)) {
    sigma = R(0.0);
    source = make_v3(R(0.0), R(0.0), R(0.0));
    evaluateAt(op.map, v, c.ray.g, R(0.5) * (a + b), sigma, source, samples);
  } else if (isCellwise(v, plan) && c.holds && c.dt > R(0.0)) {
    samples += 1;
    real start = segmentStart(c), rate = c.rise / c.dt;
    MapMean m = meanAlong(op.map, c.s0 + (a - start) * rate, c.s0 + (b - start) * rate);
    sigma = m.sigma;
    source = make_v3(m.sigma * m.color.x, m.sigma * m.color.y, m.sigma * m.color.z);
  }
  blendInto(c.sigma, sigma);
  blendInto(c.source, source);
}

// Evaluates the first part of the current segment.
FN void evaluateSegment(OPERATOR op, VOLUME v, INOUT(Cursor) c, real tMin, INOUT(int) samples) {
  blendInto(c.begin, R(0.0));
  blendInto(c.part, R(1.0));
  if (isCellwise(v, planAt(v, c.walk.index))) {
    CellValues k = cellValues(v, c.cell);
    real start = segmentStart(c), end = segmentEnd(c);
    blendInto(c.holds, end > start && holdsData(k));
    if (c.holds) {
      blendInto(c.s0, valueIn(k, fractionIn(c.cell, pointAt(c.ray.g, start))));
      blendInto(c.rise, valueIn(k, fractionIn(c.cell, pointAt(c.ray.g, end))) - c.s0);
    }
  }
  evaluatePart(op, v, c, tMin, samples);
}

// Goes on to the next part of the current segment; returns false behind the last.
FN bool nextPart(OPERATOR op, VOLUME v, INOUT(Cursor) c, real tMin, INOUT(int) samples) {
  blendInto(c.begin, c.begin + c.part);
  bool more = c.begin < R(1.0);
  if (more) {
    blendInto(c.part, min(R(2.0) * c.part, R(1.0) - c.begin));
    evaluatePart(op, v, c, tMin, samples);
  }
  return more;
}

// Sets the cursor to nothing up to `b`.
FN void evaluateNothing(INOUT(Cursor) c, real b) {
  blendInto(c.b, b);
  blendInto(c.sigma, R(0.0));
  blendInto(c.source, make_v3(R(0.0), R(0.0), R(0.0)));
}

FN void countMacrocell(VOLUME v, INOUT(Cursor) c) {
  blendInto(c.entered, c.entered + 1);
  if (planAt(v, c.walk.index) == 0) blendInto(c.skipped, c.skipped + 1);
}

// Goes to the part that ends after t; before the volume, to nothing up to it, with index -1. If the ray
// enters the volume only at or behind tOut, this partition may not have the macrocell there.
FN void seekPart(OPERATOR op, VOLUME v, INOUT(Cursor) c, real t, real tOut, real tMin, INOUT(int) samples) {
  blendInto(c.index, R(-1.0));
  if (t >= c.ray.t1 || c.ray.t0 >= c.ray.t1) {
    evaluateNothing(c, NO_HIT);
  } else if (t < c.ray.t0 && c.ray.t0 >= tOut) {
    evaluateNothing(c, c.ray.t0);
  } else {
    real from = max(t, c.ray.t0);
    c.walk = startMacroWalk(v, c.ray, from);
    enterStretch(v, c, max(from, c.walk.t));
    if (c.from < from && c.dt > R(0.0)) blendInto(c.index, segmentBehind(from, c.from, c.dt, c.count));
    if (t < c.ray.t0) {
      evaluateNothing(c, c.ray.t0);
      blendInto(c.index, R(-1.0));
    } else {
      countMacrocell(v, c);
      evaluateSegment(op, v, c, tMin, samples);
      bool more = c.b <= t;
      while (more) more = nextPart(op, v, c, tMin, samples) && c.b <= t;
    }
  }
}

// Goes on to the part behind the current one.
FN void advance(OPERATOR op, VOLUME v, INOUT(Cursor) c, real tMin, INOUT(int) samples) {
  if (c.index >= R(0.0) && nextPart(op, v, c, tMin, samples)) return;
  bool more = true;
  if (c.index + R(1.0) < c.count) {
    if (c.index < R(0.0)) countMacrocell(v, c);
    blendInto(c.index, c.index + R(1.0));
  } else if (c.to < macrocellEnd(c)) {
    enterStretch(v, c, c.to);
  } else if (c.b < c.ray.t1) {
    int index = c.walk.index;
    vec3 plane = c.walk.plane, far = c.walk.far;
    real t = c.walk.t;
    stepMacroWalk(v, c.ray, index, plane, far, t);
    blendInto(c.walk.index, index);
    blendInto(c.walk.plane, plane);
    blendInto(c.walk.far, far);
    blendInto(c.walk.t, t);
    enterStretch(v, c, c.walk.t);
    countMacrocell(v, c);
  } else {
    more = false;
  }
  if (more)
    evaluateSegment(op, v, c, tMin, samples);
  else
    evaluateNothing(c, NO_HIT);
}

// Integrates all volumes that are volume rendered, count <= MANY_VOLUMES. Those that this partition does not
// hold are included, because a merged segment may begin where one of them has ended. m.tStop is also where a
// light or a radius ends the ray.
FN void integrateVolumes(SCENE s, VOLUMES list, UNIFORM int count, vec3 o, vec3 d, MarchRange m,
                         INOUT(Radiance) L, INOUT(MarchCount) n) {
  Cursor cursor[MANY_VOLUMES];
  vec3 rgb = L.rgb;
  real A = L.A;
  int samples = 0;
  real t = max(max(m.tIn, m.tStart), R(0.0)), end = R(0.0);
  for (UNIFORM int k = 0; k < count; k++) {
    OPERATOR op = OPERATOR_AT(s, list, k);
    VOLUME v = VOLUME_AT(s, list, k);
    cursor[k].ray = clippedRay(op.clips, v, o, d);
    cursor[k].entered = 0;
    cursor[k].skipped = 0;
    if (cursor[k].ray.t0 < cursor[k].ray.t1) end = max(end, cursor[k].ray.t1);
  }
  // A hit exactly at tIn may end a segment that began before it.
  bool go = t <= m.tStop && t < min(end, m.tOut) && R(1.0) - A >= m.tMin;
  end = min(end, m.tStop);
  // The merged segment that contains t may begin before t: at the latest earlier segment end of any volume,
  // where the partition before stopped.
  real a = t;
  if (go) {
    real begin = R(0.0);
    for (UNIFORM int k = 0; k < count; k++) {
      OPERATOR op = OPERATOR_AT(s, list, k);
      VOLUME v = VOLUME_AT(s, list, k);
      if (!holdsSamples(v)) {  // not in this partition, but all behind it or all before it
        evaluateNothing(cursor[k], NO_HIT);
        cursor[k].index = R(-1.0);
      } else {
        seekPart(op, v, cursor[k], t, m.tOut, m.tMin, samples);
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
      // A surface cuts parts off: only what is left of them counts.
      sigma = R(0.0);
      source = make_v3(R(0.0), R(0.0), R(0.0));
      for (UNIFORM int k = 0; k < count; k++) {
        OPERATOR op = OPERATOR_AT(s, list, k);
        VOLUME v = VOLUME_AT(s, list, k);
        if (cursor[k].index >= R(0.0) && cursor[k].b < NO_HIT)
          evaluateBetween(op, v, cursor[k], a, b, samples);
        sigma += cursor[k].sigma;
        source.x += cursor[k].source.x;
        source.y += cursor[k].source.y;
        source.z += cursor[k].source.z;
      }
    }
    if (b > m.tOut) {
      go = false;  // it belongs to the next partition
    } else {
      if (sigma > R(0.0) && b > a) {
        real per = R(1.0) / sigma;
        addSegment(rgb, A, sigma * (b - a), make_v3(source.x * per, source.y * per, source.z * per), m.tMin);
      }
      a = b;
      if (b >= end || R(1.0) - A < m.tMin || b >= m.tOut) go = false;
      for (UNIFORM int k = 0; k < count; k++) {
        OPERATOR op = OPERATOR_AT(s, list, k);
        VOLUME v = VOLUME_AT(s, list, k);
        if (go && cursor[k].b <= b && holdsSamples(v)) advance(op, v, cursor[k], m.tMin, samples);
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
