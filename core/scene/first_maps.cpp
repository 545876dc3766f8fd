// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/scene/colormaps.h"
#include "core/scene/first_look.h"

namespace gxy {
namespace {

constexpr const char* kColors = "Inferno";
constexpr int kSlabs = 50;  // number of reference lengths along the extent

struct MapPoint {
  double value;
  double part;        ///< position in the colour map, 0 to 1
  double extinction;  ///< per extent, not per world unit
};

double opacityOf(double extinction) { return 1 - std::exp(-extinction / kSlabs); }

/// Whether the middle nine tenths of the values fill at least half of the range. Then the maps follow the
/// values themselves.
bool isSpread(std::span<const float> values) {
  const double range = double(values.back()) - double(values.front());
  return quantile(values, 0.95) - quantile(values, 0.05) >= range / 2;
}

/// Few rays meet only the rarest values, so the bright half of the colours begins below the middle.
double brightened(double part) { return 1 - std::pow(1 - part, 2.4); }

/// Colour and opacity rise with the value. A ray through average values has an optical depth of kDepth.
std::vector<MapPoint> ramp(std::span<const float> values) {
  constexpr double kDepth = 1.5;
  const double lo = values.front(), hi = values.back();
  double mean = 0;
  for (const float v : values) mean += std::pow((double(v) - lo) / (hi - lo), 2) / double(values.size());
  const double most = kDepth / std::max(mean, 0.01);
  std::vector<MapPoint> points;
  for (int k = 0; k <= 4; k++)
    points.push_back({lo + (hi - lo) * k / 4, brightened(k / 4.0), most * k * k / 16});
  return points;
}

/// Returns the fraction of the values, counted from the lowest, that stays transparent: half of them, or more
/// if the values are a hump with a tail of other origin, such as vessels in noise. Then it is the hump. The
/// values are a hump if they lie about as close above the median as below it. The tail is of other origin if
/// the last hundredth begins more than kApart times as far from the median as the last quarter does; that
/// factor is 3.4 for a normal distribution and 5.6 for an exponential one.
double bulkOf(std::span<const float> values) {
  constexpr double kApart = 8, kHump = 4, kEven = 0.7;
  const double median = quantile(values, 0.5), quarter = quantile(values, 0.75) - median;
  const bool isHump = median - quantile(values, 0.25) >= kEven * quarter;
  if (!isHump || quantile(values, 0.99) - median <= kApart * quarter) return 0.5;
  const auto end = std::upper_bound(values.begin(), values.end(), float(median + kHump * quarter));
  return std::max(0.5, double(end - values.begin()) / double(values.size()));
}

/// The bulk of the values stays transparent. Above it, rarer bands of values are more opaque, so that rays
/// meet about the same optical depth in each band.
std::vector<MapPoint> quantileBands(std::span<const float> values, double bulk) {
  constexpr double kDepth = 0.6;
  constexpr double kParts[] = {1, 0.5, 0.2, 0.06, 0.02, 0.004};  // fractions of the values above the bulk
  std::vector<MapPoint> points{{values.front(), 0, 0}};
  for (const double part : kParts) {
    const double above = (1 - bulk) * part;
    const double value = quantile(values, 1 - above);
    if (value <= points.back().value || value >= double(values.back())) continue;
    points.push_back({value, 0, part == 1 ? 0 : kDepth / above});
  }
  points.push_back({values.back(), 0, 2 * std::max(points.back().extinction, kDepth / 0.01)});
  for (size_t k = 0; k < points.size(); k++)
    points[k].part = brightened(double(k) / double(points.size() - 1));
  return points;
}

/// Returns the colours at the points and, because the shipped map curves, at places between them. Only the
/// colours of the shipped map from `from` (0 to 1) on are used.
ColorMap colorsOf(const std::vector<MapPoint>& points, double from) {
  constexpr int kBetween = 4;
  const ColorMap shipped = *shippedColorMap(kColors);
  ColorMap colors;
  colors.points.clear();
  const auto add = [&](double value, double part) {
    colors.points.push_back({value, evaluate(shipped, from + (1 - from) * part)});
  };
  for (size_t k = 0; k + 1 < points.size(); k++)
    for (int i = 0; i < kBetween; i++) {
      const double t = double(i) / kBetween;
      add(points[k].value + t * (points[k + 1].value - points[k].value),
          points[k].part + t * (points[k + 1].part - points[k].part));
    }
  add(points.back().value, points.back().part);
  return colors;
}

bool isConstant(std::span<const float> values) { return values.empty() || values.front() == values.back(); }

}  // namespace

void completeSample(LookFacts& facts) {
  const Range& range = facts.data.ranges.back();
  if (!range.empty() && !facts.values.empty())
    facts.values.insert(facts.values.end(), {float(range.min), float(range.max)});
  std::sort(facts.values.begin(), facts.values.end());
}

double quantile(std::span<const float> ascending, double fraction) {
  return double(ascending[size_t(fraction * double(ascending.size() - 1))]);
}

FirstMaps firstMaps(std::span<const float> values, double extent) {
  FirstMaps maps;
  maps.referenceLength = extent / kSlabs;
  if (isConstant(values)) {
    const double value = values.empty() ? 0 : double(values.front());
    maps.colors.points = {{value, evaluate(*shippedColorMap(kColors), 0.7)}};
    maps.opacities.points = {{value, opacityOf(1)}};
    return maps;
  }
  const bool spread = isSpread(values);
  const double bulk = spread ? 0 : bulkOf(values);
  const auto points = spread ? ramp(values) : quantileBands(values, bulk);
  maps.colors = colorsOf(points, bulk > 0.5 ? 0.45 : 0);  // All values above a hump are bright.
  maps.opacities.points.clear();
  for (const MapPoint& point : points)
    maps.opacities.points.push_back({point.value, opacityOf(point.extinction)});
  return maps;
}

ColorMap firstSurfaceColors(std::span<const float> values) {
  constexpr double kFrom = 0.3;
  ColorMap white;
  white.points = {{0, glm::dvec3(0.95, 0.93, 0.9)}};
  if (isConstant(values)) return white;
  return colorsOf(isSpread(values) ? ramp(values) : quantileBands(values, 0.5), kFrom);
}

double firstIsovalue(std::span<const float> values) {
  if (values.empty()) return 0;
  if (!isSpread(values)) return quantile(values, 0.95);
  return (quantile(values, 0.02) + quantile(values, 0.98)) / 2;
}

}  // namespace gxy
