// SPDX-License-Identifier: Apache-2.0
// The march through one volume: every segment of the plan (volume.h) that this partition evaluates.

// Mean extinction, and its product with colour, of values spread evenly over [s0, s1]: exact for the map, whatever its
// nodes between them (pre-integration by antiderivatives; Engel 2001, Williams & Max 1992).
FN void meanAlong(VOLUME v, real s0, real s1, OUT(real) sigma, OUT(vec3) source) {
  real lo = min(s0, s1), hi = max(s0, s1);
  MapPlace p = mapPlace(v, lo), q = mapPlace(v, hi);
  real a0 = sigmaAt(v, p), b1 = sigmaAt(v, q);
  vec3 c0 = colorAt(v, p), d1 = colorAt(v, q);
  if (p.k == q.k || !(hi - lo > R(1e-35))) {
    // one linear piece: the mean of a product of linears
    real m = R(0.5) * (a0 + b1), u = (b1 - a0) * R(0.083333333333333333);
    sigma = m;
    source = make_v3(m * (R(0.5) * (c0.x + d1.x)) + u * (d1.x - c0.x),
                     m * (R(0.5) * (c0.y + d1.y)) + u * (d1.y - c0.y),
                     m * (R(0.5) * (c0.z + d1.z)) + u * (d1.z - c0.z));
    return;
  }
  // from lo to the end of its interval, the whole intervals between, from the start of the last to hi
  real lengthP = mapNode(v, p.k + 1) - lo, lengthQ = hi - mapNode(v, q.k);
  real a1 = mapSigma(v, p.k) + mapSigmaStep(v, p.k), b0 = mapSigma(v, q.k);
  vec3 e = mapColor(v, p.k), es = mapColorStep(v, p.k), d0 = mapColor(v, q.k);
  vec3 c1 = make_v3(e.x + es.x, e.y + es.y, e.z + es.z);
  real mp = R(0.5) * (a0 + a1), up = (a1 - a0) * R(0.083333333333333333);
  real mq = R(0.5) * (b0 + b1), uq = (b1 - b0) * R(0.083333333333333333);
  real sum = mp * lengthP + mq * lengthQ;
  vec3 s = make_v3((mp * (R(0.5) * (c0.x + c1.x)) + up * (c1.x - c0.x)) * lengthP +
                       (mq * (R(0.5) * (d0.x + d1.x)) + uq * (d1.x - d0.x)) * lengthQ,
                   (mp * (R(0.5) * (c0.y + c1.y)) + up * (c1.y - c0.y)) * lengthP +
                       (mq * (R(0.5) * (d0.y + d1.y)) + uq * (d1.y - d0.y)) * lengthQ,
                   (mp * (R(0.5) * (c0.z + c1.z)) + up * (c1.z - c0.z)) * lengthP +
                       (mq * (R(0.5) * (d0.z + d1.z)) + uq * (d1.z - d0.z)) * lengthQ);
  if (q.k > p.k + 1) {
    vec3 x = mapSumColor(v, q.k), y = mapSumColor(v, p.k + 1);
    sum += mapSumSigma(v, q.k) - mapSumSigma(v, p.k + 1);
    s.x += x.x - y.x;
    s.y += x.y - y.y;
    s.z += x.z - y.z;
  }
  real inverse = R(1.0) / (hi - lo);
  sigma = sum * inverse;
  source = make_v3(s.x * inverse, s.y * inverse, s.z * inverse);
}

// A segment along which the value goes linearly from s0 to s1. A dense one is cut, since its front hides its back.
FN void addPieces(VOLUME v, real s0, real s1, real length, INOUT(Radiance) L) {
  real sigma;
  vec3 source;
  meanAlong(v, s0, s1, sigma, source);
  if (sigma * length > R(0.1)) {
    real part = length * R(0.0625), d = (s1 - s0) * R(0.0625);
    for (UNIFORM int i = 0; i < 16; i++) {
      meanAlong(v, s0 + toReal(i) * d, s0 + toReal(i + 1) * d, sigma, source);
      real inverse = sigma > R(0.0) ? R(1.0) / sigma : R(0.0);
      addSegment(L, sigma * part, make_v3(source.x * inverse, source.y * inverse, source.z * inverse));
    }
  } else if (sigma > R(0.0)) {
    real inverse = R(1.0) / sigma;
    addSegment(L, sigma * length, make_v3(source.x * inverse, source.y * inverse, source.z * inverse));
  }
}

// The first of `count` segments of length dt from `begin` on that ends behind t.
FN real segmentBehind(real t, real begin, real dt, real count) {
  real i = clamp1(floor((t - begin) / dt), R(0.0), count - R(1.0));
  while (i > R(0.0) && begin + i * dt > t) i -= R(1.0);
  while (i < count - R(1.0) && begin + (i + R(1.0)) * dt <= t) i += R(1.0);
  return i;
}

