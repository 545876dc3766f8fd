// SPDX-License-Identifier: Apache-2.0
#include "core/reference/cubic.h"

#include <cmath>
#include <utility>

namespace gxy::reference {

double Cubic::value(double s) const {
  const double p = mix(b[0], b[1], s), q = mix(b[1], b[2], s), r = mix(b[2], b[3], s);
  return mix(mix(p, q, s), mix(q, r, s), s);
}

double Cubic::derivative(double s) const {
  const double p = b[1] - b[0], q = b[2] - b[1], r = b[3] - b[2];
  return 3 * mix(mix(p, q, s), mix(q, r, s), s);
}

Roots extrema(const Cubic& c) {
  const double d0 = c.b[1] - c.b[0], d1 = c.b[2] - c.b[1], d2 = c.b[3] - c.b[2];
  const double square = d0 - 2 * d1 + d2, half = d1 - d0;  // square s^2 + 2 half s + d0 = 0
  Roots found;
  const double discriminant = half * half - square * d0;
  if (!(discriminant >= 0)) return found;
  const double q = -(half + std::copysign(std::sqrt(discriminant), half));
  double first = square != 0 ? q / square : -1, second = q != 0 ? d0 / q : -1;
  if (first > second) std::swap(first, second);
  if (first > 0 && first < 1) found.s[found.count++] = first;
  if (second > 0 && second < 1 && second != first) found.s[found.count++] = second;
  return found;
}

namespace {

/// The root of f in [lo, hi], whose ends differ in sign.
double bracketedRoot(const Cubic& f, double lo, double hi) {
  const bool rising = f.value(lo) < 0;
  double s = 0.5 * (lo + hi);
  for (int i = 0; i < 200; i++) {
    const double y = f.value(s);
    if (y == 0) return s;
    ((y < 0) == rising ? lo : hi) = s;
    const double newton = s - y / f.derivative(s);
    // Newton alone may creep from one side; every third step bisects.
    const double next = newton > lo && newton < hi && i % 3 != 2 ? newton : 0.5 * (lo + hi);
    if (next == s || !(next > lo && next < hi)) return s;
    s = next;
  }
  return s;
}

}  // namespace

Roots roots(const Cubic& cubic, double v) {
  Roots found;
  const Cubic f = cubic.minus(v);
  if (f.min() > 0 || f.max() < 0) return found;
  const Roots turns = extrema(f);
  double lo = 0, atLo = f.b[0];
  for (int i = 0; i <= turns.count && found.count < 3; i++) {
    const double hi = i < turns.count ? turns.s[i] : 1;
    const double atHi = i < turns.count ? f.value(hi) : f.b[3];
    if ((atLo < 0 && atHi > 0) || (atLo > 0 && atHi < 0)) {
      found.s[found.count++] = bracketedRoot(f, lo, hi);
    } else if (atHi == 0 && atLo != 0 && hi < 1) {
      found.s[found.count++] = hi;
    }
    lo = hi;
    atLo = atHi;
  }
  return found;
}

}  // namespace gxy::reference
