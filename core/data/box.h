// SPDX-License-Identifier: Apache-2.0
// Axis-aligned boxes and value ranges.
#pragma once
#include <algorithm>
#include <glm/vec3.hpp>
#include <limits>

namespace gxy {

/// An axis-aligned box in world coordinates, closed on both sides. A default box is empty (lo > hi).
struct Box {
  glm::dvec3 lo{std::numeric_limits<double>::infinity()};
  glm::dvec3 hi{-std::numeric_limits<double>::infinity()};

  bool empty() const { return !(lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z); }
  void extend(glm::dvec3 p) {
    lo = glm::dvec3(std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z));
    hi = glm::dvec3(std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z));
  }
  void extend(const Box& b) {
    if (!b.empty()) {
      extend(b.lo);
      extend(b.hi);
    }
  }
  bool overlaps(const Box& b) const {
    return lo.x <= b.hi.x && b.lo.x <= hi.x && lo.y <= b.hi.y && b.lo.y <= hi.y && lo.z <= b.hi.z &&
           b.lo.z <= hi.z;
  }
  bool operator==(const Box&) const = default;
};

/// The closed interval of the finite values of a field. It is empty (min > max) if there are none.
struct Range {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();

  bool empty() const { return !(min <= max); }
  /// Widens the range to contain x. NaN and infinities are ignored.
  void extend(double x) {
    if (x - x == 0) {
      min = std::min(min, x);
      max = std::max(max, x);
    }
  }
  void extend(const Range& r) {
    min = std::min(min, r.min);
    max = std::max(max, r.max);
  }
  bool operator==(const Range&) const = default;
};

}  // namespace gxy