// PLAN_PIECES: the macrocell between tEnter and tb cell by cell, since the value kinks at faces, each cell in equal
// segments along which the value is taken as linear and the map is integrated exactly. Clears `go` where the march ends.
FN_OUTLINE void integratePieces(VOLUME v, VolumeRay r, MarchRange m, real t, real tEnter, real tb, real rate,
                                real end, INOUT(Radiance) L, INOUT(MarchCount) n, INOUT(bool) go) {
  real from = max(tEnter, t);
  ivec3 cells = gridCells(v);
  ivec3 c = make_i3(locateCell(from, r.g.po.x, r.g.pd.x, r.g.rpd.x, cells.x),
                    locateCell(from, r.g.po.y, r.g.pd.y, r.g.rpd.y, cells.y),
                    locateCell(from, r.g.po.z, r.g.pd.z, r.g.rpd.z, cells.z));
  vec3 near = make_v3(planeCrossing(nearPlane(c.x, r.g.rpd.x), r.g.po.x, r.g.rpd.x),
                      planeCrossing(nearPlane(c.y, r.g.rpd.y), r.g.po.y, r.g.rpd.y),
                      planeCrossing(nearPlane(c.z, r.g.rpd.z), r.g.po.z, r.g.rpd.z));
  real ta = max(max3(near), tEnter);
  bool inside = true;
  while (go && inside) {
    vec3 far = make_v3(planeCrossing(farPlane(c.x, r.g.rpd.x), r.g.po.x, r.g.rpd.x),
                       planeCrossing(farPlane(c.y, r.g.rpd.y), r.g.po.y, r.g.rpd.y),
                       planeCrossing(farPlane(c.z, r.g.rpd.z), r.g.po.z, r.g.rpd.z));
    real exit = min3(far);
    real tc = min(exit, tb);
    Corners k = cellCorners(v, c);
    if (tc > ta && holdsData(k)) {
      real span = tc - ta;
      real count = max(ceil(span * r.cells * rate), R(1.0));
      real dt = span / count;
      real i = R(0.0);
      if (ta < t) i = segmentBehind(t, ta, dt, count);
      real a = max(i > R(0.0) ? ta + i * dt : ta, m.tStart);
      real s0 = valueIn(k, c, pointAt(r.g, a));
      while (go && i < count) {
        i += R(1.0);
        real b = min(i < count ? ta + i * dt : tc, m.tStop);
        if (b > m.tOut) {
          go = false;  // the next partition's
        } else {
          n.samples += 1;
          real s1 = valueIn(k, c, pointAt(r.g, b));
          addPieces(v, s0, s1, b - a, L);
          a = b;
          s0 = s1;
          if (b >= end || R(1.0) - L.A < m.tMin) go = false;
        }
      }
    }
    if (tc >= end || tc >= m.tOut) go = false;
    inside = exit < tb;
    if (far.x <= exit) c.x += r.g.rpd.x < R(0.0) ? -1 : 1;
    if (far.y <= exit) c.y += r.g.rpd.y < R(0.0) ? -1 : 1;
    if (far.z <= exit) c.z += r.g.rpd.z < R(0.0) ? -1 : 1;
    ta = exit;
  }
}

// One loop, an iteration a midpoint segment: rays of a gang enter macrocells at different times and still sample together.
FN void integrateVolume(VOLUME v, VolumeRay r, MarchRange m, INOUT(Radiance) L, INOUT(MarchCount) n) {
  real end = min(r.t1, m.tStop);
  real t = max(max(m.tIn, m.tStart), r.t0);
  // A hit exactly at tIn may end a segment that began before it.
  if (!(t <= m.tStop && t < min(r.t1, m.tOut)) || R(1.0) - L.A < m.tMin) return;
  MacroWalk w = startMacroWalk(v, r, t);
  real tb = w.t, dt = R(0.0);       // end of the macrocell, length of its segments
  real i = R(0.0), count = R(0.0);  // segment, and their number
  real a = t;                       // start of the segment
  bool first = true, go = true;
  while (go) {
    while (go && i >= count) {  // on to a macrocell that has segments
      if (first) {
        first = false;
      } else if (tb >= end || tb >= m.tOut) {
        go = false;
      } else {
        stepMacroWalk(r, w);
      }
      int plan = 0;
      if (go) {
        plan = planOf(v, w.m);
        n.skipped += plan == 0 ? 1 : 0;
      }
      tb = min(min3(w.far), r.t1);
      i = R(0.0);
      count = R(0.0);
      real span = tb - w.t;
      if (plan != 0 && span > R(0.0)) {
        n.macrocells += 1;
        real rate = planRate(v, plan & PLAN_LEVEL);
        if ((plan & PLAN_PIECES) != 0) {
          // copies, so that what the call refers to does not keep the loop's own values in memory
          VolumeRay ray = r;
          Radiance sum = L;
          MarchCount counted = n;
          bool on = true;
          integratePieces(v, ray, m, t, w.t, tb, rate, end, sum, counted, on);
          L = sum;
          n = counted;
          go = on;
        } else {
          count = max(ceil(span * r.cells * rate), R(1.0));
          dt = span / count;
          if (w.t < t) i = segmentBehind(t, w.t, dt, count);  // those before were somebody else's
          a = max(i > R(0.0) ? w.t + i * dt : w.t, m.tStart);
        }
      }
    }
    if (go) {
      i += R(1.0);
      real b = min(i < count ? w.t + i * dt : tb, m.tStop);
      if (b > m.tOut) {
        go = false;  // the next partition's
      } else {
        n.samples += 1;
        real s = sampleAt(v, pointAt(r.g, R(0.5) * (a + b)));
        if (s - s == R(0.0)) {
          MapPlace p = mapPlace(v, s);
          real sigma = sigmaAt(v, p);
          if (sigma > R(0.0)) addSegment(L, sigma * (b - a), colorAt(v, p));
        }
        a = b;
        if (b >= end || R(1.0) - L.A < m.tMin) go = false;
      }
    }
  }
}
