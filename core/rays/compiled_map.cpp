// SPDX-License-Identifier: Apache-2.0
#include "gxy/rays/compiled_map.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <set>

namespace gxy {

namespace {

constexpr double kOpaque = 1e20;        // extinction of opacity 1: opaque at once
constexpr double kNearlyOpaque = 1e-7;  // 1 - a below which a is taken as a limit of finite extinction
constexpr double kDense = 16;           // optical depth of a reference length beyond which errors are hidden
constexpr int kDeepestCut = 14;
constexpr int kMostBuckets = 4096;

// A piecewise linear function with steps: limits from below and above at any value.
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

  // True values of the nodes, with the limits of extinction on both sides.
  struct Node {
    double value, below, above;
  };
  std::vector<Node> list;
  for (double v : cuts) {
    double below = 0, above = 0;
    if (opacity) below = sigmaOf(amountAt(v, false)), above = sigmaOf(amountAt(v, true));
    if (opacity && !opacity->extinction && !list.empty()) {
      // cut the curve between the previous node and this one
      const double v0 = list.back().value, a0 = amountAt(v0, true), a1 = amountAt(v, false);
      auto curve = [&](double f) { return sigmaOf(std::min(a0 + f * (a1 - a0), 1 - kNearlyOpaque)); };
      if (a0 < 1 || a1 < 1) {
        if (a0 >= 1) list.back().above = curve(0);
        if (a1 >= 1) below = curve(1);
        std::function<void(double, double, int)> cut = [&](double f0, double f1, int depth) {
          const double s0 = curve(f0), s1 = curve(f1), middle = curve(0.5 * (f0 + f1));
          if (depth == kDeepestCut || std::abs(0.5 * (s0 + s1) - middle) <= 2e-4 * middle + 1e-9 * perLength)
            return;
          cut(f0, 0.5 * (f0 + f1), depth + 1);
          const double f = 0.5 * (f0 + f1);
          list.push_back({v0 + f * (v - v0), middle, middle});
          cut(f, f1, depth + 1);
        };
        cut(0, 1, 0);
      }
    }
    list.push_back({v, below, above});
  }

  // Nodes that coincide in float become one step.
  auto stored = [&](double v) { return float((v - units.shift) / units.scale); };
  std::vector<Node> kept;
  for (const Node& n : list) {
    if (!kept.empty() && stored(n.value) == stored(kept.back().value))
      kept.back().above = n.above;
    else
      kept.push_back(n);
  }
  const int inner = int(kept.size()) - 1;

  // what a denser part does more is hidden behind its front
  auto seen = [&](double sigma) { return std::min(sigma, kDense * perLength); };
  std::vector<double> extinction, slope, jump;
  double total[4] = {0, 0, 0, 0};
  auto addInterval = [&](double start, double length, double s0, double s1, glm::dvec3 c0, glm::dvec3 c1) {
    nodes.push_back(float(start));
    lengths.push_back(length > 0 ? float(1 / length) : 0.f);
    for (double x : {s0, s1 - s0, c0.x, c1.x - c0.x, c0.y, c1.y - c0.y, c0.z, c1.z - c0.z})
      pieces.push_back(float(x));
    for (double x : total) sums.push_back(float(x));
    total[0] += length * 0.5 * (s0 + s1);
    double steepest = 0;
    for (int k = 0; k < 3; k++) {
      const double d = s1 - s0, e = c1[k] - c0[k];
      total[1 + k] += length * (s0 * c0[k] + 0.5 * (s0 * e + d * c0[k]) + d * e / 3);
      steepest = std::max(steepest, seen(std::max(s0, s1)) * std::abs(e));
      largestColor = std::max({largestColor, c0[k], c1[k]});
    }
    extinction.push_back(std::max(s0, s1));
    slope.push_back(length > 0 ? (std::abs(seen(s1) - seen(s0)) + steepest) / length : 0);
  };

  const double first = kept.front().value, last = kept.back().value;
  addInterval(-1e30, 0, kept.front().below, kept.front().below, colorAt(first, false), colorAt(first, false));
  for (int i = 0; i < inner; i++) {
    const Node &a = kept[i], &b = kept[i + 1];
    addInterval(stored(a.value), double(stored(b.value)) - stored(a.value), a.above, b.below,
                colorAt(a.value, true), colorAt(b.value, false));
  }
  addInterval(stored(last), 0, kept.back().above, kept.back().above, colorAt(last, true),
              colorAt(last, true));
  for (const Node& n : kept) jump.push_back(std::abs(n.above - n.below));
  jump.insert(jump.begin(), 0.0);  // jump[k]: at the start of interval k

  origin = nodes.size() > 1 ? nodes[1] : 0.f;
  const double span = inner > 0 ? double(nodes.back()) - origin : 0;
  bool even = inner > 0 && span > 0;
  for (int i = 0; even && i <= inner; i++)
    even = std::abs(double(nodes[1 + i]) - (origin + span * i / inner)) <= 1e-5 * span / inner;
  if (even) {
    uniform = inner;
    inverse = float(inner / span);
  } else {
    const int count = std::clamp(int(std::bit_ceil(unsigned(8 * std::max(inner, 1)))), 64, kMostBuckets);
    const double width = span > 0 ? span / count : 1;
    inverse = float(1 / width);
    buckets.resize(count);
    for (int i = 0, k = 0; i < count; i++) {
      const double start =
          origin + (i - 0.01) * width;  // before the bucket, whatever the rounding of its index
      while (k + 1 < int(nodes.size()) && nodes[k + 1] <= start) k++;
      buckets[i] = k;
    }
  }
  extinction_.build(std::move(extinction));
  slope_.build(std::move(slope));
  jump_.build(std::move(jump));
}

int CompiledMap::intervalOf(float value) const {
  return int(std::upper_bound(nodes.begin() + 1, nodes.end(), value) - nodes.begin()) - 1;
}

double CompiledMap::extinctionAt(int interval, float value) const {
  const size_t k = size_t(interval);
  return double(pieces[8 * k]) + (double(value) - nodes[k]) * double(lengths[k]) * double(pieces[8 * k + 1]);
}

CompiledMap::Over CompiledMap::over(float lo, float hi) const {
  const int a = intervalOf(lo), b = intervalOf(hi);
  // Inside one interval the ends decide: a range that just touches where something begins is transparent.
  if (a == b)
    return {std::max(extinctionAt(a, lo), extinctionAt(a, hi)), hi > lo ? slope_.query(a, a) : 0, 0};
  const bool touches = hi == nodes[size_t(b)];
  Over over{extinctionAt(b, hi), slope_.query(a, touches ? b - 1 : b), jump_.query(a + 1, b)};
  over.extinction = std::max(over.extinction, extinction_.query(a, b - 1));
  return over;
}

void CompiledMap::RangeMax::build(std::vector<double> values) {
  levels.assign(1, std::move(values));
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
