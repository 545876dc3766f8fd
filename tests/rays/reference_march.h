// SPDX-License-Identifier: Apache-2.0
// Emission and absorption along a ray in double: every cell in many segments, each split where the map has a node.
#pragma once
#include "tests/rays/maps.h"
#include "tests/rays/roots.h"

namespace gxy::test {

struct Picture {
  glm::dvec3 rgb{0};
  double A = 0;
};

/// Adds a piece of length t over which the value goes linearly from s0 to s1, both in one interval of the map.
inline void addPiece(const CompiledMap& map, double s0, double s1, double t, Picture& p) {
  const double middle = 0.5 * (s0 + s1);
  const int k = int(std::upper_bound(map.nodes.begin() + 1, map.nodes.end(), middle) - map.nodes.begin()) - 1;
  const float* m = &map.pieces[size_t(8 * k)];
  const double f0 = (s0 - map.nodes[size_t(k)]) * map.spans[4 * size_t(k) + 1],
               f1 = (s1 - map.nodes[size_t(k)]) * map.spans[4 * size_t(k) + 1];
  const double a = m[0] + f0 * m[1], b = m[0] + f1 * m[1], sigma = 0.5 * (a + b);
  if (!(sigma > 0)) return;
  const double tau = sigma * t, w = -(1 - p.A) * std::expm1(-tau);
  // the mean place of what is seen of the piece: its middle if thin, its front if dense
  const double thin = 0.5 - tau / 12, dense = (1 - (1 + tau) * std::exp(-tau)) / tau / -std::expm1(-tau);
  const double place = (tau < 1e-3 ? thin : dense) + (b - a) / sigma / 12;
  for (int c = 0; c < 3; c++) {
    const double c0 = m[2 + 2 * c] + f0 * m[3 + 2 * c], c1 = m[2 + 2 * c] + f1 * m[3 + 2 * c];
    p.rgb[c] += w * (c0 + place * (c1 - c0));
  }
  p.A += w;
}

inline Picture referenceMarch(const Field& f, const IndexRay& r, const CompiledMap& map, int perCell = 24) {
  Picture p;
  if (!(r.t0 < r.t1)) return p;
  const std::vector<double> bounds = cellBounds(r, f);
  std::vector<double> splits;
  for (size_t i = 0; i + 1 < bounds.size(); i++) {
    const double ta = bounds[i], step = (bounds[i + 1] - ta) / perCell;
    if (!(step > 0)) continue;
    const Cell cell(f, r, ta, bounds[i + 1]);
    if (!cell.holdsData) continue;
    double s0 = cell.at(r.o + ta * r.d);
    for (int k = 0; k < perCell; k++) {
      const double s1 = cell.at(r.o + (ta + (k + 1) * step) * r.d);
      splits = {0, 1};
      const auto first = std::upper_bound(map.nodes.begin() + 1, map.nodes.end(), std::min(s0, s1));
      for (auto n = first; n != map.nodes.end() && *n < std::max(s0, s1); ++n)
        splits.push_back((*n - s0) / (s1 - s0));
      std::sort(splits.begin(), splits.end());
      for (size_t j = 0; j + 1 < splits.size(); j++)
        addPiece(map, s0 + splits[j] * (s1 - s0), s0 + splits[j + 1] * (s1 - s0),
                 (splits[j + 1] - splits[j]) * step, p);
      s0 = s1;
    }
  }
  return p;
}

/// The largest difference of a channel.
template <class Radiance>
double difference(const Radiance& L, const Picture& p) {
  double d = std::abs(double(L.A) - p.A);
  for (int c = 0; c < 3; c++) d = std::max(d, std::abs(double(L.rgb[c]) - p.rgb[c]));
  return d;
}

}  // namespace gxy::test
