// SPDX-License-Identifier: Apache-2.0
// The march through one volume: every segment of the plan (volume.h) that this partition evaluates.

// Mean extinction, and its product with colour, of values spread evenly over [s0, s1]: exact for the map, whatever its
// nodes between them (pre-integration by antiderivatives; Engel 2001, Williams & Max 1992).
FN void meanAlong(VOLUME v, real s0, real s1, OUT(real) sigma, OUT(vec3) source) {
  real lo = min(s0, s1), hi = max(s0, s1);
  MapPlace p = mapPlace(v, lo), q = mapPlace(v, hi);
  real a0 = sigmaAt(v, p), b1 = sigmaAt(v, q);
  vec3 c0 = colorAt(v, p), d1 = colorAt(v, q);
  if (p.k == q.k || !(hi > lo)) {
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

FN void integrateVolume(VOLUME v, VolumeRay r, MarchRange m, INOUT(Radiance) L, INOUT(MarchCount) n) {
  real end = min(r.t1, m.tStop);
  real t = max(max(m.tIn, m.tStart), r.t0);
  // A hit exactly at tIn may end a segment that began before it.
  if (!(t <= m.tStop && t < min(r.t1, m.tOut)) || L.T < m.tMin) return;
  MacroWalk w = startMacroWalk(v, r, t);
  bool go = true;
  while (go) {
    int plan = planOf(v, w.m);
    real tb = min(min3(w.far), r.t1);
    if (plan == 0) {
      n.skipped += 1;
    } else if (tb > w.t) {
      n.macrocells += 1;
      real span = tb - w.t;
      real count = max(ceil(span * r.cells * planRate(v, plan & PLAN_LEVEL)), R(1.0));
      real dt = span / count;
      real i = R(0.0);
      if (w.t < t) {  // the first macrocell: segments that ended before t were somebody else's
        i = clamp1(floor((t - w.t) / dt), R(0.0), count - R(1.0));
        while (i > R(0.0) && w.t + i * dt > t) i -= R(1.0);
        while (i < count - R(1.0) && w.t + (i + R(1.0)) * dt <= t) i += R(1.0);
      }
      bool pieces = (plan & PLAN_PIECES) != 0;
      real a = max(i > R(0.0) ? w.t + i * dt : w.t, m.tStart);
      real s0 = R(0.0);
      if (pieces) s0 = sampleAt(v, pointAt(r.g, a));
      while (go && i < count) {
        i += R(1.0);
        real b = min(i < count ? w.t + i * dt : tb, m.tStop);
        if (b > m.tOut) {
          go = false;  // the next partition's
        } else {
          n.samples += 1;
          real length = b - a;
          if (pieces) {
            real s1 = sampleAt(v, pointAt(r.g, b)), sigma;
            vec3 source;
            if ((s0 - s0) + (s1 - s1) == R(0.0)) {
              meanAlong(v, s0, s1, sigma, source);
              if (sigma > R(0.0)) {
                real inverse = R(1.0) / sigma;
                addSegment(L, sigma * length,
                           make_v3(source.x * inverse, source.y * inverse, source.z * inverse));
              }
            }
            s0 = s1;
          } else {
            real s = sampleAt(v, pointAt(r.g, R(0.5) * (a + b)));
            if (s - s == R(0.0)) {
              MapPlace p = mapPlace(v, s);
              real sigma = sigmaAt(v, p);
              if (sigma > R(0.0)) addSegment(L, sigma * length, colorAt(v, p));
            }
          }
          a = b;
          if (b >= end || L.T < m.tMin) go = false;
        }
      }
    }
    if (tb >= end || tb >= m.tOut) go = false;
    if (go) stepMacroWalk(r, w);
  }
}
