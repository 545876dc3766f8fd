// SPDX-License-Identifier: Apache-2.0
// The march through one volume: a walk through macrocells and cells that integrates the segments (volume.h) that belong to this
// partition. What is added for the part of the ray in a cell is in cell_curve.h.

// The curve from fractions p to q of the cell. It is bernsteinAlong (trilinear.h) with half of the
// operations, and still within the corners' values.
FN CellCurve curveIn(CellValues k, vec3 p, vec3 q) {
  real p00 = lerp1(k.v000, k.v100, p.x), p10 = lerp1(k.v010, k.v110, p.x);
  real p01 = lerp1(k.v001, k.v101, p.x), p11 = lerp1(k.v011, k.v111, p.x);
  real q00 = lerp1(k.v000, k.v100, q.x), q10 = lerp1(k.v010, k.v110, q.x);
  real q01 = lerp1(k.v001, k.v101, q.x), q11 = lerp1(k.v011, k.v111, q.x);
  real pp0 = lerp1(p00, p10, p.y), pp1 = lerp1(p01, p11, p.y);
  real pq0 = lerp1(p00, p10, q.y), pq1 = lerp1(p01, p11, q.y);
  real qp0 = lerp1(q00, q10, p.y), qp1 = lerp1(q01, q11, p.y);
  real qq0 = lerp1(q00, q10, q.y), qq1 = lerp1(q01, q11, q.y);
  CellCurve c;
  c.cubic.x = lerp1(pp0, pp1, p.z);
  c.cubic.y = mean3(lerp1(qp0, qp1, p.z), lerp1(pq0, pq1, p.z), lerp1(pp0, pp1, q.z));
  c.cubic.z = mean3(lerp1(qq0, qq1, p.z), lerp1(qp0, qp1, q.z), lerp1(pq0, pq1, q.z));
  c.cubic.w = lerp1(qq0, qq1, q.z);
  real least = minCorner(k), most = maxCorner(k);
  c.low = clamp1(min(min(c.cubic.x, c.cubic.y), min(c.cubic.z, c.cubic.w)), least, most);
  c.high = clamp1(max(max(c.cubic.x, c.cubic.y), max(c.cubic.z, c.cubic.w)), least, most);
  return c;
}

// The index of the first of `count` segments of length dt, from `begin` on, that ends behind t.
FN real segmentBehind(real t, real begin, real dt, real count) {
  real i = clamp1(floor((t - begin) / dt), R(0.0), count - R(1.0));
  while (i > R(0.0) && begin + i * dt > t) i -= R(1.0);
  while (i < count - R(1.0) && begin + (i + R(1.0)) * dt <= t) i += R(1.0);
  return i;
}

