// SPDX-License-Identifier: Apache-2.0
// exp, log, sin, cos, tan, atan2 and powers of rows of points, in double, with the same bits for every instruction set: there are
// only + - * /, comparisons and bit operations. Errors in units of the last place (ulp), against a wider type:
//
// - exp, log, power: within 1
// - sin, cos: within 1 for |x| < 2^30, where no digits are lost; NaN (no data) beyond
// - tan: within 3, in the same range
// - atan2: within 2
//
// Arguments without a result give NaN: log of what is not above 0, a negative number to the power of a fraction, 0 to a negative
// power. Method: argument reduction with a split constant (Cody & Waite, Software Manual for the Elementary Functions, 1980),
// then a Taylor polynomial; the logarithm is twice the series of the inverse hyperbolic tangent. Sums and products with their
// rounding errors: Knuth, The Art of Computer Programming vol. 2, 4.2.2; Dekker, Numerische Mathematik 18, 1971.
#include "core/kernels/export.h"

static inline double none() { return doublebits(0x7ff8000000000000); }

// 1.5 * 2^52: adding it rounds to an integer, which is then in the low bits.
#define ROUNDER 6755399441055744.0d

// a + b = sum + lost, exactly.
static inline void twoSum(double a, double b, double& sum, double& lost) {
  sum = a + b;
  double bb = sum - a;
  lost = (a - (sum - bb)) + (b - bb);
}

// a * b - product, exactly, where `product` is the rounded product and nothing overflows.
static inline double productError(double a, double b, double product) {
  double ca = 134217729.0d * a, cb = 134217729.0d * b;
  double aHigh = ca - (ca - a), bHigh = cb - (cb - b);
  double aLow = a - aHigh, bLow = b - bHigh;
  return aLow * bLow - (((product - aHigh * bHigh) - aLow * bHigh) - aHigh * bLow);
}

// 2^n for an integer n in [-1022, 1023].
static inline double powerOfTwo(double n) { return doublebits((intbits(n + ROUNDER) + 1023) << 52); }

// e^(x + low) for |low| far below |x|.
static inline double expOf(double x, double low) {
  double inside = x > -746.0d ? x : -746.0d;
  inside = inside < 710.0d ? inside : 710.0d;
  double l = inside == x ? low : 0.0d;
  double n = (inside * 1.4426950408889634d + ROUNDER) - ROUNDER;
  double high = inside - n * 0.6931471803691238d, lower = n * 1.9082149292705877e-10d;
  double r = high - lower;
  l = l + ((high - r) - lower);
  double p = 1.6059043836821613e-10d;
  p = 2.08767569878681e-09d + r * p;
  p = 2.505210838544172e-08d + r * p;
  p = 2.755731922398589e-07d + r * p;
  p = 2.7557319223985893e-06d + r * p;
  p = 2.48015873015873e-05d + r * p;
  p = 0.0001984126984126984d + r * p;
  p = 0.001388888888888889d + r * p;
  p = 0.008333333333333333d + r * p;
  p = 0.041666666666666664d + r * p;
  p = 0.16666666666666666d + r * p;
  p = 0.5d + r * p;
  double tail = (r * r) * p;
  tail = tail + (l + l * (r + tail));
  double one = 1.0d + r;
  one = one + ((r - (one - 1.0d)) + tail);
  double half = floor(n * 0.5d);  // In two steps, as 2^n need not be a normal number.
  double e = (one * powerOfTwo(half)) * powerOfTwo(n - half);
  return x == x ? e : none();
}

