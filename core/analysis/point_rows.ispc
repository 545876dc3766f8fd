// SPDX-License-Identifier: Apache-2.0
// Operations of expressions on rows of points, in double. NaN is no data. A logical value is 1, 0 or NaN. Results have the same
// bits for every instruction set: there are only + - * /, sqrt, floor, comparisons and bit operations.
//
// The names of binary operations end with RR where both operands are rows, and with RN or NR where one is a number.
#include "core/kernels/export.h"

static inline double none() { return doublebits(0x7ff8000000000000); }

#define UNARY(NAME, RESULT)                                                                     \
  EXPORT void NAME(const uniform double as[], uniform double to[], const uniform int points) {  \
    foreach (i = 0 ... points) {                                                                \
      double a = as[i];                                                                         \
      to[i] = RESULT;                                                                           \
    }                                                                                           \
  }
#define BINARY(NAME, RESULT)                                                                                                 \
  static inline double NAME(double a, double b) { return RESULT; }                                                           \
  EXPORT void NAME##RR(const uniform double as[], const uniform double bs[], uniform double to[], const uniform int points) { \
    foreach (i = 0 ... points) to[i] = NAME(as[i], bs[i]);                                                                   \
  }                                                                                                                          \
  EXPORT void NAME##RN(const uniform double as[], const uniform double bs[], uniform double to[], const uniform int points) { \
    const uniform double b = bs[0];                                                                                          \
    foreach (i = 0 ... points) to[i] = NAME(as[i], b);                                                                       \
  }                                                                                                                          \
  EXPORT void NAME##NR(const uniform double as[], const uniform double bs[], uniform double to[], const uniform int points) { \
    const uniform double a = as[0];                                                                                          \
    foreach (i = 0 ... points) to[i] = NAME(a, bs[i]);                                                                       \
  }

UNARY(pointNegate, -a)
UNARY(pointAbs, abs(a))
UNARY(pointFloor, floor(a))
UNARY(pointSqrt, a >= 0.0d ? sqrt(a) : none())
UNARY(pointNot, a == a ? (a == 0.0d ? 1.0d : 0.0d) : none())
UNARY(pointIsNoData, a - a == 0.0d ? 0.0d : 1.0d)

BINARY(pointAdd, a + b)
BINARY(pointSubtract, a - b)
BINARY(pointMultiply, a * b)
BINARY(pointDivide, b != 0.0d ? a / b : none())
BINARY(pointMin, a < b ? a : b <= a ? b : none())
BINARY(pointMax, a > b ? a : b >= a ? b : none())
#define COMPARISON(NAME, TEST) BINARY(NAME, a == a && b == b ? (TEST ? 1.0d : 0.0d) : none())
COMPARISON(pointLess, a < b)
COMPARISON(pointLessEqual, a <= b)
COMPARISON(pointEqual, a == b)
COMPARISON(pointNotEqual, a != b)
// Kleene's logic: an operand that decides the result may stand beside no data.
BINARY(pointAnd, a == 0.0d || b == 0.0d ? 0.0d : a * b)
BINARY(pointOr, a == 1.0d || b == 1.0d ? 1.0d : a + b)

EXPORT void pointIf(const uniform double cs[], const uniform double as[], const uniform double bs[], const uniform bool aIsRow,
                    const uniform bool bIsRow, uniform double to[], const uniform int points) {
  const uniform int ai = aIsRow ? 1 : 0, bi = bIsRow ? 1 : 0;
  foreach (i = 0 ... points) {
    double c = cs[i], a, b;
    if (aIsRow) a = as[i];
    else a = as[0];
    if (bIsRow) b = bs[i];
    else b = bs[0];
    to[i] = c == c ? (c != 0.0d ? a : b) : none();
  }
}

// sqrt(a a + b b + c c)
EXPORT void pointMag(const uniform double as[], const uniform double bs[], const uniform double cs[], uniform double to[],
                     const uniform int points) {
  foreach (i = 0 ... points) {
    double a = as[i], b = bs[i], c = cs[i];
    to[i] = sqrt((a * a + b * b) + c * c);
  }
}

