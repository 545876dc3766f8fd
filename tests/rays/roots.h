// SPDX-License-Identifier: Apache-2.0
// Where a ray meets an isosurface of the trilinear field: in double, cell by cell, without skipping.
#pragma once
#include <algorithm>
#include <array>

#include "tests/rays/field.h"

namespace gxy::test {

struct Root {
  double t;
  double slope;  ///< change of the field per cell length along the ray
  double range;  ///< of the cell's corners
  bool rising;   ///< the field grows along the ray
  bool touches;  ///< does not change sign (a double root, or a plateau's start)
};

/// The ray in index space, exactly as the kernels have it.
struct IndexRay {
  glm::dvec3 o, d;
  double t0 = 0, t1 = 1e30;
};

template <class Ray>
IndexRay indexRay(const Ray& r, const Field& f) {
  IndexRay x{glm::dvec3(r.g.po), glm::dvec3(r.g.pd)};
  const Index3 cells = f.grid.cells();
  for (int k = 0; k < 3; k++) {
    const double n = double(cells[size_t(k)]);
    if (x.d[k] == 0) {
      if (x.o[k] < 0 || x.o[k] >= n) x.t1 = -1;
      continue;
    }
    const double a = -x.o[k] / x.d[k], b = (n - x.o[k]) / x.d[k];
    x.t0 = std::max(x.t0, std::min(a, b));
    x.t1 = std::min(x.t1, std::max(a, b));
  }
  return x;
}

/// All t at which the ray crosses a grid plane, with both ends, ascending.
inline std::vector<double> cellBounds(const IndexRay& r, const Field& f) {
  std::vector<double> t{r.t0, r.t1};
  for (int k = 0; k < 3; k++) {
    if (r.d[k] == 0) continue;
    for (int64_t i = 0; i < f.grid.points[size_t(k)]; i++) {
      const double x = (double(i) - r.o[k]) / r.d[k];
      if (x > r.t0 && x < r.t1) t.push_back(x);
    }
  }
  std::sort(t.begin(), t.end());
  return t;
}

/// The corners of the cell that the middle of [ta, tb] is in, and the field there.
struct Cell {
  std::array<int64_t, 3> index;
  std::array<double, 8> corner;
  bool holdsData = true;
  double lo = 1e300, hi = -1e300;

  Cell(const Field& f, const IndexRay& r, double ta, double tb) {
    const glm::dvec3 p = r.o + 0.5 * (ta + tb) * r.d;
    for (int k = 0; k < 3; k++)
      index[size_t(k)] = std::clamp(int64_t(std::floor(p[k])), int64_t(0), f.grid.points[size_t(k)] - 2);
    for (int i = 0; i < 8; i++) {
      const double x = f.at(index[0] + (i & 1), index[1] + (i >> 1 & 1), index[2] + (i >> 2));
      corner[size_t(i)] = x;
      holdsData = holdsData && std::isfinite(x);
      lo = std::min(lo, x);
      hi = std::max(hi, x);
    }
  }
  double at(glm::dvec3 p) const {
    const double x = p.x - double(index[0]), y = p.y - double(index[1]), z = p.z - double(index[2]);
    auto mix = [](double a, double b, double w) { return a * (1 - w) + b * w; };
    return mix(mix(mix(corner[0], corner[1], x), mix(corner[2], corner[3], x), y),
               mix(mix(corner[4], corner[5], x), mix(corner[6], corner[7], x), y), z);
  }
  /// Of the trilinear field, per cell.
  glm::dvec3 gradient(glm::dvec3 p) const {
    glm::dvec3 g;
    for (int k = 0; k < 3; k++) {
      glm::dvec3 lo = p, hi = p;
      lo[k] = double(index[size_t(k)]), hi[k] = lo[k] + 1;
      g[k] = at(hi) - at(lo);
    }
    return g;
  }
};

/// Roots of field - iso along the ray, ascending: of each cell's cubic, split at its extrema, by bisection.
inline std::vector<Root> rootsAlong(const Field& f, const IndexRay& r, double iso) {
  std::vector<Root> roots;
  if (!(r.t0 < r.t1)) return roots;
  const double cells = glm::length(r.d);
  const std::vector<double> bounds = cellBounds(r, f);
  for (size_t i = 0; i + 1 < bounds.size(); i++) {
    const double ta = bounds[i], tb = bounds[i + 1];
    const Cell cell(f, r, ta, tb);
    if (!cell.holdsData || cell.lo > iso || cell.hi < iso || !(tb > ta)) continue;
    auto value = [&](double u) { return cell.at(r.o + (ta + u * (tb - ta)) * r.d) - iso; };
    // the cubic through four of its values
    const double v0 = value(0), v1 = value(1.0 / 3), v2 = value(2.0 / 3), v3 = value(1);
    const double c1 = -5.5 * v0 + 9 * v1 - 4.5 * v2 + v3, c2 = 9 * v0 - 22.5 * v1 + 18 * v2 - 4.5 * v3;
    const double c3 = -4.5 * v0 + 13.5 * v1 - 13.5 * v2 + 4.5 * v3;
    std::vector<double> split{0};
    const double qa = 3 * c3, qb = 2 * c2, disc = qb * qb - 4 * qa * c1;
    if (disc > 0) {
      const double w = -0.5 * (qb + std::copysign(std::sqrt(disc), qb));
      for (double e : {qa != 0 ? w / qa : -1, w != 0 ? c1 / w : -1})
        if (e > 0 && e < 1) split.push_back(e);
    }
    split.push_back(1);
    std::sort(split.begin(), split.end());
    for (size_t k = 0; k + 1 < split.size(); k++) {
      double lo = split[k], hi = split[k + 1];
      const double fLo = value(lo), fHi = value(hi);
      if (!((fLo < 0 && fHi >= 0) || (fLo > 0 && fHi <= 0))) continue;
      for (int n = 0; n < 60; n++) {
        const double u = 0.5 * (lo + hi);
        ((value(u) < 0) == (fLo < 0) ? lo : hi) = u;
      }
      const double u = hi, slope = (c1 + u * (2 * c2 + u * 3 * c3)) / ((tb - ta) * cells);
      roots.push_back({ta + u * (tb - ta), slope, cell.hi - cell.lo, fLo < 0, fHi == 0});
    }
  }
  return roots;
}

/// The field at t.
inline double fieldAt(const Field& f, const IndexRay& r, double t) {
  return Cell(f, r, t, t).at(r.o + t * r.d);
}

}  // namespace gxy::test