// ln x = high + low to 64 bits, for finite x > 0.
static inline void logOf(double x, double& high, double& low) {
  double normal = x < 2.2250738585072014e-308d ? x * 18014398509481984.0d : x;
  int64 bits = intbits(normal) + (0x3ff0000000000000 - 0x3fe6a09e667f3bcd);
  double k = (double)((int)(bits >> 52) - 1023) - (x < 2.2250738585072014e-308d ? 54.0d : 0.0d);
  double m = doublebits((bits & 0x000fffffffffffff) + 0x3fe6a09e667f3bcd);  // in [sqrt(1/2), sqrt(2))
  double f = m - 1.0d;                                                      // exact
  double d, dLow;
  twoSum(2.0d, f, d, dLow);
  double s = f / d;
  double sd = s * d;
  double sLow = (((f - sd) - productError(s, d, sd)) - s * dLow) / d;
  double z = s * s;
  double zLow = productError(s, s, z) + 2.0d * s * sLow;
  double t = 0.037037037037037035d;  // 1/27, 1/25, ... 1/5
  t = 0.04d + z * t;
  t = 0.043478260869565216d + z * t;
  t = 0.047619047619047616d + z * t;
  t = 0.05263157894736842d + z * t;
  t = 0.058823529411764705d + z * t;
  t = 0.06666666666666667d + z * t;
  t = 0.07692307692307693d + z * t;
  t = 0.09090909090909091d + z * t;
  t = 0.1111111111111111d + z * t;
  t = 0.14285714285714285d + z * t;
  t = 0.2d + z * t;
  double a, aLow;
  twoSum(0.3333333333333333d, z * t, a, aLow);
  aLow = aLow + 1.850371707708594e-17d;
  double w = z * a;
  double wLow = productError(z, a, w) + (z * aLow + zLow * a);
  double c = s * w;
  double cLow = productError(s, w, c) + (s * wLow + sLow * w);
  double h, hLow;
  twoSum(s, c, h, hLow);
  hLow = (hLow + (sLow + cLow)) * 2.0d;
  double sum, sumLow;
  twoSum(k * 0.6931471805598903d, 2.0d * h, sum, sumLow);
  sumLow = sumLow + (hLow + k * 5.497923018708371e-14d);
  high = sum + sumLow;
  low = (sum - high) + sumLow;
}

static inline double logOf1(double x) {
  double high, low;
  bool finite = x > 0.0d && x < doublebits(0x7ff0000000000000);
  logOf(finite ? x : 1.0d, high, low);
  return finite ? high : x > 0.0d ? x : none();
}

static inline double powerOf(double x, double y) {
  double size = abs(x);
  bool finite = size > 0.0d && size < doublebits(0x7ff0000000000000);
  double high, low;
  logOf(finite ? size : 1.0d, high, low);
  // Beyond 2^64 the result is 0, 1 or infinity.
  double z = y < 18446744073709551616.0d ? y : 18446744073709551616.0d;
  z = z > -18446744073709551616.0d ? z : -18446744073709551616.0d;
  double p = z * high;
  double r = expOf(p, productError(z, high, p) + z * low);
  bool whole = floor(y) == y;
  bool odd = whole && floor(y * 0.5d) * 2.0d != y;
  r = x < 0.0d ? (whole ? (odd ? -r : r) : none()) : r;
  double ofInfinity = y > 0.0d ? (x < 0.0d && odd ? -size : size) : 0.0d;
  r = finite ? r : size == 0.0d ? (y > 0.0d ? 0.0d : none()) : ofInfinity;
  r = y == 0.0d ? 1.0d : r;
  return x == x && y == y ? r : none();
}

// x = quadrant * pi / 2 + high + low, for |x| < 2^30. The first three products are exact.
static inline void reduce(double x, int& quadrant, double& high, double& low) {
  double shifted = x * 0.6366197723675814d + ROUNDER;
  double n = shifted - ROUNDER;
  quadrant = (int)(intbits(shifted) & 3);
  double r = (x - n * 1.570796251296997d) - n * 7.549789415861596e-08d;
  double sum, lost;
  twoSum(r, -(n * 5.39030083589187e-15d), sum, lost);
  lost = lost - n * 2.0222662487959506e-21d;
  high = sum + lost;
  low = (sum - high) + lost;
}

