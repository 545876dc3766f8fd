// SPDX-License-Identifier: Apache-2.0
#include "core/scene/colormaps.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "core/scene/colormap_tables.h"

namespace gxy {
namespace {

const glm::dvec3& property(const ColorPoint& point) { return point.rgb; }
double property(const OpacityPoint& point) { return point.opacity; }

template <class Point>
auto piecewiseLinear(const std::vector<Point>& points, double value) {
  using Result = std::decay_t<decltype(property(points.front()))>;
  const auto upper = std::upper_bound(points.begin(), points.end(), value,
                                      [](double v, const Point& p) { return v < p.value; });
  if (upper == points.begin() || value != value) return Result(property(points.front()));
  if (upper == points.end()) return Result(property(points.back()));
  const Point& a = upper[-1];
  const Point& b = *upper;
  // Values are halved so that their difference stays finite even near the ends of double's range.
  const double fraction = (value / 2 - a.value / 2) / (b.value / 2 - a.value / 2);
  return Result(property(a) * (1 - fraction) + property(b) * fraction);
}

/// Maps the first point to range[0] and the last to range[1]. A point that was justAbove() its
/// predecessor stays so.
template <class Map>
Map stretched(Map map, const std::array<double, 2>& range) {
  const double first = map.points.front().value, last = map.points.back().value;
  double old = first;
  for (size_t i = 0; i < map.points.size(); ++i) {
    double& value = map.points[i].value;
    const bool above = i > 0 && value == justAbove(old);
    old = value;
    const double fraction = last > first ? (value / 2 - first / 2) / (last / 2 - first / 2) : 0;
    value = range[0] * (1 - fraction) + range[1] * fraction;
    if (above && range[1] > range[0]) value = justAbove(map.points[i - 1].value);
    if (i > 0) value = std::max(value, map.points[i - 1].value);
  }
  return map;
}

int hexDigit(char c) { return c <= '9' ? c - '0' : c - 'a' + 10; }

ColorMap fromTable(std::string_view table) {
  constexpr size_t kDigits = 6;
  const size_t count = table.size() / kDigits;
  ColorMap map;
  map.points.resize(count);
  for (size_t i = 0; i < count; ++i) {
    map.points[i].value = double(i) / double(count - 1);
    for (int c = 0; c < 3; ++c) {
      const char* digits = &table[i * kDigits + size_t(c) * 2];
      map.points[i].rgb[c] = (hexDigit(digits[0]) * 16 + hexDigit(digits[1])) / 255.0;
    }
  }
  return map;
}

/// Moreland's cool to warm, computed from its end colours as VTK does. His article ("Diverging Color Maps for
/// Scientific Visualization", ISVC 2009) tabulates it.
ColorMap coolToWarm() {
  const glm::dvec3 cool{59.0 / 255, 76.0 / 255, 192.0 / 255};
  const glm::dvec3 warm{180.0 / 255, 4.0 / 255, 38.0 / 255};
  return resampled({{0, cool}, {1, warm}}, ColorSpace::Diverging, false);
}

std::string folded(std::string_view name) {
  std::string out;
  for (const char c : name) {
    if (!std::isspace(static_cast<unsigned char>(c)))
      out += char(std::tolower(static_cast<unsigned char>(c)));
  }
  return out;
}

constexpr std::array<std::string_view, 5> kShipped{"Viridis", "Inferno", "Cool to Warm", "Turbo", "Gray"};

}  // namespace

glm::dvec3 evaluate(const ColorMap& map, double value) {
  return std::isnan(value) && map.nan ? *map.nan : piecewiseLinear(map.points, value);
}
double evaluate(const OpacityMap& map, double value) { return piecewiseLinear(map.points, value); }

ColorMap rescaled(const ColorMap& map, const std::array<double, 2>& range) { return stretched(map, range); }
OpacityMap rescaled(const OpacityMap& map, const std::array<double, 2>& range) {
  return stretched(map, range);
}

ColorMap effectiveColorMap(const Vis& vis) {
  return vis.dataRange ? rescaled(vis.colormap, *vis.dataRange) : vis.colormap;
}
OpacityMap effectiveOpacityMap(const Vis& vis) {
  return vis.dataRange ? rescaled(vis.opacitymap, *vis.dataRange) : vis.opacitymap;
}

double justAbove(double value) {
  constexpr double kLeast = std::numeric_limits<double>::min();
  const double next = std::nextafter(value, std::numeric_limits<double>::infinity());
  return next > -kLeast && next < kLeast ? (value < 0 ? 0 : kLeast) : next;
}

ColorMap steppedAbove(const std::vector<ColorPoint>& points) {
  ColorMap map;
  for (const ColorPoint& p : points) {
    if (!map.points.empty() && p.value > map.points.back().value) {
      const ColorPoint before = map.points.back();
      const double step = std::min(justAbove(before.value), p.value);
      map.points.push_back({step, before.rgb});
      map.points.push_back({step, p.rgb});
    }
    map.points.push_back(p);
  }
  return map;
}

ColorMap nearestOf(const std::vector<ColorPoint>& points) {
  ColorMap map;
  for (const ColorPoint& p : points) {
    if (!map.points.empty() && p.value > map.points.back().value) {
      const ColorPoint before = map.points.back();
      const double middle = before.value / 2 + p.value / 2;
      map.points.push_back({middle, before.rgb});
      map.points.push_back({middle, p.rgb});
    }
    map.points.push_back(p);
  }
  return map;
}

std::span<const std::string_view> shippedColorMaps() { return kShipped; }

std::optional<ColorMap> shippedColorMap(std::string_view name) {
  const std::string wanted = folded(name);
  if (wanted == "viridis") return fromTable(kViridisTable);
  if (wanted == "inferno") return fromTable(kInfernoTable);
  if (wanted == "turbo") return fromTable(kTurboTable);
  if (wanted == "cooltowarm") return coolToWarm();
  if (wanted == "gray" || wanted == "grey") return ColorMap{{{0, {0, 0, 0}}, {1, {1, 1, 1}}}};
  return std::nullopt;
}

}  // namespace gxy