// Integrates macrocells that go cell by cell, because some of their cells hold no data or the map is too
// steep. It begins with the macrocell that the ray enters at tEnter, whose plan is `plan`, and ends at
// `leaves`, where the ray enters one that does not go cell by cell. Each cell is cut into equal segments of
// at most the plan's length (planStepWithin if the ray's values in the cell lie within one interval of the
// map, none if that interval shows nothing). Along a segment the value is taken as linear and the map is
// integrated exactly; for a map of few intervals it is also cut where the value leaves an interval. One loop
// does all macrocells, so that the rays of a gang, which stay in each for different numbers of cells, do not
// wait for each other. What lies before t is done elsewhere. Clears `go` where the march ends.
FN_OUTLINE void integrateCells(MAP map, VOLUME v, VolumeRay r, MarchRange m, real t, real tEnter, int plan,
                               real end, INOUT(Radiance) L, INOUT(int) samples, INOUT(int) macrocells,
                               INOUT(int) segmentsSkipped, OUT(real) leaves, INOUT(bool) go) {
  real from = max(tEnter, t);
  ivec3 cells = gridCells(v);
  ivec3 c = make_i3(locateCell(from, r.g.po.x, r.g.pd.x, r.g.rpd.x, cells.x),
                    locateCell(from, r.g.po.y, r.g.pd.y, r.g.rpd.y, cells.y),
                    locateCell(from, r.g.po.z, r.g.pd.z, r.g.rpd.z, cells.z));
  vec3 near = make_v3(planeCrossing(nearPlane(c.x, r.g.rpd.x), r.g.po.x, r.g.rpd.x),
                      planeCrossing(nearPlane(c.y, r.g.rpd.y), r.g.po.y, r.g.rpd.y),
                      planeCrossing(nearPlane(c.z, r.g.rpd.z), r.g.po.z, r.g.rpd.z));
  real ta = max(max3(near), tEnter);
  real step = planStep(plan), within = planStepWithin(plan);
  vec3 rgb = L.rgb;
  real A = L.A;
  int evaluated = 0, entered = 1, passed = 0;
  bool inside = true;
  while (go && inside) {
    vec3 far = make_v3(planeCrossing(farPlane(c.x, r.g.rpd.x), r.g.po.x, r.g.rpd.x),
                       planeCrossing(farPlane(c.y, r.g.rpd.y), r.g.po.y, r.g.rpd.y),
                       planeCrossing(farPlane(c.z, r.g.rpd.z), r.g.po.z, r.g.rpd.z));
    real exit = min3(far);
    real tc = min(exit, r.t1);
    CellValues k = cellValues(v, c);
    if (tc > ta && holdsData(k)) {
      CellCurve curve = curveIn(k, fractionIn(c, pointAt(r.g, ta)), fractionIn(c, pointAt(r.g, tc)));
      CurveInMap lies = curveInMap(map, curve);
      real span = tc - ta;
      real count = max(ceil(span * r.cells / (lies.even ? within : step)), R(1.0));
      real dt = span / count;
      if (!lies.seen && tc <= m.tOut) passed += toInt(count);
      real i = R(0.0);
      if (ta < t) i = segmentBehind(t, ta, dt, count);
      real a = max(i > R(0.0) ? ta + i * dt : ta, m.tStart);
      real u = (a - ta) / span;
      while (go && lies.seen && i < count) {
        i += R(1.0);
        real b = min(i < count ? ta + i * dt : tc, m.tStop);
        if (b > m.tOut) {
          go = false;  // it belongs to the next partition
        } else {
          evaluated += 1;
          real uTo = b < tc ? (b - ta) / span : R(1.0);
          addPart(map, curve, false, lies, u, uTo, span, m.tMin, rgb, A);
          u = uTo;
          a = b;
          if (b >= end || R(1.0) - A < m.tMin) go = false;
        }
      }
    }
    if (tc >= end || tc >= m.tOut) go = false;
    int x = far.x <= exit ? (r.g.rpd.x < R(0.0) ? -1 : 1) : 0;
    int y = far.y <= exit ? (r.g.rpd.y < R(0.0) ? -1 : 1) : 0;
    int z = far.z <= exit ? (r.g.rpd.z < R(0.0) ? -1 : 1) : 0;
    ivec3 next = make_i3(c.x + x, c.y + y, c.z + z);
    bool crosses = (((c.x ^ next.x) | (c.y ^ next.y) | (c.z ^ next.z)) >> MACRO_BITS) != 0;
    c = next;
    ta = exit;
    if (go && crosses) {
      int behind = planAt(v, macroIndex(v, make_i3(c.x >> MACRO_BITS, c.y >> MACRO_BITS, c.z >> MACRO_BITS)));
      inside = behind != 0 && !isMidpoint(behind);
      step = planStep(behind);
      within = planStepWithin(behind);
      entered += inside ? 1 : 0;
    }
  }
  L.rgb = rgb;
  L.A = A;
  samples += evaluated;
  macrocells += entered;
  segmentsSkipped += passed;
  leaves = ta;
}

// Adds the midpoint segment of `length` in whose middle the value is s; nothing if there is no data.
FN void addSample(MAP map, real s, real length, real tMin, INOUT(vec3) rgb, INOUT(real) A,
                  INOUT(int) samples) {
  if (length > R(0.0)) {
    samples += 1;
    if (s - s == R(0.0)) {
      MapPlace p = mapPlace(map, s);
      // Colours are fetched only if some ray of the gang sees something.
      real sigma = sigmaAt(mapPiece(map, p.k), p.f);
      if (sigma > R(0.0)) addSegment(rgb, A, sigma * length, colorAt(mapPiece(map, p.k), p.f), tMin);
    }
  }
}

// On a device without branches, all lanes do what is in a loop as long as one lane goes round it. There
// segments have a loop of their own, so that not each of them pays for the walk through macrocells.
#if defined(GXY_GLSL)
#define SEGMENTS     \
  bool over = false; \
  while (true) {
#define END_OF_SEGMENTS(more) \
  if (!(more)) break;         \
  }                           \
  if (over) break;
