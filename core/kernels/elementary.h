// SPDX-License-Identifier: Apache-2.0
// exp, log, sin, cos and their relatives, from + - * / and bit operations alone, so that a float result has
// the same bits in C++, ISPC (every target) and GLSL (NoContraction). No table, no fused multiply-add, no
// branch.
//
// In float, within 1 ulp (exp1, log1) or 2 ulp:
// - exp1(x): e^x for x in [-87, 88]; 0 below, e^88 = 1.65e38 above
// - oneMinusExp(x): 1 - e^-x for x >= -88; -1.65e38 below
// - log1(x): ln x for normal x; below them (0, negative, NaN) ln 2^-126 = -87.3, above them 88.7
// - minusLogOneMinus(a): -ln(1 - a) for a < 1; opaqueDepth() from 1 up
// - sincos1, sin1, cos1: for x in [-64, 64]; beyond, digits are lost in proportion to |x|
// - pow1(x, y): x^y for x >= 0, relative error (2 + |y ln x|) 2^-23; 0 counts as 2^-126
//
// No result is denormal, and a denormal argument counts as 0 (flushSmall), so that devices which flush
// denormals and devices which keep them agree. NaN gives exp1 = 0, oneMinusExp = 1: callers keep no-data
// samples away.
//
// Method: Cody & Waite, Software Manual for the Elementary Functions (1980): argument reduction with a split
// constant, then a minimax polynomial; the form of the logarithm is Tang's (ACM TOMS 16(4), 1990) with s = f
// / (2 + f). The double twin calls the standard library instead: the twin isolates float rounding.

// x, or +0 if |x| is below the least normal float; the same on devices that flush denormals and that keep
// them.
FN real flushSmall(real x) { return abs(x) < R(1.2e-38) ? R(0.0) : x; }

// The optical depth that stands for full opacity: exp1 of minus any relevant product of it is 0.
FN real opaqueDepth() { return R(1e20); }

#if defined(GXY_TWIN)

FN real exp1(real x) { return std::exp(x); }
FN real oneMinusExp(real x) { return -std::expm1(-x); }
FN real log1(real x) { return std::log(max1(x, 2.2250738585072014e-308)); }
FN real minusLogOneMinus(real a) { return a < R(1.0) ? -std::log1p(-a) : opaqueDepth(); }
FN void sincos1(real x, OUT(real) s, OUT(real) c) {
  s = std::sin(x);
  c = std::cos(x);
}

#else

// e^x = scale (1 + q) with scale a power of two and |q| < 0.42, for x within [-87, 88].
FN void splitExp(real x, OUT(real) scale, OUT(real) q) {
  // Adding 1.5 * 2^23 rounds to an integer n, which is then in the low bits.
  real shifted = x * R(1.44269504) + R(12582912.0);
  real n = shifted - R(12582912.0);
  real r = (x - n * R(0.693359375)) + n * R(2.12194440e-4);
  real p = R(0.0083688358) + r * R(0.0013941538);
  p = R(0.041666392) + r * p;
  p = R(0.16666520) + r * p;
  p = R(0.5) + r * p;
  q = r + (r * r) * p;
  scale = asReal((asUint(shifted) << 23u) + 0x3f800000u);
}

FN real exp1(real x) {
  real scale;
  real q;
  real inside = x >= R(-87.0) ? x : R(-87.0);
  inside = inside < R(88.0) ? inside : R(88.0);
  splitExp(inside, scale, q);
  return x >= R(-87.0) ? scale * (R(1.0) + q) : R(0.0);
}

FN real oneMinusExp(real x) {
  real scale;
  real q;
  real inside = x < R(87.0) ? x : R(87.0);
  inside = inside > R(-88.0) ? inside : R(-88.0);
  splitExp(-inside, scale, q);
  return flushSmall((R(1.0) - scale) - scale * q);
}

FN real log1(real x) {
  real inside = x >= R(1.17549435e-38) ? x : R(1.17549435e-38);
  uint bits = asUint(inside) + (0x3f800000u - 0x3f3504f3u);
  real k = toReal(asInt(bits >> 23u) - 127);
  // The significand in [sqrt(1/2), sqrt(2)), less 1: exact.
  real f = asReal((bits & 0x007fffffu) + 0x3f3504f3u) - R(1.0);
  real s = f / (R(2.0) + f);
  real z = s * s;
  real series = z * (R(0.66666818) + z * (R(0.39973512) + z * R(0.29963323)));
  real halfSquare = R(0.5) * f * f;
  real tail = s * (halfSquare + series) - k * R(2.12194440e-4);
  return k * R(0.693359375) - ((halfSquare - tail) - f);
}

FN real minusLogOneMinus(real a) {
  real u = R(1.0) - a;
  real lost = a - (R(1.0) - u);
  real inside = a < R(1.0) ? u : R(1.0);
  return a < R(1.0) ? flushSmall(lost / inside - log1(inside)) : opaqueDepth();
}

FN void sincos1(real x, OUT(real) s, OUT(real) c) {
  real shifted = x * R(0.636619772) + R(12582912.0);
  real n = shifted - R(12582912.0);
  uint quadrant = asUint(shifted) & 3u;
  real r = ((x - n * R(1.5707855224609375)) - n * R(1.0804273188114166e-05)) - n * R(6.07710063e-11);
  real z = r * r;
  real sine = r + (r * z) * (R(-0.16666655) + z * (R(0.0083321901) + z * R(-0.00019518408)));
  real cosine =
      (R(1.0) - R(0.5) * z) + (z * z) * (R(0.041666646) + z * (R(-0.0013887301) + z * R(2.4430664e-05)));
  bool swapped = (quadrant & 1u) != 0u;
  real a = swapped ? cosine : sine;
  real b = swapped ? sine : cosine;
  s = flushSmall(quadrant >= 2u ? -a : a);
  c = flushSmall(quadrant == 1u || quadrant == 2u ? -b : b);
}

#endif

FN real sin1(real x) {
  real s;
  real c;
  sincos1(x, s, c);
  return s;
}
FN real cos1(real x) {
  real s;
  real c;
  sincos1(x, s, c);
  return c;
}
FN real pow1(real x, real y) { return exp1(y * log1(x)); }
