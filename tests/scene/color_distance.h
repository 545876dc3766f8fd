// SPDX-License-Identifier: Apache-2.0
// How far colours are apart, and what 8 bits can tell.
#pragma once
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

namespace gxy {

constexpr double kLevel = 1.0 / 255;

inline double distance(const glm::dvec3& a, const glm::dvec3& b) {
  return std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
}

}  // namespace gxy
