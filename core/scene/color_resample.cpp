// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/scene/colormaps.h"

namespace gxy {
namespace {

/// Appends points between a and b (both excluded) until straight lines in RGB follow the curve of the colour
/// space within the tolerance.
class Refiner {
 public:
  Refiner(const ColorPoint& a, const ColorPoint& b, ColorSpace space, bool wrapHue,
          std::vector<ColorPoint>& out)
      : a_(a), b_(b), space_(space), wrapHue_(wrapHue), out_(out) {}

  void refine() { refine(0, a_.rgb, 1, b_.rgb, 0); }

 private:
  static constexpr double kTolerance = 1.0 / 1024;
  static constexpr int kMinDepth = 1, kMaxDepth = 11;

  glm::dvec3 color(double fraction) const { return interpolate(a_.rgb, b_.rgb, fraction, space_, wrapHue_); }

  bool straight(double f0, const glm::dvec3& c0, double f1, const glm::dvec3& c1) const {
    for (int i = 1; i < 8; ++i) {
      const double part = i / 8.0;
      const glm::dvec3 off = color(f0 + (f1 - f0) * part) - (c0 * (1 - part) + c1 * part);
      if (std::max({std::abs(off.r), std::abs(off.g), std::abs(off.b)}) > kTolerance / 2) return false;
    }
    return true;
  }

  void refine(double f0, const glm::dvec3& c0, double f1, const glm::dvec3& c1, int depth) {
    if (depth >= kMaxDepth || (depth >= kMinDepth && straight(f0, c0, f1, c1))) return;
    const double middle = (f0 + f1) / 2;
    const glm::dvec3 c = color(middle);
    refine(f0, c0, middle, c, depth + 1);
    out_.push_back({a_.value * (1 - middle) + b_.value * middle, c});
    refine(middle, c, f1, c1, depth + 1);
  }

  const ColorPoint &a_, &b_;
  ColorSpace space_;
  bool wrapHue_;
  std::vector<ColorPoint>& out_;
};

}  // namespace

ColorMap resampled(const std::vector<ColorPoint>& points, ColorSpace space, bool wrapHue) {
  if (space == ColorSpace::RGB) return {points};
  if (space == ColorSpace::Step) return steppedAbove(points);
  ColorMap map{{points.front()}};
  for (size_t i = 1; i < points.size(); ++i) {
    if (points[i - 1].value < points[i].value) {
      Refiner(points[i - 1], points[i], space, wrapHue, map.points).refine();
    }
    map.points.push_back(points[i]);
  }
  return map;
}

}  // namespace gxy
