// SPDX-License-Identifier: Apache-2.0
#include "core/reference/cell_face.h"

#include <cmath>
#include <optional>

#include "core/reference/ray_frame.h"

namespace gxy::reference {
namespace {

/// The exact number of times that a polygon runs counterclockwise around the ray: how often its edges cross the half-line to +x upwards,
/// less how often they cross it downwards.
int windingOf(std::span<const glm::dvec3> polygon) {
  int winding = 0;
  for (size_t i = 0; i < polygon.size(); i++) {
    const glm::dvec3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const bool low = p.y > 0, high = q.y > 0;
    if (low == high) continue;
    const double side = SeenEdge(p, q).side;
    if (high && side > 0) winding++;
    if (low && side < 0) winding--;
  }
  return winding;
}

/// The coefficients of a quadratic in Bernstein form: c0 (1 - s)^2 + 2 c1 s (1 - s) + c2 s^2.
struct Quadratic {
  double c0, c1, c2;

  /// The root at which the derivative is 2 `slope`, with slope^2 = c1^2 - c0 c2. Nothing cancels if it is in [0, 1]. It may be infinite;
  /// there is none if any number is one.
  std::optional<double> rootAt(double slope) const {
    // s / (1 - s) is far / c2 and also c0 / near.
    const double far = slope - c1, near = -c1 - slope;
    const double s = std::abs(far) >= std::abs(near) ? far / (far + c2) : c0 / (c0 + near);
    return std::isnan(s) ? std::nullopt : std::optional(s);
  }
};

struct PatchPoint {
  double u, v;
  /// How far it is inside the unit square; negative outside.
  double depth() const { return std::min(std::min(u, 1 - u), std::min(v, 1 - v)); }
};

/// The points of a bilinear patch, of corners (0, 0), (1, 0), (1, 1) and (0, 1), on the ray. The ray is on the line between the points
/// of two opposite edges at u, which is a quadratic equation, and the same holds at v. Both have the same discriminant: half the Jacobian
/// of the patch there, as the ray sees it.
class PatchRoots {
 public:
  explicit PatchRoots(const std::array<glm::dvec3, 4>& q) : q_(q) {
    const auto cross = [&](int i, int j) {
      return determinant(q[size_t(i)].x, q[size_t(i)].y, q[size_t(j)].x, q[size_t(j)].y);
    };
    const double diagonal = cross(0, 2), other = cross(1, 3);
    alongU_ = {cross(0, 3), 0.5 * (diagonal + other), cross(1, 2)};
    alongV_ = {cross(0, 1), 0.5 * (diagonal - other), cross(3, 2)};
    square_ = determinant(alongU_.c1, alongU_.c0, alongU_.c2, alongU_.c1);
  }
  /// Whether there are two.
  bool areTwo() const { return square_ > 0; }

  /// The point that runs around the ray in the direction of `sign`.
  PatchPoint at(int sign) const {
    const double slope = sign * std::sqrt(std::max(0.0, square_));
    PatchPoint p{0.5, 0.5};
    const auto u = alongU_.rootAt(slope), v = alongV_.rootAt(-slope);
    if (u) p.u = *u;
    if (v) p.v = *v;
    // Here the ray is one of the patch's lines. One that is moved a little to x meets it where the patch has the same y.
    if (!u && v) p.u = levelAt(q_[0].y, q_[1].y, q_[3].y, q_[2].y);
    if (u && !v) p.v = levelAt(q_[0].y, q_[3].y, q_[1].y, q_[2].y);
    return p;
  }

 private:
  /// Where a line from a difference of y of `b - a` to one of `d - c` has none.
  static double levelAt(double a, double c, double b, double d) {
    const double low = b - a, high = d - c;
    return low != high ? low / (low - high) : 0.5;
  }
  std::array<glm::dvec3, 4> q_;
  Quadratic alongU_, alongV_;
  double square_;
};

/// A face in an order that depends on the numbers of its points alone: from the lowest to the lower one of its neighbours.
struct OrderedFace {
  std::array<uint8_t, 4> corner;
  int turn;  ///< -1 if it runs the other way round than the cell's
};

OrderedFace ordered(const CellFace& face, std::span<const uint32_t> numbers) {
  const size_t n = face.corners;
  const auto number = [&](size_t i) { return numbers[face.corner[i % n]]; };
  size_t first = 0;
  for (size_t i = 1; i < n; i++)
    if (number(i) < number(first)) first = i;
  const bool forward = number(first + 1) < number(first + n - 1);
  OrderedFace result{{}, forward ? 1 : -1};
  for (size_t i = 0; i < n; i++) result.corner[i] = face.corner[(forward ? first + i : first + n - i) % n];
  return result;
}

}  // namespace

double FaceMeeting::mean(const OfCorners& values) const {
  double sum = 0, low = kInfinity, high = -kInfinity;
  for (size_t i = 0; i < corners; i++) {
    if (weights[i] == 0) continue;
    const double value = values[corner[i]];
    sum += weights[i] * value;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  return std::clamp(sum, low, high);
}

FaceMeetings meet(const CellFace& face, std::span<const glm::dvec3> seen, std::span<const uint32_t> numbers) {
  const OrderedFace in = ordered(face, numbers);
  std::array<glm::dvec3, 4> q{};
  OfCorners t{};
  for (size_t i = 0; i < face.corners; i++) {
    q[i] = seen[in.corner[i]];
    t[in.corner[i]] = q[i].z;
  }
  FaceMeetings found;
  const auto add = [&](int sign, const std::array<double, 4>& weights) {
    FaceMeeting& one = found.meeting[found.count++];
    one = {0, sign * in.turn, face.corners, in.corner, weights};
    one.t = one.mean(t);
  };
  const int winding = windingOf(std::span(q).first(face.corners));
  if (face.corners == 3) {
    if (winding == 0) return found;
    const double ab = SeenEdge(q[0], q[1]).area, bc = SeenEdge(q[1], q[2]).area,
                 ca = -SeenEdge(q[0], q[2]).area;
    const double sum = ab + bc + ca;
    // All three have the same sign, so nothing cancels.
    const double third = 1 / 3.0;
    add(winding, sum != 0 ? std::array<double, 4>{bc / sum, ca / sum, ab / sum}
                          : std::array{third, third, third, 0.0});
    return found;
  }
  const PatchRoots roots(q);
  const auto addPoint = [&](int sign, const PatchPoint& p) {
    const double u = std::clamp(p.u, 0.0, 1.0), v = std::clamp(p.v, 0.0, 1.0);
    add(sign, {(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v});
  };
  if (winding != 0) {
    addPoint(winding, roots.at(winding));
  } else if (roots.areTwo()) {
    // Both are inside or none is. Where rounding makes it one, that is decided by the one that is farther from the border.
    const PatchPoint one = roots.at(1), other = roots.at(-1);
    const double a = one.depth(), b = other.depth();
    if ((std::abs(a) >= std::abs(b) ? a : b) > 0) addPoint(1, one), addPoint(-1, other);
  }
  return found;
}

}  // namespace gxy::reference
