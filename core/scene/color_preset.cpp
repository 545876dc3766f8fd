// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

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
  constexpr size_t kMostCurved = 1024;  // far beyond any real preset; each may become 2048 points
  if (space != ColorSpace::RGB && points.size() > kMostCurved) {
    fail(sourceName, member->value.at,
         "`RGBPoints`: expected at most 1024 colours in a `ColorSpace` other than RGB");
  }
  return resampled(points, space, wrapHue);
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
