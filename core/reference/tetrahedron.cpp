// SPDX-License-Identifier: Apache-2.0
#include "core/reference/tetrahedron.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "core/reference/ray_frame.h"

namespace gxy::reference {

/// The corners are sheared so that the ray becomes the axis on which it is longest. Each face that the axis goes through gives a point:
/// with the exact signs of the edges these are two or none.
std::optional<std::array<FacePoint, 2>> passageThrough(const Tetrahedron& corners, const Ray& ray) {
  const RayFrame frame(ray);
  std::array<glm::dvec3, 4> seen;
  std::array<double, 4> t;
  for (size_t i = 0; i < 4; i++) {
    seen[i] = frame.sheared(corners[i]);
    t[i] = seen[i].z;
  }
  std::array<std::array<double, 4>, 4> edge{}, side{};
  for (size_t i = 0; i < 4; i++) {
    for (size_t j = i + 1; j < 4; j++) {
      const SeenEdge one(seen[i], seen[j]);
      edge[i][j] = one.area, edge[j][i] = -one.area;
      side[i][j] = one.side, side[j][i] = -one.side;
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

Box boxAround(std::span<const glm::dvec3> corners) {
  Box box;
  for (const glm::dvec3& p : corners) box.extend(p);
  const glm::dvec3 size = box.hi - box.lo, far = glm::max(glm::abs(box.lo), glm::abs(box.hi));
  const double slack = 1e-9 * std::max({size.x, size.y, size.z}) + 0x1p-50 * std::max({far.x, far.y, far.z});
  return {box.lo - slack, box.hi + slack};
}

}  // namespace gxy::reference
