// SPDX-License-Identifier: Apache-2.0
#include "gxy/scene/colormaps.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "gxy/scene/colormap_tables.h"

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
  // Halved so that the distance between points near the ends of double's range stays finite.
  const double fraction = (value / 2 - a.value / 2) / (b.value / 2 - a.value / 2);
  return Result(property(a) * (1 - fraction) + property(b) * fraction);
}

template <class Map>
Map stretched(Map map, const std::array<double, 2>& range) {
  const double first = map.points.front().value, last = map.points.back().value;
  for (auto& point : map.points) {
    const double fraction = last > first ? (point.value / 2 - first / 2) / (last / 2 - first / 2) : 0;
    point.value = range[0] * (1 - fraction) + range[1] * fraction;
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

/// Moreland's cool to warm, from its end colours; his article tabulates it, and VTK computes it the same way.
ColorMap coolToWarm() {
  const glm::dvec3 cool{59.0 / 255, 76.0 / 255, 192.0 / 255};
  const glm::dvec3 warm{180.0 / 255, 4.0 / 255, 38.0 / 255};
  constexpr int kIntervals = 64;  // within 2e-4 of the continuous definition
  ColorMap map;
  for (int i = 0; i <= kIntervals; ++i) {
    const double value = double(i) / kIntervals;
    map.points.push_back({value, interpolate(cool, warm, value, ColorSpace::Diverging, false)});
  }
  return map;
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

glm::dvec3 evaluate(const ColorMap& map, double value) { return piecewiseLinear(map.points, value); }
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
