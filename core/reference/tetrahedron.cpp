// SPDX-License-Identifier: Apache-2.0
#include "core/reference/tetrahedron.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

namespace gxy::reference {
namespace {

/// a d - b c to within two ulps of the result, so that its sign is that of the exact number (Jeannerod, Louvet and Muller 2013, after
/// Kahan).
double determinant(double a, double b, double c, double d) {
  const double product = b * c;
  return std::fma(a, d, -product) - std::fma(b, c, -product);
}

}  // namespace

/// The corners are sheared so that the ray becomes the axis on which it is longest. Each face that the axis goes through gives a point:
/// with the exact signs of the edges these are two or none.
std::optional<std::array<FacePoint, 2>> passageThrough(const Tetrahedron& corners, const Ray& ray) {
  const glm::dvec3 d = ray.direction;
  int z = std::abs(d.x) >= std::abs(d.y) ? 0 : 1;
  if (std::abs(d.z) > std::abs(d[z])) z = 2;
  const int x = (z + 1) % 3, y = (z + 2) % 3;
  const double sx = d[x] / d[z], sy = d[y] / d[z];
  std::array<double, 4> px, py, t;
  for (size_t i = 0; i < 4; i++) {
    const glm::dvec3 p = corners[i] - ray.origin;
    px[i] = p[x] - sx * p[z];
    py[i] = p[y] - sy * p[z];
    t[i] = p[z] / d[z];
  }
  std::array<std::array<double, 4>, 4> edge{}, side{};
  for (size_t i = 0; i < 4; i++) {
    for (size_t j = i + 1; j < 4; j++) {
      const double e = determinant(px[i], py[i], px[j], py[j]);
      // A ray that meets an edge counts as one beside it: a little to x, and less to y.
      const double s = e != 0 ? e : py[i] != py[j] ? py[i] - py[j] : px[j] - px[i];
      edge[i][j] = e, edge[j][i] = -e;
      side[i][j] = s, side[j][i] = -s;
    }
  }
  std::array<FacePoint, 2> points{};
  size_t met = 0;
  for (size_t out = 0; out < 4; out++) {
    // in ascending order, in which both cells of the face have them
    const size_t a = out == 0 ? 1 : 0, b = out <= 1 ? 2 : 1, c = out <= 2 ? 3 : 2;
    const bool above = side[a][b] > 0 && side[b][c] > 0 && side[c][a] > 0;
    const bool below = side[a][b] < 0 && side[b][c] < 0 && side[c][a] < 0;
    if (!above && !below) continue;
    const double sum = edge[a][b] + edge[b][c] + edge[c][a];
    if (sum == 0 || met == 2) return std::nullopt;
    // All three have the same sign, so nothing cancels even in a face that the ray meets nearly edge-on.
    FacePoint& point = points[met++];
    point.weights[a] = edge[b][c] / sum;
    point.weights[b] = edge[c][a] / sum;
    point.weights[c] = edge[a][b] / sum;
    point.t = point.mean(t);
  }
  if (met < 2) return std::nullopt;
  if (points[0].t > points[1].t) std::swap(points[0], points[1]);
  return points;
}

Box boxAround(const Tetrahedron& corners) {
  Box box;
  for (const glm::dvec3& p : corners) box.extend(p);
  const glm::dvec3 size = box.hi - box.lo, far = glm::max(glm::abs(box.lo), glm::abs(box.hi));
  const double slack = 1e-9 * std::max({size.x, size.y, size.z}) + 0x1p-50 * std::max({far.x, far.y, far.z});
  return {box.lo - slack, box.hi + slack};
}

}  // namespace gxy::reference
