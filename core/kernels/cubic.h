// SPDX-License-Identifier: Apache-2.0
// The first root of a cubic on [0, 1], given by its four Bernstein coefficients (Parker 1998; Marmitt 2004;
// Neubauer 2002). The cubic is split at its extrema, then a bracketed, safeguarded Newton iteration follows.
// End values are used as given. Neighbouring cells share them to the bit, so they cannot both see or both
// miss a crossing.

FN real bernsteinValue(vec4 b, real u) {
  real v = R(1.0) - u;
  real a0 = b.x * v + b.y * u, a1 = b.y * v + b.z * u, a2 = b.z * v + b.w * u;
  real c0 = a0 * v + a1 * u, c1 = a1 * v + a2 * u;
  return c0 * v + c1 * u;
}

FN real bernsteinSlope(vec4 b, real u) {
  real v = R(1.0) - u;
  real d0 = b.y - b.x, d1 = b.z - b.y, d2 = b.w - b.z;
  return R(3.0) * ((d0 * v + d1 * u) * v + (d1 * v + d2 * u) * u);
}

// Returns the root inside (lo, hi), where the values fLo at lo and fHi at hi have different signs. Ends with
// a step of at most `tolerance`; the remaining error is about its square.
FN real refineRoot(vec4 b, real lo, real hi, real fLo, real fHi, real tolerance) {
  real l = lo, h = hi;
  real u = l + (h - l) * (fLo / (fLo - fHi));
  for (UNIFORM int k = 0; k < ROOT_ITERATIONS; k++) {
    u = min(max(u, l), h);
    real f = bernsteinValue(b, u);
    if (f == R(0.0)) break;
    if ((f < R(0.0)) == (fLo < R(0.0)))
      l = u;
    else
      h = u;
    real n = u - f / bernsteinSlope(b, u);
    bool inside = n > l && n < h;
    bool converged = abs(n - u) <= tolerance;
    if (!inside) n = converged ? min(max(n, l), h) : R(0.5) * (l + h);
    u = n;
    if (converged) break;
  }
  return u;
}

// Finds where in (0, 1) the cubic has extrema, in order; 1 stands for an extremum that it does not have. They
// are the roots of the derivative d0 v^2 + 2 d1 u v + d2 u^2 = qa u^2 + 2 qb u + qc.
FN void extremaOf(vec4 b, OUT(real) e0, OUT(real) e1) {
  real d0 = b.y - b.x, d1 = b.z - b.y, d2 = b.w - b.z;
  // Scales the differences if their products would leave the range of float. That moves no root.
  real size = max(max(abs(d0), abs(d1)), abs(d2)), scale = R(1.0);
  if (size > R(1e15)) scale = R(8.271806125530277e-25);   // 2^-80
  if (size < R(1e-15)) scale = R(1.2089258196146292e24);  // 2^80
  d0 *= scale;
  d1 *= scale;
  d2 *= scale;
  real qa = (d0 - d1) - (d1 - d2), qb = d1 - d0;
  e0 = R(1.0);
  e1 = R(1.0);
  real disc = qb * qb - qa * d0;
  if (disc > R(0.0)) {
    real s = sqrt(disc);
    real w = -(qb + (qb < R(0.0) ? -s : s));
    real r0 = qa != R(0.0) ? w / qa : R(2.0), r1 = w != R(0.0) ? d0 / w : R(2.0);
    real lo = min(r0, r1), hi = max(r0, r1);
    if (hi > R(0.0) && hi < R(1.0)) e1 = hi;
    e0 = lo > R(0.0) && lo < R(1.0) ? lo : e1;
  }
}

// The conditions for a root to be a hit: t in [tIn, tOut) and t > tAfter.
// - `entry`: the ray comes from no cell with data, so a value of exactly 0 at its start is a hit. Elsewhere
//   that was the end of the cell before: a plateau is hit once, where the ray enters it.
// - `from` != 0: the ray starts on the surface, on the side of that sign, and only crossings that leave this
//   side count.
// - `start`: the ray starts in this cell, or up to a thousandth of a cell before it. The value there may have
//   the wrong sign through rounding. If that value grows in size, the ray goes into the surface; otherwise
//   it is on its way out.
struct RootQuery {
  real tIn, tOut, tAfter;
  bool entry;
  int from;
  bool start;
};

