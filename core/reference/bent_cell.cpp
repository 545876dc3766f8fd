// SPDX-License-Identifier: Apache-2.0
#include "core/reference/bent_cell.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <glm/common.hpp>
#include <limits>

#include "core/reference/ray_frame.h"

namespace gxy::reference {
namespace {

/// Stretches are halved up to this often, in tangled cells without an inverse up to `kDeepestLost`.
constexpr int kDeepestStretch = 24, kDeepestLost = 4;
constexpr size_t kMostStretches = 1000;

double rangeOf(const OfCorners& values, size_t corners) {
  const auto [low, high] = std::minmax_element(values.begin(), values.begin() + ptrdiff_t(corners));
  return *high - *low;
}

Cubic linear(double a, double b) { return {{a, mix(a, b, 1 / 3.0), mix(a, b, 2 / 3.0), b}}; }

/// The cubic through values at 0, 1/3, 2/3 and 1.
Cubic throughThirds(double a, double b, double c, double d) {
  // Relative to the ends, so that a linear function has no error but rounding.
  const double p = b - mix(a, d, 1 / 3.0), q = c - mix(a, d, 2 / 3.0);
  return {{a, mix(a, d, 1 / 3.0) + 3 * p - 1.5 * q, mix(a, d, 2 / 3.0) + 3 * q - 1.5 * p, d}};
}

}  // namespace

/// How a passage is cut into stretches.
struct CellOnRay::Split {
  const OfCorners* values;
  double range, tolerance;
  bool rootsOnly;  ///< whether stretches that have no root need not be exact
};

CellOnRay::CellOnRay(const BentCell& cell, const Ray& ray) : cell_(&cell) {
  const RayFrame frame(ray);
  const auto corners = cell.corners();
  for (size_t k = 0; k < corners.size(); k++) seen_[k] = frame.sheared(corners[k]);
}

std::vector<CellPassage> CellOnRay::passages() const {
  const CellShape& shape = shapeOf(cell_->type);
  std::vector<FaceMeeting> met;
  for (size_t f = 0; f < shape.faces; f++)
    for (const FaceMeeting& one : meet(shape.face[f], std::span(seen_).first(shape.points),
                                       std::span(cell_->numbers).first(shape.points)))
      met.push_back(one);
  std::stable_sort(met.begin(), met.end(),
                   [](const FaceMeeting& a, const FaceMeeting& b) { return a.t < b.t; });
  std::vector<CellPassage> passages;
  std::deque<const FaceMeeting*> open;  // all of one sign
  for (const FaceMeeting& one : met) {
    if (open.empty() || open.front()->sign == one.sign) {
      open.push_back(&one);
    } else {
      passages.push_back({*open.front(), one});
      open.pop_front();
    }
  }
  return passages;
}

glm::dvec3 CellOnRay::placeOf(const FaceMeeting& meeting) const {
  glm::dvec3 sum(0);
  for (size_t i = 0; i < meeting.corners; i++)
    sum += meeting.weights[i] * placeOfCorner(cell_->type, meeting.corner[i]);
  return sum;
}

CellOnRay::Sample CellOnRay::end(const FaceMeeting& meeting, const OfCorners& values) const {
  return {meeting.t, placeOf(meeting), meeting.mean(values)};
}

CellOnRay::Sample CellOnRay::between(const Sample& a, const Sample& b, double t,
                                     const OfCorners& values) const {
  const size_t corners = shapeOf(cell_->type).points;
  const auto points = std::span(seen_).first(corners);
  const double w = b.t > a.t ? (t - a.t) / (b.t - a.t) : 0.5;
  const glm::dvec3 straight = glm::mix(a.place, b.place, w), target(0, 0, t);
  glm::dvec3 middle(0);
  for (size_t k = 0; k < corners; k++) middle += placeOfCorner(cell_->type, k) / double(corners);
  for (const glm::dvec3& guess : {straight, a.place, b.place, middle}) {
    const auto inverse = invert(cell_->type, points, target, guess);
    if (!inverse) continue;
    const auto [low, high] = std::minmax_element(values.begin(), values.begin() + ptrdiff_t(corners));
    const double value = shapeAt(cell_->type, inverse->place).mean(values);
    return {t, inverse->place, std::clamp(value, *low, *high), inverse->noise};
  }
  return {t, straight, mix(a.value, b.value, w), 0, false};
}

glm::dvec3 CellOnRay::placeAt(const CellPassage& passage, double t) const {
  const OfCorners none{};
  if (!(t > passage.in.t)) return placeOf(passage.in);
  if (!(t < passage.out.t)) return placeOf(passage.out);
  return between(end(passage.in, none), end(passage.out, none), t, none).place;
}

void CellOnRay::split(const Split& how, const FourSamples& at, int depth, std::vector<FourSamples>& stretches,
                      std::vector<Cubic>& cubics) const {
  const auto& [a, third, twoThirds, b] = at;
  const Cubic cubic = throughThirds(a.value, third.value, twoThirds.value, b.value);
  const OfCorners& values = *how.values;
  const std::array<double, 3> w{1 / 6.0, 0.5, 5 / 6.0};
  const std::array<Sample, 3> middles{between(a, third, mix(a.t, b.t, w[0]), values),
                                      between(third, twoThirds, mix(a.t, b.t, w[1]), values),
                                      between(twoThirds, b, mix(a.t, b.t, w[2]), values)};
  double error = 0, noise = std::max(third.noise, twoThirds.noise);
  bool found = third.found && twoThirds.found;
  for (size_t i = 0; i < 3; i++) {
    error = std::max(error, std::abs(middles[i].value - cubic.value(w[i])));
    noise = std::max(noise, middles[i].noise);
    found = found && middles[i].found;
  }
  const bool without = how.rootsOnly && (cubic.min() > 10 * error || cubic.max() < -10 * error);
  const bool exact = error <= how.tolerance + 4 * noise * how.range;
  const bool least = depth >= (found ? kDeepestStretch : kDeepestLost) || cubics.size() >= kMostStretches ||
                     !(a.t < middles[0].t && third.t < middles[1].t && middles[2].t < b.t);
  if (without || exact || least) {
    stretches.push_back(at);
    cubics.push_back(found ? cubic : linear(a.value, b.value));
    return;
  }
  // The thirds of a half are sixths of the whole.
  split(how, {a, middles[0], third, middles[1]}, depth + 1, stretches, cubics);
  split(how, {middles[1], twoThirds, middles[2], b}, depth + 1, stretches, cubics);
}

std::vector<Cubic> CellOnRay::cubicsOf(const Split& how, const Sample& in, const Sample& out,
                                       std::vector<FourSamples>& stretches) const {
  const auto at = [&](double w) { return between(in, out, mix(in.t, out.t, w), *how.values); };
  std::vector<Cubic> cubics;
  split(how, {in, at(1 / 3.0), at(2 / 3.0), out}, 0, stretches, cubics);
  return cubics;
}

std::vector<CellStretch> CellOnRay::stretches(const CellPassage& passage, const OfCorners& values,
                                              double tolerance) const {
  const Sample in = end(passage.in, values), out = end(passage.out, values);
  const double range = rangeOf(values, shapeOf(cell_->type).points);
  if (range == 0 || !(in.t < out.t)) return {{in.t, out.t, linear(in.value, out.value)}};
  std::vector<FourSamples> samples;
  const std::vector<Cubic> cubics = cubicsOf({&values, range, tolerance, false}, in, out, samples);
  std::vector<CellStretch> stretches;
  for (size_t i = 0; i < cubics.size(); i++)
    stretches.push_back({samples[i].front().t, samples[i].back().t, cubics[i]});
  return stretches;
}

CellRoot CellOnRay::root(Sample a, Sample b, const OfCorners& values) const {
  const Sample first = a, last = b;
  double weightA = 1, weightB = 1;
  int stayed = 0;  // < 0: a stayed in the last step; > 0: b did
  for (int i = 0; i < 100; i++) {
    // The method of false position, in which an end that stays twice counts half (Illinois). Every third step bisects.
    const double fa = weightA * a.value, fb = weightB * b.value, middle = mix(a.t, b.t, 0.5);
    double t = i % 3 == 2 || fa == fb ? middle : mix(a.t, b.t, fa / (fa - fb));
    if (!(t > a.t && t < b.t)) t = middle;
    if (!(t > a.t && t < b.t)) break;
    const Sample one = between(a, b, t, values);
    if (one.value == 0) return {one.t, one.place};
    if ((one.value > 0) == (a.value > 0)) {
      a = one, weightA = 1;
      if (stayed > 0) weightB *= 0.5;
      stayed = 1;
    } else {
      b = one, weightB = 1;
      if (stayed < 0) weightA *= 0.5;
      stayed = -1;
    }
  }
  const Sample& nearer = std::abs(a.value) <= std::abs(b.value) ? a : b;
  return {std::clamp(nearer.t, first.t, last.t), nearer.place};
}

std::vector<CellRoot> CellOnRay::roots(const CellPassage& passage, const OfCorners& values) const {
  const Sample in = end(passage.in, values), out = end(passage.out, values);
  const double range = rangeOf(values, shapeOf(cell_->type).points);
  if (!(in.t < out.t)) {
    const bool passed = (in.value > 0) != (out.value > 0);
    return passed ? std::vector<CellRoot>{{in.t, in.place}} : std::vector<CellRoot>();
  }
  std::vector<FourSamples> samples;
  const std::vector<Cubic> cubics = cubicsOf({&values, range, 1e-9 * range, true}, in, out, samples);
  std::vector<CellRoot> found;
  for (size_t i = 0; i < cubics.size(); i++) {
    const Sample &a = samples[i].front(), &b = samples[i].back();
    Sample last = a;
    const auto goOn = [&](const Sample& next) {
      if ((last.value > 0) != (next.value > 0)) found.push_back(root(last, next, values));
      last = next;
    };
    for (const double s : extrema(cubics[i])) {
      const double t = mix(a.t, b.t, s);
      if (t > last.t && t < b.t) goOn(between(a, b, t, values));
    }
    goOn(b);
  }
  return found;
}

}  // namespace gxy::reference