// Differences of order 2 along one axis: central, or one-sided where the neighbour on one side has no data; of order 1 where there
// are only two points, and 0 where both neighbours have none. The rows are those two points before to two points behind; `half` is
// 1 / (2 spacing).
EXPORT void pointDifference(const uniform double m2[], const uniform double m1[], const uniform double cs[], const uniform double p1[],
                            const uniform double p2[], const uniform double half, uniform double to[], const uniform int points) {
  foreach (i = 0 ... points) {
    double c = cs[i], a = m1[i], b = p1[i];
    double r = (b - a) * half;
    cif (!((r - r) + (c - c) == 0.0d)) {
      bool before = a - a == 0.0d, behind = b - b == 0.0d;
      double one = 0.0d;
      if (before != behind) {
        double n1 = behind ? b : a, n2 = behind ? p2[i] : m2[i];
        double slope = n1 - c;
        one = n2 - n2 == 0.0d ? (4.0d * slope - (n2 - c)) * half : slope * (2.0d * half);
        one = behind ? one : -one;
      }
      r = before && behind ? r : one;
      r = c - c == 0.0d ? r : none();
    }
    to[i] = r;
  }
}

// Second differences along one axis: central; where one neighbour has no data, the one-sided one of order 2, or of order 1 where
// there are only three points; else 0. `scale` is 1 / spacing^2.
EXPORT void pointSecondDifference(const uniform double m3[], const uniform double m2[], const uniform double m1[],
                                  const uniform double cs[], const uniform double p1[], const uniform double p2[],
                                  const uniform double p3[], const uniform double scale, uniform double to[],
                                  const uniform int points) {
  foreach (i = 0 ... points) {
    double c = cs[i], a = m1[i], b = p1[i];
    double r = ((b - c) - (c - a)) * scale;
    cif (!(r - r == 0.0d && c - c == 0.0d)) {
      bool before = a - a == 0.0d, behind = b - b == 0.0d;
      double n1 = behind ? b : a, n2 = behind ? p2[i] : m2[i], n3 = behind ? p3[i] : m3[i];
      double one = 0.0d;
      if (before != behind && n2 - n2 == 0.0d) {
        double curve = (n2 - n1) - (n1 - c);
        one = curve * scale;
        if (n3 - n3 == 0.0d) one = (2.0d * curve - ((n3 - n2) - (n2 - n1))) * scale;
      }
      r = before && behind ? r : one;
      r = c - c == 0.0d ? r : none();
    }
    to[i] = r;
  }
}

// Replaces infinities by no data.
EXPORT void pointFinite(uniform double row[], const uniform int points) {
  foreach (i = 0 ... points) row[i] = row[i] - row[i] == 0.0d ? row[i] : none();
}

// Values of samples: offset + scale * sample. Infinities are no data. A sample below the least normal float counts as 0, as some
// modes of the processor read it.
static inline double valueOf(double v, const uniform double offset, const uniform double scale) {
  v = abs(v) < 1.1754943508222875e-38d ? 0.0d : v;
  return v - v == 0.0d ? offset + scale * v : none();
}

EXPORT void pointValues(uniform double row[], const uniform double offset, const uniform double scale, const uniform int points) {
  foreach (i = 0 ... points) row[i] = valueOf(row[i], offset, scale);
}

EXPORT void pointValuesOfFloats(const uniform float samples[], const uniform double offset, const uniform double scale,
                                uniform double to[], const uniform int points) {
  foreach (i = 0 ... points) to[i] = valueOf(samples[i], offset, scale);
}

// The same of samples with three components.
EXPORT void pointValuesOfVectors(const uniform float samples[], const uniform double offset, const uniform double scale,
                                 uniform double xs[], uniform double ys[], uniform double zs[], const uniform int points) {
  const uniform int whole = points - points % programCount;
  for (uniform int first = 0; first < whole; first += programCount) {
    float x, y, z;
    aos_to_soa3((uniform float * uniform)samples + 3 * first, &x, &y, &z);
    xs[first + programIndex] = valueOf(x, offset, scale);
    ys[first + programIndex] = valueOf(y, offset, scale);
    zs[first + programIndex] = valueOf(z, offset, scale);
  }
  foreach (i = whole ... points) {
    xs[i] = valueOf(samples[3 * i], offset, scale);
    ys[i] = valueOf(samples[3 * i + 1], offset, scale);
    zs[i] = valueOf(samples[3 * i + 2], offset, scale);
  }
}

// Rounds values to float; what is too large for float, and no data, become NaN.
EXPORT void pointFloats(const uniform double row[], uniform float to[], const uniform int points) {
  foreach (i = 0 ... points) {
    double v = row[i];
    v = abs(v) < 1.1754943508222875e-38d ? 0.0d : v;
    float f = (float)v;
    to[i] = f - f == 0.0f ? f : floatbits(0x7fc00000);
  }
}

// Interleaves the components of vectors.
EXPORT void pointVectors(const uniform float xs[], const uniform float ys[], const uniform float zs[], uniform float to[],
                         const uniform int points) {
  const uniform int whole = points - points % programCount;
  for (uniform int first = 0; first < whole; first += programCount)
    soa_to_aos3(xs[first + programIndex], ys[first + programIndex], zs[first + programIndex], to + 3 * first);
  foreach (i = whole ... points) {
    to[3 * i] = xs[i];
    to[3 * i + 1] = ys[i];
    to[3 * i + 2] = zs[i];
  }
}

