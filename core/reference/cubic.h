// SPDX-License-Identifier: Apache-2.0
// Cubic polynomials in Bernstein form. A trilinear field is one along a ray inside a cell.
#pragma once
#include <algorithm>
#include <array>

namespace gxy::reference {

/// Linear interpolation that is exact at w = 0, w = 1 and for a == b.
inline double mix(double a, double b, double w) { return w < 0.5 ? a + w * (b - a) : b - (1 - w) * (b - a); }

/// A cubic on [0, 1] by its Bernstein coefficients, which bound it: min(b) <= value(s) <= max(b). b[0] and
/// b[3] are its values at the ends, and value(0), value(1) return them exactly.
struct Cubic {
  std::array<double, 4> b{};

  double value(double s) const;
  double derivative(double s) const;
  double min() const { return *std::min_element(b.begin(), b.end()); }
  double max() const { return *std::max_element(b.begin(), b.end()); }
  Cubic minus(double v) const { return {{b[0] - v, b[1] - v, b[2] - v, b[3] - v}}; }
};

/// At most three parameters, ascending.
struct Roots {
  std::array<double, 3> s{};
  int count = 0;
  const double* begin() const { return s.data(); }
  const double* end() const { return s.data() + count; }
};

/// The parameters inside (0, 1) at which the derivative vanishes.
Roots extrema(const Cubic& cubic);

/// The parameters inside (0, 1) at which the cubic takes the value v, to full double precision. The cubic is
/// split at its extrema, and each monotone piece with a change of sign holds one root, which is found by
/// Newton's method kept in its bracket by bisection. An extremum that equals v is a root. A cubic that is v
/// everywhere has none.
Roots roots(const Cubic& cubic, double v);

}  // namespace gxy::reference
