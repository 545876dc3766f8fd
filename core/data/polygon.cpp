// SPDX-License-Identifier: Apache-2.0
#include "core/data/polygon.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace gxy {
namespace {

using Triangles = std::vector<std::array<uint32_t, 3>>;

/// Returns Newell's normal. Its length is twice the area.
glm::dvec3 normalOf(std::span<const glm::dvec3> corners) {
  glm::dvec3 normal(0);
  for (size_t i = 1; i + 1 < corners.size(); ++i)
    normal += glm::cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
  return normal;
}

/// Whether no corner turns away from the normal by more than rounding explains.
bool isConvex(std::span<const glm::dvec3> corners, glm::dvec3 normal) {
  const size_t n = corners.size();
  for (size_t i = 0; i < n; ++i) {
    const glm::dvec3 in = corners[i] - corners[(i + n - 1) % n], out = corners[(i + 1) % n] - corners[i];
    const double turn = glm::dot(normal, glm::cross(in, out));
    if (turn < -1e-9 * glm::length(normal) * glm::length(in) * glm::length(out)) return false;
  }
  return true;
}

/// Whether a convex quad is cut from corner 1 to 3 instead of from 0 to 2: it is not planar, and that
/// diagonal is shorter.
bool isCutFromOne(std::span<const glm::dvec3> q, glm::dvec3 normal) {
  const glm::dvec3 first = q[2] - q[0], second = q[3] - q[1];
  const double volume = std::abs(glm::dot(glm::cross(q[1] - q[0], first), q[3] - q[0]));
  const bool planar = volume <= 1e-6 * glm::length(normal) * glm::length(first);
  return !planar && glm::dot(second, second) < glm::dot(first, first);
}

/// Ear clipping of a polygon, projected along the largest component of its normal.
class EarClipping {
 public:
  EarClipping(std::span<const glm::dvec3> corners, glm::dvec3 normal)
      : next_(corners.size()), previous_(next_) {
    const glm::dvec3 size(std::abs(normal.x), std::abs(normal.y), std::abs(normal.z));
    const int dropped = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
    const int u = (dropped + 1) % 3, v = (dropped + 2) % 3;
    const double side = normal[dropped] < 0 ? -1 : 1;
    const uint32_t n = uint32_t(corners.size());
    for (uint32_t i = 0; i < n; ++i) {
      flat_.push_back({corners[i][u] - corners[0][u], side * (corners[i][v] - corners[0][v])});
      next_[i] = (i + 1) % n;
      previous_[i] = (i + n - 1) % n;
    }
    for (uint32_t i = 0; i < n; ++i)
      if (!(area(previous_[i], i, next_[i]) > 0)) reflex_.push_back(i);
    std::sort(reflex_.begin(), reflex_.end(), [&](uint32_t a, uint32_t b) {
      return flat_[a].x != flat_[b].x ? flat_[a].x < flat_[b].x : a < b;
    });
    tests_ = uint64_t(n) * 1000;
  }

  void run(Triangles& triangles) {
    uint32_t left = uint32_t(next_.size()), at = 0, failed = 0;
    while (left > 2) {
      if (left > 3 && failed < left && !isEar(at)) {
        at = next_[at];
        ++failed;
        continue;
      }
      triangles.push_back({previous_[at], at, next_[at]});
      next_[previous_[at]] = next_[at];
      previous_[next_[at]] = previous_[at];
      const uint32_t after = next_[at];
      next_[at] = previous_[at] = at;
      at = after;
      failed = 0;
      --left;
    }
  }

 private:
  /// Twice the area of a triangle, positive if it turns as the polygon does.
  double area(uint32_t a, uint32_t b, uint32_t c) const {
    const glm::dvec2 p = flat_[b] - flat_[a], q = flat_[c] - flat_[a];
    return p.x * q.y - p.y * q.x;
  }

  /// Whether the triangle of a corner and its neighbours is an ear: it turns as the polygon does, and
  /// contains no reflex corner. Reflex corners at the position of one of its own corners do not count.
  bool isEar(uint32_t i) {
    const uint32_t a = previous_[i], c = next_[i];
    if (!(area(a, i, c) > 0)) return false;
    const double from = std::min({flat_[a].x, flat_[i].x, flat_[c].x}),
                 to = std::max({flat_[a].x, flat_[i].x, flat_[c].x});
    auto p = std::lower_bound(reflex_.begin(), reflex_.end(), from,
                              [&](uint32_t corner, double x) { return flat_[corner].x < x; });
    for (; p != reflex_.end() && flat_[*p].x <= to; ++p) {
      if (tests_ == 0) return true;
      --tests_;
      if (next_[*p] == *p || *p == a || *p == i || *p == c) continue;
      if (flat_[*p] == flat_[a] || flat_[*p] == flat_[i] || flat_[*p] == flat_[c]) continue;
      if (area(previous_[*p], *p, next_[*p]) > 0) continue;  // no longer reflex: a neighbour was clipped
      if (area(a, i, *p) >= 0 && area(i, c, *p) >= 0 && area(c, a, *p) >= 0) return false;
    }
    return true;
  }

  std::vector<glm::dvec2> flat_;
  /// next_ and previous_ link the corners that are left; a clipped corner links to itself. reflex_ is sorted by x.
  std::vector<uint32_t> next_, previous_, reflex_;
  uint64_t tests_ = 0;  ///< number of tests left
};

}  // namespace

void triangulate(std::span<const glm::dvec3> corners, Triangles& triangles) {
  const auto n = uint32_t(corners.size());
  if (n < 3) return;
  if (n == 3) return triangles.push_back({0, 1, 2});
  const glm::dvec3 normal = normalOf(corners);
  const double length = glm::length(normal);
  if (!(length > 0) || !std::isfinite(length) || isConvex(corners, normal)) {
    if (n == 4 && length > 0 && isCutFromOne(corners, normal)) {
      triangles.insert(triangles.end(), {{0, 1, 3}, {1, 2, 3}});
      return;
    }
    for (uint32_t i = 1; i + 1 < n; ++i) triangles.push_back({0, i, i + 1});
    return;
  }
  EarClipping(corners, normal).run(triangles);
}

}  // namespace gxy