// Adds the squares of `values` to those in `squares`, or sets these, and widens extremes[0] to [1] by the values.
EXPORT void pointSquares(const uniform float values[], const uniform bool first, uniform double squares[], uniform double extremes[],
                         const uniform int points) {
  double lo = extremes[0], hi = extremes[1];
  foreach (i = 0 ... points) {
    double v = values[i];
    double before = first ? 0.0d : squares[i];
    squares[i] = before + v * v;
    lo = v < lo ? v : lo;
    hi = v > hi ? v : hi;
  }
  extremes[0] = reduce_min(lo);
  extremes[1] = reduce_max(hi);
}

// Widens extremes[0] to [1] by the values, and returns how many are NaN.
EXPORT uniform int pointExtremes(const uniform double values[], uniform double extremes[], const uniform int points) {
  double lo = extremes[0], hi = extremes[1];
  int bad = 0;
  foreach (i = 0 ... points) {
    double v = values[i];
    bad += v == v ? 0 : 1;
    lo = v < lo ? v : lo;
    hi = v > hi ? v : hi;
  }
  extremes[0] = reduce_min(lo);
  extremes[1] = reduce_max(hi);
  return reduce_add(bad);
}

// -tr(J J) / 2 of a jacobian d u_i / d x_j: half of |rotation|^2 - |strain|^2 (Hunt, Wray, Moin 1988).
EXPORT void pointQ(const uniform double* const uniform j[], uniform double to[], const uniform int points) {
  foreach (i = 0 ... points) {
    double diagonal = (j[0][i] * j[0][i] + j[4][i] * j[4][i]) + j[8][i] * j[8][i];
    double others = (j[1][i] * j[3][i] + j[2][i] * j[6][i]) + j[5][i] * j[7][i];
    to[i] = -0.5d * diagonal - others;
  }
}

// One rotation of Jacobi's method that makes the element pq of a symmetric matrix 0; r is the third index.
static inline void rotate(double& pp, double& qq, double& pq, double& pr, double& qr) {
  double theta = (qq - pp) / (2.0d * pq);
  double t = 1.0d / (abs(theta) + sqrt(theta * theta + 1.0d));
  t = theta < 0.0d ? -t : t;
  t = pq == 0.0d ? 0.0d : t;
  double c = 1.0d / sqrt(t * t + 1.0d);
  double s = t * c;
  pp = pp - t * pq;
  qq = qq + t * pq;
  pq = 0.0d;
  double newPr = c * pr - s * qr;
  qr = s * pr + c * qr;
  pr = newPr;
}

// The middle eigenvalue of the symmetric part of J J, which is S S + W W of strain and rotation (Jeong, Hussain 1995).
EXPORT void pointLambda2(const uniform double* const uniform j[], uniform double to[], const uniform int points) {
  foreach (i = 0 ... points) {
    double a = j[0][i], b = j[1][i], c = j[2][i], d = j[3][i], e = j[4][i], f = j[5][i], g = j[6][i], h = j[7][i], k = j[8][i];
    double xx = (a * a + b * d) + c * g, yy = (d * b + e * e) + f * h, zz = (g * c + h * f) + k * k;
    double xy = 0.5d * (((a * b + b * e) + c * h) + ((d * a + e * d) + f * g));
    double xz = 0.5d * (((a * c + b * f) + c * k) + ((g * a + h * d) + k * g));
    double yz = 0.5d * (((d * c + e * f) + f * k) + ((g * b + h * e) + k * h));
    // Scaled, so that no square overflows or vanishes.
    double largest = max(max(max(abs(xx), abs(yy)), abs(zz)), max(max(abs(xy), abs(xz)), abs(yz)));
    double all = (((xx + yy) + zz) + ((xy + xz) + yz)) * 0.0d;  // NaN if one is
    double size = largest > 0.0d ? largest : 1.0d;
    double s = 1.0d / size;
    xx *= s;
    yy *= s;
    zz *= s;
    xy *= s;
    xz *= s;
    yz *= s;
    for (uniform int sweep = 0; sweep < 5; sweep++) {
      rotate(xx, yy, xy, xz, yz);
      rotate(xx, zz, xz, xy, yz);
      rotate(yy, zz, yz, xy, xz);
    }
    double lo = xx < yy ? xx : yy, hi = xx < yy ? yy : xx;
    double upper = hi < zz ? hi : zz;
    to[i] = (lo > upper ? lo : upper) * size + all;
  }
}