#define END_OF_MARCH \
  {                  \
    over = true;     \
    break;           \
  }
#else
#define SEGMENTS
#define END_OF_SEGMENTS(more)
#define END_OF_MARCH break;
#endif

// Factors that turn plans into strides, for one ray: t per unit of a plan, the shortest segment, and the
// longest segment that goes in a pair.
struct StrideUnits {
  real perUnit, least, paired;
};

FN real segmentOf(StrideUnits u, int plan) { return max(toReal(plan) * u.perUnit, u.least); }

// The segments that a plan makes from t on, each `h` long. If two fit into PLAN_REACH they go together: then
// one plan is looked up for both, that of macrocell `at` at the end of their `reach`.
FN void strideFrom(VOLUME v, GridRay g, StrideUnits u, real t, int plan, OUT(real) h, OUT(real) reach,
                   OUT(int) at, OUT(int) planBehind) {
  h = segmentOf(u, plan);
  reach = h <= u.paired ? h + h : h;
  at = macroAt(v, pointAt(g, t + reach));
  planBehind = planAt(v, at);
}

// Integrates the volume. The loop does one stride per iteration. While the value of a segment is fetched, the
// plan behind it is looked up and the value before it is mapped: three chains of operations that do not wait
// for each other.
//
// `begun`: where the first segment begins if the partition before has handed it on, else -1; on return the
// same for the partition behind.
FN void integrateVolume(MAP map, VOLUME v, VolumeRay r, MarchRange m, INOUT(real) begun, INOUT(Radiance) L,
                        INOUT(MarchCount) n) {
  real end = min(r.t1, m.tStop);
  real last = min(end, m.tOut);
  bool resumes = begun >= R(0.0);
  real t = resumes ? begun : max(m.tStart, r.t0);
  real from = resumes ? t : max(t, m.tIn);  // where the walk through macrocells begins
  // A hit exactly at tIn may end a segment that began before it.
  bool meets = from <= m.tStop && max(from, m.tIn) < r.t1;
  // Nothing belongs to this partition, but perhaps to the next.
  if (meets && !(max(from, m.tIn) < m.tOut)) return;
  begun = R(-1.0);
  if (!meets) return;
  StrideUnits units;
  units.perUnit = (R(1.0) / r.cells) * (R(1.0) / toReal(PLAN_UNIT << PLAN_BITS));
  units.least = r.t1 * R(2.4e-7);  // must move t on, although cells may be smaller than float resolves
  units.paired = R(0.5) * PLAN_REACH / r.cells;
  int at = macroAt(v, pointAt(r.g, t));
  int plan = resumes ? planAt(v, at) : 0;
  real nextLength, nextReach;  // the stride from t on
  int nextAt, nextPlan;
  strideFrom(v, r.g, units, t, plan, nextLength, nextReach, nextAt, nextPlan);
  // The loop's variables are not members of structures (decision 0012).
  vec3 rgb = L.rgb;
  real A = L.A;
  int samples = 0, macrocells = 0, skipped = 0, segmentsSkipped = 0;
  real s = R(0.0),
       length = R(0.0);  // middle value and length of the segment before, which is still to be added
  // The walk through macrocells, which goes ahead of midpoint segments to where they end: at a macrocell that
  // goes cell by cell.
  int index = 0;
  vec3 plane = make_v3(R(0.0), R(0.0), R(0.0)), far = make_v3(R(0.0), R(0.0), R(0.0));
  real tHere = R(0.0), limit = end;
  if (anyCellwise(v)) {
    MacroWalk w = startMacroWalk(v, r, from);
    index = w.index;
    plane = w.plane;
    far = w.far;
    int planHere = planAt(v, index);
    if (planHere != 0 && !isMidpoint(planHere)) limit = w.t;
  }
  while (R(1.0) - A >= m.tMin) {
    if (!isMidpoint(plan) || t >= limit) {
      if (t >= last) break;
      MacroWalk w = startMacroWalk(v, r, from);
      index = w.index;
      int planHere = planAt(v, index);
      plane = w.plane;
      far = w.far;
      tHere = w.t;
      bool go = true;
      while (go && !isMidpoint(planHere)) {
        // Rays of a gang meet again where something is seen.
        while (go && planHere == 0) {
          skipped += 1;
          if (min(min3(far), r.t1) >= last) {
            go = false;
          } else {
            stepMacroWalk(v, r, index, plane, far, tHere);
            planHere = planAt(v, index);
          }
        }
        if (go && !isMidpoint(planHere) &&
            anyCellwise(v)) {  // GLSL compiles none of this for scenes without such macrocells
          // Copies, so that references in the call do not keep the loop's own variables in memory.
          VolumeRay ray = r;
          addSample(map, s, length, m.tMin, rgb, A, samples);
          length = R(0.0);
          Radiance sum;
          sum.rgb = rgb;
          sum.A = A;
          int counted = samples, entered = macrocells, passed = segmentsSkipped;
          real leaves = tHere;
          bool on = R(1.0) - A >= m.tMin;
          if (on)
            integrateCells(map, v, ray, m, from, tHere, planHere, end, sum, counted, entered, passed, leaves,
                           on);
          rgb = sum.rgb;
          A = sum.A;
          samples = counted;
          macrocells = entered;
          segmentsSkipped = passed;
          go = on;
          while (go && min3(far) <= leaves) stepMacroWalk(v, r, index, plane, far, tHere);
          planHere = planAt(v, index);
        }
      }
      if (!go) break;
      t = max(t, tHere);
      at = macroAt(v, pointAt(r.g, t));
      plan = planAt(v, at);
      // Rounding may put the point on the other side of a face, but must not when the partition behind
      // resumes here.
      if (!isMidpoint(plan)) plan = planHere;
      macrocells += 1;
      strideFrom(v, r.g, units, t, plan, nextLength, nextReach, nextAt, nextPlan);
      limit = end;
    }
    SEGMENTS
    if (anyCellwise(v)) {
      // A segment ends where a macrocell that goes cell by cell begins.
      real reach = min(t + nextReach, last);
      bool free = limit == end;
      while (free && min3(far) < reach) {
        stepMacroWalk(v, r, index, plane, far, tHere);
        int planHere = planAt(v, index);
        free = planHere == 0 || isMidpoint(planHere);
        if (!free) limit = min(limit, tHere);
      }
    }
    real shorter = segmentOf(units, nextPlan);
    bool finer = isMidpoint(nextPlan) && shorter < nextLength;
    real h = finer ? shorter : nextLength;
    bool two = h + h <= nextReach;
    real b = min(t + (two ? h + h : h), limit);
    if (b > m.tOwnershipEnd) {  // it belongs to the next partition
      if (t < m.tOut || m.tOwnershipEnd == m.tOut) begun = t;
      END_OF_MARCH
    }
    real middle = two ? R(0.5) * (t + b) : b;
    vec3 p = pointAt(r.g, R(0.5) * (t + middle));
    ivec3 c = cellAt(v, p);
    CellValues k = cellValues(v, c);
    int passed = at;
    at = nextAt;
    plan = nextPlan;
    if (b != t + nextReach) {
      at = macroAt(v, pointAt(r.g, b));
      plan = planAt(v, at);
    }
    if (at != passed && isMidpoint(plan)) macrocells += 1;
    strideFrom(v, r.g, units, b, plan, nextLength, nextReach, nextAt, nextPlan);
    addSample(map, s, length, m.tMin, rgb, A, samples);
    s = valueIn(k, fractionOf(c, p));
    length = middle - t;
    if (two) {
      vec3 q = pointAt(r.g, R(0.5) * (middle + b));
      ivec3 e = cellAt(v, q);
      CellValues l = cellValues(v, e);
      addSample(map, s, R(1.0) - A >= m.tMin ? length : R(0.0), m.tMin, rgb, A, samples);
      s = valueIn(l, fractionOf(e, q));
      length = b - middle;
    }
    t = b;
    from = b;
    if (b >= last || b > m.tOut) {
      if (b < end && m.tOwnershipEnd == m.tOut) begun = b;
      END_OF_MARCH
    }
    END_OF_SEGMENTS(isMidpoint(plan) && t < limit && R(1.0) - A >= m.tMin)
  }
  if (R(1.0) - A >= m.tMin) addSample(map, s, length, m.tMin, rgb, A, samples);
  L.rgb = rgb;
  L.A = A;
  n.samples += samples;
  n.macrocells += macrocells;
  n.skipped += skipped;
  n.segmentsSkipped += segmentsSkipped;
}