static inline void sinCosOf(double x, double& s, double& c) {
  bool inside = abs(x) < 1073741824.0d;
  double h, l;
  int quadrant;
  reduce(inside ? x : 0.0d, quadrant, h, l);
  double z = h * h;
  double p = 2.8114572543455206e-15d;
  p = -7.647163731819816e-13d + z * p;
  p = 1.6059043836821613e-10d + z * p;
  p = -2.505210838544172e-08d + z * p;
  p = 2.7557319223985893e-06d + z * p;
  p = -0.0001984126984126984d + z * p;
  p = 0.008333333333333333d + z * p;
  p = -0.16666666666666666d + z * p;
  double sine = h + ((h * z) * p + l * (1.0d - 0.5d * z));
  double q = 4.779477332387385e-14d;
  q = -1.1470745597729725e-11d + z * q;
  q = 2.08767569878681e-09d + z * q;
  q = -2.755731922398589e-07d + z * q;
  q = 2.48015873015873e-05d + z * q;
  q = -0.001388888888888889d + z * q;
  q = 0.041666666666666664d + z * q;
  double half = 0.5d * z;
  double t = 1.0d - half;
  double cosine = t + (((1.0d - t) - half) + ((z * z) * q - h * l));
  bool swapped = (quadrant & 1) != 0;
  double a = swapped ? cosine : sine, b = swapped ? sine : cosine;
  s = inside ? (quadrant >= 2 ? -a : a) : none();
  c = inside ? (quadrant == 1 || quadrant == 2 ? -b : b) : none();
}

static inline double atan2Of(double y, double x) {
  double ay = abs(y), ax = abs(x);
  bool steep = ay > ax;
  double lo = steep ? ax : ay, hi = steep ? ay : ax;
  // tan(pi / 8): beyond it, the angle to the diagonal
  bool diagonal = lo > 0.41421356237309503d * hi;
  double top = diagonal ? lo - hi : lo, bottom = diagonal ? lo + hi : hi;
  double t = bottom > 0.0d ? top / bottom : 0.0d;
  double z = t * t;
  double p = 0.024390243902439025d;  // 1/41, -1/39, ... -1/3
  p = -0.02564102564102564d + z * p;
  p = 0.02702702702702703d + z * p;
  p = -0.02857142857142857d + z * p;
  p = 0.030303030303030304d + z * p;
  p = -0.03225806451612903d + z * p;
  p = 0.034482758620689655d + z * p;
  p = -0.037037037037037035d + z * p;
  p = 0.04d + z * p;
  p = -0.043478260869565216d + z * p;
  p = 0.047619047619047616d + z * p;
  p = -0.05263157894736842d + z * p;
  p = 0.058823529411764705d + z * p;
  p = -0.06666666666666667d + z * p;
  p = 0.07692307692307693d + z * p;
  p = -0.09090909090909091d + z * p;
  p = 0.1111111111111111d + z * p;
  p = -0.14285714285714285d + z * p;
  p = 0.2d + z * p;
  p = -0.3333333333333333d + z * p;
  double angle = t + (t * z) * p;
  // The angle from the nearest multiple of pi / 4, counted from the positive x axis.
  bool left = x < 0.0d;
  int m = diagonal ? (left ? 3 : 1) : steep ? 2 : left ? 4 : 0;
  angle = steep != left ? -angle : angle;
  double high = m == 0 ? 0.0d : m == 1 ? 0.7853981633974483d : m == 2 ? 1.5707963267948966d : m == 3 ? 2.356194490192345d : 3.141592653589793d;
  double low = m == 0 ? 0.0d : m == 1 ? 3.061616997868383e-17d : m == 2 ? 6.123233995736766e-17d : m == 3 ? 9.184850993605148e-17d : 1.2246467991473532e-16d;
  double r = high + (angle + low);
  r = y < 0.0d ? -r : r;
  return x == x && y == y ? r : none();
}

#define UNARY(NAME, RESULT)                                                                     \
  EXPORT void NAME(const uniform double as[], uniform double to[], const uniform int points) {  \
    foreach (i = 0 ... points) {                                                                \
      double a = as[i];                                                                         \
      double s, c;                                                                              \
      RESULT;                                                                                   \
    }                                                                                           \
  }
UNARY(pointExp, to[i] = expOf(a, 0.0d))
UNARY(pointLog, to[i] = logOf1(a))
UNARY(pointSin, sinCosOf(a, s, c); to[i] = s)
UNARY(pointCos, sinCosOf(a, s, c); to[i] = c)
UNARY(pointTan, sinCosOf(a, s, c); to[i] = s / c)

EXPORT void pointPower(const uniform double as[], const uniform double bs[], uniform double to[], const uniform int points) {
  foreach (i = 0 ... points) to[i] = powerOf(as[i], bs[i]);
}
EXPORT void pointAtan2(const uniform double as[], const uniform double bs[], uniform double to[], const uniform int points) {
  foreach (i = 0 ... points) to[i] = atan2Of(as[i], bs[i]);
}
