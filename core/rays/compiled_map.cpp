// SPDX-License-Identifier: Apache-2.0
#include "core/rays/compiled_map.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <glm/vector_relational.hpp>
#include <limits>
#include <set>

#include "core/kernels/single.h"
#include "core/scene/colormaps.h"

namespace gxy {

namespace {

constexpr double kOpaque = 1e20;        // extinction of opacity 1
constexpr double kNearlyOpaque = 1e-7;  // where extinction must be finite, opacity is at most 1 minus this
constexpr double kDense = 4;        // optical depth of a reference length; errors in denser parts are hidden
constexpr double kThin = 1e-3;      // likewise: in thinner parts no error is hidden
constexpr double kHidden = 1e4;     // likewise: a denser interval hides all that is behind it
constexpr double kStraight = 1e-4;  // tolerance of straightened(): relative in extinction, absolute in colour
constexpr double kFarStored = 1e29;  // maps cover stored values up to this one
constexpr int kDeepestCut = 14;
constexpr int kMostBuckets = 4096;

// The limit from below or above, at any value, of a piecewise linear function with steps.
template <class Point, class Value>
Value limit(const std::vector<Point>& points, double at, bool above,
            const std::function<Value(const Point&)>& of) {
  auto less = [](const Point& p, double v) { return p.value < v; };
  auto more = [](double v, const Point& p) { return v < p.value; };
  auto next = above ? std::upper_bound(points.begin(), points.end(), at, more)
                    : std::lower_bound(points.begin(), points.end(), at, less);
  if (next == points.begin()) return of(points.front());
  if (next == points.end()) return of(points.back());
  const Point &a = *(next - 1), &b = *next;
  const double f = (at - a.value) / (b.value - a.value);
  return of(a) * (1 - f) + of(b) * f;
}

// A value at which the map may change its course, with the limits of (r, g, b, sigma) on both sides.
struct ControlPoint {
  double value;
  glm::dvec4 below, above;
  bool behind = false;  // a step that is justAbove the node before it
};

// The next float above x that kernels can tell from x, whether or not they flush denormal numbers.
float nextFloat(float x) {
  constexpr float kLeast = std::numeric_limits<float>::min();
  const float next = std::max(std::nextafter(x, INFINITY), x + kLeast);
  if (next == 0 || std::abs(next) >= kLeast) return next;
  return next < 0 ? 0.f : kLeast;
}

// Drops nodes on runs that are straight up to kStraight. From each node that is kept, the next one kept is as
// far away as possible while every node between is within kStraight of the line (a swing filter; Elmeleegy et
// al. 2009). Steps are kept.
std::vector<ControlPoint> straightened(const std::vector<ControlPoint>& nodes) {
  if (nodes.size() < 3) return nodes;
  std::vector<ControlPoint> kept{nodes.front()};
  glm::dvec4 least(-INFINITY), most(INFINITY);  // the slopes that all nodes passed over allow
  for (size_t i = 1; i < nodes.size(); i++) {
    const ControlPoint &from = kept.back(), &here = nodes[i];
    const glm::dvec4 slack(glm::dvec3(kStraight), kStraight * here.below.w);
    const double run = here.value - from.value;
    least = glm::max(least, (here.below - slack - from.above) / run);
    most = glm::min(most, (here.below + slack - from.above) / run);
    const bool last = i + 1 == nodes.size(), step = here.below != here.above;
    if (!last && !step) {
      const glm::dvec4 slope = (nodes[i + 1].below - from.above) / (nodes[i + 1].value - from.value);
      if (glm::all(glm::lessThanEqual(least, slope)) && glm::all(glm::lessThanEqual(slope, most))) continue;
    }
    kept.push_back(here);
    least = glm::dvec4(-INFINITY), most = glm::dvec4(INFINITY);
  }
  return kept;
}

ControlPoint between(const ControlPoint& a, const ControlPoint& b, double value) {
  const glm::dvec4 here = glm::mix(a.above, b.below, (value - a.value) / (b.value - a.value));
  return {value, here, here};
}

// Cuts a map to [lo, hi], since there are no values beyond: its lines end there instead of far away.
std::vector<ControlPoint> within(const std::vector<ControlPoint>& nodes, double lo, double hi) {
  std::vector<ControlPoint> part;
  for (size_t i = 0; i < nodes.size(); i++) {
    const ControlPoint& n = nodes[i];
    const ControlPoint* next = i + 1 < nodes.size() ? &nodes[i + 1] : nullptr;
    if (n.value >= lo && n.value <= hi) part.push_back(n);
    if (next && n.value < lo && next->value > lo) part.push_back(between(n, *next, lo));
    if (next && n.value < hi && next->value > hi) part.push_back(between(n, *next, hi));
  }
  const ControlPoint &first = nodes.front(), &last = nodes.back();
  if (last.value < lo) part.push_back({lo, last.above, last.above});
  if (first.value > hi) part.push_back({hi, first.below, first.below});
  return part;
}

}  // namespace

CompiledMap::CompiledMap(const ColorMap& color, const OpacityMap* opacity, const MapUnits& units) {
  const std::function<glm::dvec3(const ColorPoint&)> rgb = [](const ColorPoint& p) { return p.rgb; };
  const std::function<double(const OpacityPoint&)> amount = [](const OpacityPoint& p) { return p.opacity; };
  const double perLength = units.worldPerT / units.referenceLength;
  auto sigmaOf = [&](double x) {
    if (opacity->extinction) return std::min(x * units.worldPerT, kOpaque);
    return x >= 1 ? kOpaque : std::min(-std::log1p(-x) * perLength, kOpaque);
  };
  auto amountAt = [&](double v, bool above) {
    return limit<OpacityPoint, double>(opacity->points, v, above, amount);
  };
  auto colorAt = [&](double v, bool above) {
    return limit<ColorPoint, glm::dvec3>(color.points, v, above, rgb);
  };

  std::set<double> cuts;
  for (const auto& p : color.points) cuts.insert(p.value);
  if (opacity)
    for (const auto& p : opacity->points) cuts.insert(p.value);

  std::vector<ControlPoint> list;  // over true values
  auto colored = [&](double v, double below, double above) {
    return ControlPoint{v, glm::dvec4(colorAt(v, false), below), glm::dvec4(colorAt(v, true), above)};
  };
  for (double v : cuts) {
    double below = 0, above = 0;
    if (opacity) below = sigmaOf(amountAt(v, false)), above = sigmaOf(amountAt(v, true));
    if (opacity && !opacity->extinction && !list.empty()) {
      // cut the curve between the previous node and this one
      const double v0 = list.back().value, a0 = amountAt(v0, true), a1 = amountAt(v, false);
      auto curve = [&](double f) { return sigmaOf(std::min(a0 + f * (a1 - a0), 1 - kNearlyOpaque)); };
      if (a0 < 1 || a1 < 1) {
        if (a0 >= 1) list.back().above.w = curve(0);
        if (a1 >= 1) below = curve(1);
        std::function<void(double, double, int)> cut = [&](double f0, double f1, int depth) {
          const double s0 = curve(f0), s1 = curve(f1), middle = curve(0.5 * (f0 + f1));
          if (depth == kDeepestCut || std::abs(0.5 * (s0 + s1) - middle) <= 2e-4 * middle + 1e-9 * perLength)
            return;
          cut(f0, 0.5 * (f0 + f1), depth + 1);
          const double f = 0.5 * (f0 + f1);
          list.push_back(colored(v0 + f * (v - v0), middle, middle));
          cut(f, f1, depth + 1);
        };
        cut(0, 1, 0);
      }
    }
    ControlPoint node = colored(v, below, above);
    node.behind = !list.empty() && node.below != node.above && v == justAbove(list.back().value);
    list.push_back(node);
  }

  // Nodes that coincide in float, or are closer than the least normal number, become one step.
  auto storedValue = [&](double v) { return float((v - units.shift) / units.scale); };
  auto stored = [&](const ControlPoint& n) {
    return n.behind ? nextFloat(storedValue(std::nextafter(n.value, -INFINITY))) : storedValue(n.value);
  };
  std::vector<ControlPoint> kept;
  const double farthest = kFarStored * units.scale;
  for (const ControlPoint& n : straightened(within(list, units.shift - farthest, units.shift + farthest))) {
    if (!kept.empty() && stored(n) - stored(kept.back()) < std::numeric_limits<float>::min())
      kept.back().above = n.above;
    else
      kept.push_back(n);
  }
  const int inner = int(kept.size()) - 1;
  nan = glm::vec3(color.nan.value_or(glm::dvec3(kept.front().below)));
  largestColor = std::max({double(nan.r), double(nan.g), double(nan.b)});

  // Beyond kDense a part is hidden behind its own front.
  auto seen = [&](double sigma) { return std::min(sigma, kDense * perLength); };
  std::vector<double> extinction, slope, shade, jump;
  // Slopes of extinction times colour (xyz) and of extinction (w), at the start and end of each interval.
  std::vector<std::array<glm::dvec4, 2>> slopes;
  double total[4] = {0, 0, 0, 0};
  int32_t lastOpaque = -1;
  auto addInterval = [&](double start, double length, const glm::dvec4& from, const glm::dvec4& to) {
    const double s0 = from.w, s1 = to.w;
    const glm::dvec3 c0(from), c1(to);
    nodes.push_back(float(start));
    if (!spans.empty()) spans[spans.size() - 2] = nodes.back();
    for (float x : {nodes.back(), length > 0 ? float(1 / length) : 0.f, INFINITY, 0.f}) spans.push_back(x);
    for (double x : {s0, s1 - s0, c0.x, c1.x - c0.x, c0.y, c1.y - c0.y, c0.z, c1.z - c0.z})
      pieces.push_back(float(x));
    for (double x : total) sums.push_back(float(x));
    for (double x : total) sums.push_back(float(x - float(x)));
    opaque.push_back(lastOpaque);
    total[0] += length * 0.5 * (s0 + s1);
    double steepest = 0;
    for (int k = 0; k < 3; k++) {
      const double d = s1 - s0, e = c1[k] - c0[k];
      total[1 + k] += length * (s0 * c0[k] + 0.5 * (s0 * e + d * c0[k]) + d * e / 3);
      steepest = std::max(steepest, seen(std::max(s0, s1)) * std::abs(e));
      largestColor = std::max({largestColor, c0[k], c1[k]});
    }
    if (0.5 * (s0 + s1) > kHidden * perLength) {
      // Sums begin anew behind it; otherwise they would lose their digits.
      lastOpaque = int32_t(nodes.size()) - 1;
      std::fill(total, total + 4, 0.0);
    }
    extinction.push_back(std::max(s0, s1));
    slope.push_back(length > 0 ? (std::abs(seen(s1) - seen(s0)) + steepest) / length : 0);
    shade.push_back(length > 0 ? steepest / length : 0);
    const double per = length > 0 ? 1 / length : 0, d = per * (seen(s1) - seen(s0));
    const glm::dvec3 e = per * (c1 - c0);
    slopes.push_back({glm::dvec4(d * c0 + seen(s0) * e, d), glm::dvec4(d * c1 + seen(s1) * e, d)});
  };

  addInterval(-1e30, 0, kept.front().below, kept.front().below);
  for (int i = 0; i < inner; i++) {
    const ControlPoint &a = kept[i], &b = kept[i + 1];
    addInterval(stored(a), double(stored(b)) - stored(a), a.above, b.below);
  }
  addInterval(stored(kept.back()), 0, kept.back().above, kept.back().above);
  jump.push_back(0);  // jump[k] is the step at the start of interval k
  for (const ControlPoint& n : kept) {
    const double below = seen(n.below.w), above = seen(n.above.w);
    const glm::dvec3 source = glm::abs(above * glm::dvec3(n.above) - below * glm::dvec3(n.below));
    jump.push_back(std::max({std::abs(above - below), source.r, source.g, source.b}));
  }

  auto size = [](glm::dvec4 v) {
    return std::abs(v.w) + std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  };
  std::vector<double> kink{0}, denseKink{0};  // element k is at the start of interval k
  double variation = 0, dense = 0, curve = 0;
  for (size_t k = 0; k < slopes.size(); k++) {
    if (k > 0) {
      kink.push_back(size(slopes[k][0] - slopes[k - 1][1]));
      variation += kink.back();
      const double sigma = std::max(std::min(kept[k - 1].below.w, kept[k - 1].above.w), kThin * perLength);
      denseKink.push_back(kink.back() / (sigma * sigma));
      dense += denseKink.back();
    }
    const double within = size(slopes[k][1] - slopes[k][0]);
    bend_.push_back(variation);
    denseBend_.push_back(dense);
    curve_.push_back(curve);
    variation += within;
    curve += within;
  }
  curve_.push_back(curve);

  origin = nodes.size() > 1 ? nodes[1] : 0.f;
  const double span = inner > 0 ? double(nodes.back()) - origin : 0;
  // A value exactly at a step belongs above it, which only a comparison with nodes can tell.
  bool even =
      inner > 0 && span > 0 && std::none_of(jump.begin() + 1, jump.end(), [](double j) { return j > 0; });
  for (int i = 0; even && i <= inner; i++)
    even = std::abs(double(nodes[1 + i]) - (origin + span * i / inner)) <= 1e-5 * span / inner;
  if (even) {
    uniform = inner;
    inverse = float(inner / span);
  } else {
    const int count = std::clamp(int(std::bit_ceil(unsigned(8 * std::max(inner, 1)))), 64, kMostBuckets);
    const double width = span > 0 ? span / count : 1;
    inverse = float(std::min(1 / width, 1e38));  // limiting it finds an earlier bucket, which is safe
    buckets.resize(count);
    for (int i = 0, k = 0; i < count; i++) {
      // The interval found here begins before the bucket, however the bucket's index is rounded.
      const double start = origin + (i - 0.01) * width;
      while (k + 1 < int(nodes.size()) && nodes[k + 1] <= start) k++;
      buckets[i] = k;
    }
  }
  if (intervals() <= MAP_SMALL) {
    nodes.resize(MAP_SMALL, INFINITY);
    rows = nodes;
    rows.resize(10 * MAP_SMALL);
    for (size_t k = 0; k < size_t(intervals()); k++) {
      rows[MAP_SMALL + k] = spans[4 * k + 1];
      for (size_t i = 0; i < 8; i++) rows[MAP_SMALL * (2 + i) + k] = pieces[8 * k + i];
    }
  }
  extinction_.build(std::move(extinction));
  slope_.build(std::move(slope));
  shade_.build(std::move(shade));
  kink_.build(std::move(kink));
  denseKink_.build(std::move(denseKink));
  jump_.build(std::move(jump));
}

int CompiledMap::intervalOf(float value) const {
  return int(std::upper_bound(nodes.begin() + 1, nodes.begin() + intervals(), value) - nodes.begin()) - 1;
}

double CompiledMap::extinctionAt(int interval, float value) const {
  const size_t k = size_t(interval);
  return double(pieces[8 * k]) +
         (double(value) - nodes[k]) * double(spans[4 * k + 1]) * double(pieces[8 * k + 1]);
}

CompiledMap::Over CompiledMap::over(float lo, float hi) const {
  const int a = intervalOf(lo), b = intervalOf(hi);
  // In the first and last interval the values at lo and hi decide: a range that just touches where something
  // begins is transparent.
  const int last = a < b && hi == nodes[size_t(b)] ? b - 1 : b;
  Over over;
  over.extinction = std::max(a == b ? extinctionAt(a, lo) : extinction_.query(a, b - 1), extinctionAt(b, hi));
  if (!(hi > lo)) return over;
  over.slope = slope_.query(a, last);
  over.shade = shade_.query(a, last);
  if (last > a) over.kink = kink_.query(a + 1, last), over.denseKink = denseKink_.query(a + 1, last);
  if (b > a) over.jump = jump_.query(a + 1, b);
  // The variation of the slope up to a value in interval k: at nodes, and within intervals.
  auto atNodes = [&](int k) { return bend_[size_t(k)] - curve_[size_t(k)]; };
  auto inside = [&](int k, float value) {
    const double within = curve_[size_t(k) + 1] - curve_[size_t(k)];
    const double part = (double(value) - nodes[size_t(k)]) * double(spans[4 * size_t(k) + 1]);
    return curve_[size_t(k)] + within * std::min(part, 1.0);
  };
  over.curve = inside(last, hi) - inside(a, lo);
  over.bend = atNodes(last) - atNodes(a) + over.curve;
  over.denseBend = denseBend_[size_t(last)] - denseBend_[size_t(a)];
  return over;
}

void CompiledMap::RangeMax::build(std::vector<double> values) {
  levels.clear();
  levels.push_back(std::move(values));
  for (size_t run = 1; 2 * run <= levels[0].size(); run *= 2) {
    const auto& below = levels.back();
    std::vector<double> next(levels[0].size() - 2 * run + 1);
    for (size_t i = 0; i < next.size(); i++) next[i] = std::max(below[i], below[i + run]);
    levels.push_back(std::move(next));
  }
}

double CompiledMap::RangeMax::query(int first, int last) const {
  const int level = std::bit_width(unsigned(last - first + 1)) - 1;
  return std::max(levels[level][first], levels[level][last + 1 - (1 << level)]);
}

}  // namespace gxy
