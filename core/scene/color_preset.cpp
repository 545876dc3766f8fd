// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "gxy/comm/error.h"
#include "gxy/scene/colormaps.h"

namespace gxy {
namespace {

[[noreturn]] void fail(const std::string& sourceName, TextPosition at, const std::string& message) {
  throw Error(locationPrefix(sourceName, at) + message);
}

/// A flat list of numbers in groups.
std::vector<double> numbers(const JsonMember& member, size_t group, const std::string& sourceName) {
  const JsonValue::Array* items = member.value.array();
  if (!items || items->empty() || items->size() % group != 0) {
    fail(sourceName, member.value.at,
         inQuotes(member.key, '`') + ": expected numbers in groups of " + std::to_string(group) + ", found " +
             member.value.describe());
  }
  std::vector<double> out;
  out.reserve(items->size());
  for (const JsonValue& item : *items) {
    if (!item.number()) {
      fail(sourceName, item.at, inQuotes(member.key, '`') + ": expected a number, found " + item.describe());
    }
    out.push_back(item.number()->value);
  }
  return out;
}

ColorSpace colorSpace(const JsonValue& preset, bool& wrapHue, const std::string& sourceName) {
  const JsonMember* member = preset.find("ColorSpace");
  if (!member) return ColorSpace::RGB;
  const std::string name = member->value.string() ? *member->value.string() : "";
  if (name == "RGB") return ColorSpace::RGB;
  if (name == "Lab") return ColorSpace::Lab;
  if (name == "Diverging") return ColorSpace::Diverging;
  if (name == "HSV" || name == "WrappedHSV") {
    const JsonMember* wrap = preset.find("HSVWrap");
    const bool asked = wrap && ((wrap->value.boolean() && *wrap->value.boolean()) ||
                                (wrap->value.number() && wrap->value.number()->value != 0));
    wrapHue = asked || name == "WrappedHSV";
    return ColorSpace::HSV;
  }
  fail(sourceName, member->value.at,
       "`ColorSpace`: expected RGB, HSV, Lab or Diverging, found " + member->value.describe());
}

/// Appends points between a and b (both excluded) until straight lines in RGB follow the colour space's
/// curve.
class Refiner {
 public:
  Refiner(const ColorPoint& a, const ColorPoint& b, ColorSpace space, bool wrapHue,
          std::vector<ColorPoint>& out)
      : a_(a), b_(b), space_(space), wrapHue_(wrapHue), out_(out) {}

  void refine() { refine(0, a_.rgb, 1, b_.rgb, 0); }

 private:
  static constexpr double kTolerance = 1.0 / 1024;
  static constexpr int kMinDepth = 2, kMaxDepth = 9;

  glm::dvec3 color(double fraction) const { return interpolate(a_.rgb, b_.rgb, fraction, space_, wrapHue_); }

  bool straight(double f0, const glm::dvec3& c0, double f1, const glm::dvec3& c1) const {
    for (const double part : {0.25, 0.5, 0.75}) {
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

ColorMap colors(const JsonValue& preset, const std::string& sourceName) {
  const JsonMember* member = preset.find("RGBPoints");
  if (!member) {
    fail(sourceName, preset.at,
         "no colours; expected a ParaView preset with `RGBPoints` (value, r, g, b, ...)");
  }
  bool wrapHue = false;
  const ColorSpace space = colorSpace(preset, wrapHue, sourceName);
  const std::vector<double> flat = numbers(*member, 4, sourceName);
  std::vector<ColorPoint> points;
  for (size_t i = 0; i < flat.size(); i += 4) {
    const auto channel = [&](size_t c) { return std::clamp(flat[i + c], 0.0, 1.0); };
    points.push_back({flat[i], {channel(1), channel(2), channel(3)}});
  }
  std::stable_sort(points.begin(), points.end(), [](auto& a, auto& b) { return a.value < b.value; });
  if (space == ColorSpace::RGB) return {std::move(points)};

  constexpr size_t kMostPoints = 65536;  // far beyond any real preset; keeps a hostile one small
  ColorMap map{{points.front()}};
  for (size_t i = 1; i < points.size(); ++i) {
    if (points[i - 1].value < points[i].value) {
      Refiner(points[i - 1], points[i], space, wrapHue, map.points).refine();
    }
    map.points.push_back(points[i]);
    if (map.points.size() > kMostPoints) fail(sourceName, member->value.at, "`RGBPoints`: too many points");
  }
  return map;
}

}  // namespace

ColorPreset parseColorPreset(const JsonValue& json, const std::string& sourceName) {
  const JsonValue& preset = json.array() && !json.array()->empty() ? json.array()->front() : json;
  if (!preset.object()) {
    fail(sourceName, preset.at, "expected a ParaView colour preset (an object), found " + preset.describe());
  }
  ColorPreset out{colors(preset, sourceName), std::nullopt};
  if (const JsonMember* member = preset.find("Points")) {
    const std::vector<double> flat = numbers(*member, 4, sourceName);
    out.opacities.emplace();
    for (size_t i = 0; i < flat.size(); i += 4) {
      out.opacities->points.push_back({flat[i], std::clamp(flat[i + 1], 0.0, 1.0)});
    }
    std::stable_sort(out.opacities->points.begin(), out.opacities->points.end(),
                     [](auto& a, auto& b) { return a.value < b.value; });
  }
  return out;
}

}  // namespace gxy