FN bool acceptsRoot(real t, real tIn, real tOut, real tAfter) { return t >= tIn && t < tOut && t > tAfter; }

// A part [lo, hi] of [0, 1] in which the cubic is monotone and its sign changes from that of fLo.
struct Bracket {
  real lo, hi, fLo, fHi;
};

/// The t of parameter u of a cell that the ray enters at ta and leaves at tb.
FN real rootTime(real u, real ta, real tb) {
  real along = ta + u * (tb - ta);
  return u < R(1.0) ? min(along, tb) : tb;
}

// Moves the t of a root behind the cell's entry unless the root is the entry, so that its t tells which cell
// a hit is in.
FN real rootBehind(real t, real u, real ta, real tb) {
  real next = max(ta * R(1.0000002), R(1e-30));
  return u > R(0.0) && t <= ta ? min(next, tb) : t;
}

// Returns the bracket of the first crossing of the cubic b over [ta, tb] at or after parameter `done`; lo >
// hi if there is none.
FN Bracket firstBracket(vec4 b, real ta, real done, RootQuery q) {
  real begin = R(1.0), end = R(0.0), fBegin = R(0.0), fEnd = R(0.0);
  real first = b.x;
  if (q.from != 0) {
    real outwards = q.from > 0 ? b.y - b.x : b.x - b.y;
    bool deeper = q.from > 0 ? min(min(b.y, b.z), b.w) < b.x + b.x : max(max(b.y, b.z), b.w) > b.x + b.x;
    bool wrong = (b.x < R(0.0)) != (q.from < 0);
    if (q.start && (!wrong || (outwards <= R(0.0) && deeper))) {
      real size = max1(abs(b.x), R(1e-37));
      first = q.from > 0 ? size : -size;
    }
  }
  real least = min(min(first, b.y), min(b.z, b.w)), most = max(max(first, b.y), max(b.z, b.w));
  if (!(least > R(0.0) || most < R(0.0))) {
    // A surface that the field only touches has the same sign on both sides.
    int from = (q.from > 0 && most <= R(0.0)) || (q.from < 0 && least >= R(0.0)) ? 0 : q.from;
    // A ray that starts inside a plateau meets it at once, whatever side it left.
    bool plateau = max(max(abs(b.x), abs(b.y)), max(abs(b.z), abs(b.w))) == R(0.0);
    if (q.entry && b.x == R(0.0) && (q.from == 0 || plateau) && done == R(0.0) &&
        acceptsRoot(ta, q.tIn, q.tOut, q.tAfter)) {
      begin = R(0.0);
    } else {
      real e0, e1;
      extremaOf(b, e0, e1);
      real a = R(0.0), fa = first;
      for (UNIFORM int k = 0; k < 3; k++) {
        real z = k == 0 ? e0 : (k == 1 ? e1 : R(1.0));
        real fz = z < R(1.0) ? bernsteinValue(b, z) : b.w;
        bool crosses = from <= 0 && fa < R(0.0) && fz >= R(0.0);
        crosses = crosses || (from >= 0 && fa > R(0.0) && fz <= R(0.0));
        if (begin > end && crosses && z > a && a >= done) {
          begin = a;
          end = z;
          fBegin = fa;
          fEnd = fz;
        }
        if (z > a) fa = fz;
        a = max(a, z);
      }
    }
  }
  Bracket c;
  c.lo = begin;
  c.hi = end;
  c.fLo = fBegin;
  c.fHi = fEnd;
  return c;
}

// The parameter of the crossing in its bracket.
FN real rootIn(vec4 b, Bracket c) {
  real u = c.hi;
  if (c.fHi != R(0.0)) u = refineRoot(b, c.lo, c.hi, c.fLo, c.fHi, ROOT_TOLERANCE);
  return u;
}
