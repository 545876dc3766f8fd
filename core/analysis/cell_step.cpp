// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/cell_step.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "core/analysis/reference_faces.h"

namespace gxy {

namespace {

/// Reference coordinates outside the cell up to which steps look at its field.
constexpr double kFarthest = 0.5;

bool isNear(glm::dvec3 place) { return largestOf(place - 0.5) <= 0.5 + kFarthest; }

/// A polynomial of degree n from 0 to 1, as factors of powers.
template <size_t n>
using Powers = std::array<double, n + 1>;

template <size_t n>
double sumOfPowers(const Powers<n>& p, double s) {
  double sum = p[n];
  for (size_t k = n; k-- > 0;) sum = sum * s + p[k];
  return sum;
}

template <size_t n>
double slopeOfPowers(const Powers<n>& p, double s) {
  double sum = double(n) * p[n];
  for (size_t k = n; --k > 0;) sum = sum * s + double(k) * p[k];
  return sum;
}

/// Its control points: the polynomial is between the least and the largest of them.
Powers<3> controlPoints(const Powers<3>& p) {
  const double one = p[1] * (1. / 3), two = p[2] * (1. / 3);
  return {p[0], p[0] + one, p[0] + 2 * one + two, p[0] + p[1] + p[2] + p[3]};
}
Powers<4> controlPoints(const Powers<4>& p) {
  const double two = p[2] * (1. / 6);
  return {p[0], p[0] + 0.25 * p[1], p[0] + 0.5 * p[1] + two, p[0] + 0.75 * p[1] + 3 * two + 0.25 * p[3],
          p[0] + p[1] + p[2] + p[3] + p[4]};
}

/// The root of what is positive at 0, negative at 1, and changes its sign once.
template <size_t n>
double onlyRoot(const Powers<n>& p) {
  double lo = 0, hi = 1, s = p[0] / (p[0] - sumOfPowers<n>(p, 1));
  for (int turn = 0; turn < 64 && lo < hi; turn++) {
    const double value = sumOfPowers<n>(p, s), slope = slopeOfPowers<n>(p, s);
    (value > 0 ? lo : hi) = s;
    double next = s - value / slope;
    if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
    if (std::abs(next - s) <= 0x1p-52) return next;
    s = next;
  }
  return s;
}

/// Where a distance from a face that begins inside, or at 0, becomes negative.
template <size_t n>
StepExit exitAt(const Powers<n>& distance) {
  const Powers<n> control = controlPoints(distance);
  if (!(control[0] > 0)) return {StepExit::Leaves, 0, -1};
  int changes = 0;
  for (size_t k = 1; k <= n; k++) changes += (control[k] < 0) != (control[k - 1] < 0);
  if (changes == 0) return {};
  if (changes > 1) return {StepExit::Unclear, 0.5, -1};
  return {StepExit::Leaves, onlyRoot<n>(distance), -1};
}

}  // namespace

double largestOf(glm::dvec3 v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

glm::dvec3 CellStep::at(double s) const {
  return power[0] + s * (power[1] + s * (power[2] + s * (power[3] + s * power[4])));
}

std::optional<CellStep> stepIn(const CellMotion& motion, glm::dvec3 from, glm::dvec3 k1, double h) {
  bool good = true;
  const auto rate = [&](glm::dvec3 place) {
    const auto found = good && isNear(place) ? motion.rateAt(place) : std::nullopt;
    good = found.has_value();
    return found.value_or(glm::dvec3(0));
  };
  const glm::dvec3 k2 = rate(from + h * (1. / 5 * k1));
  const glm::dvec3 k3 = rate(from + h * (3. / 40 * k1 + 9. / 40 * k2));
  const glm::dvec3 k4 = rate(from + h * (44. / 45 * k1 - 56. / 15 * k2 + 32. / 9 * k3));
  const glm::dvec3 k5 =
      rate(from + h * (19372. / 6561 * k1 - 25360. / 2187 * k2 + 64448. / 6561 * k3 - 212. / 729 * k4));
  const glm::dvec3 k6 = rate(from + h * (9017. / 3168 * k1 - 355. / 33 * k2 + 46732. / 5247 * k3 +
                                         49. / 176 * k4 - 5103. / 18656 * k5));
  const glm::dvec3 way =
      h * (35. / 384 * k1 + 500. / 1113 * k3 + 125. / 192 * k4 - 2187. / 6784 * k5 + 11. / 84 * k6);
  const glm::dvec3 k7 = rate(from + way);
  if (!good) return std::nullopt;
  CellStep step;
  step.time = h;
  step.from = from, step.to = from + way;
  step.rate = k7;
  step.error = largestOf(h * (71. / 57600 * k1 - 71. / 16695 * k3 + 71. / 1920 * k4 - 17253. / 339200 * k5 +
                              22. / 525 * k6 - 1. / 40 * k7));
  const glm::dvec3 first = h * k1 - way, last = way - h * k7 - first;
  const glm::dvec3 bulge = h * (-12715105075. / 11282082432 * k1 + 87487479700. / 32700410799 * k3 -
                                10690763975. / 1880347072 * k4 + 701980252875. / 199316789632 * k5 -
                                1453857185. / 822651844 * k6 + 69997945. / 29380423 * k7);
  step.power = {from, way + first, last - first + bulge, -last - 2. * bulge, bulge};
  return step;
}

int faceLeftAtOnce(CellType type, glm::dvec3 place, glm::dvec3 rate) {
  const std::span<const ReferenceFace> faces = referenceFaces(type);
  double fastest = -kTangential * largestOf(rate);
  int face = -1;
  for (size_t f = 0; f < faces.size(); f++) {
    const double across = glm::dot(faces[f].normal, rate);
    if (across < fastest && faces[f].distance(place) <= kOnFace) fastest = across, face = int(f);
  }
  return face;
}

double timeToFace(CellType type, glm::dvec3 place, glm::dvec3 rate) {
  double time = std::numeric_limits<double>::infinity();
  for (const ReferenceFace& f : referenceFaces(type)) {
    const double across = glm::dot(f.normal, rate), distance = f.distance(place);
    if (across < 0 && distance > kOnFace) time = std::min(time, -distance / across);
  }
  return time;
}

StepExit exitOf(CellType type, const CellStep& step) {
  const std::span<const ReferenceFace> faces = referenceFaces(type);
  StepExit first;
  for (size_t f = 0; f < faces.size(); f++) {
    Powers<4> d;
    for (size_t k = 0; k < 5; k++) d[k] = glm::dot(faces[f].normal, step.power[k]);
    d[0] = faces[f].distance(step.from);
    if (d[0] >= std::abs(d[1]) + std::abs(d[2]) + std::abs(d[3]) + std::abs(d[4])) continue;  // far away
    const bool on = d[0] <= kOnFace;
    if (on) d[0] = 0;
    const Powers<4> control = controlPoints(d);
    if (*std::min_element(control.begin(), control.end()) >= -kOnFace) continue;
    // A head that begins on a face is not meeting it: the root at 0 is divided out.
    StepExit exit = on ? exitAt<3>({d[1], d[2], d[3], d[4]}) : exitAt<4>(d);
    if (exit.kind == StepExit::Unclear) return exit;
    if (exit.kind == StepExit::Inside || (first.kind == StepExit::Leaves && first.part <= exit.part))
      continue;
    exit.face = int(f);
    first = exit;
  }
  return first;
}

double lengthOf(const CellMotion& motion, const CellStep& step, double part) {
  // Gauss' rule of order 6.
  constexpr double kAside = 0.7745966692414834;
  const auto speed = [&](double x) { return motion.speedAt(step.at(0.5 * part * (1 + x))); };
  return step.time * part * (5 * (speed(-kAside) + speed(kAside)) + 8 * speed(0)) / 18;
}

double partOfLength(const CellMotion& motion, const CellStep& step, double most, double length) {
  double part = most;
  for (int turn = 0; turn < 8; turn++) {
    const double missing = length - lengthOf(motion, step, part);
    const double speed = step.time * motion.speedAt(step.at(part));
    if (!(speed > 0)) break;
    const double next = std::clamp(part + missing / speed, 0.0, most);
    if (std::abs(next - part) <= 0x1p-50) return next;
    part = next;
  }
  return part;
}

}  // namespace gxy
