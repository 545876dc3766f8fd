// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "core/comm/error.h"
#include "core/scene/colormaps.h"

namespace gxy {
namespace {

[[noreturn]] void fail(const std::string& sourceName, TextPosition at, const std::string& message) {
  throw Error(locationPrefix(sourceName, at) + message);
}

/// Reads a flat list of numbers, which come in groups of `group`.
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

/// Whether the preset has the key with the value true or a number other than 0.
bool flag(const JsonValue& preset, const char* key) {
  const JsonMember* member = preset.find(key);
  return member && ((member->value.boolean() && *member->value.boolean()) ||
                    (member->value.number() && member->value.number()->value != 0));
}

ColorSpace colorSpace(const JsonValue& preset, bool& wrapHue, const std::string& sourceName) {
  const JsonMember* member = preset.find("ColorSpace");
  if (!member) return ColorSpace::RGB;
  const std::string name = member->value.string() ? *member->value.string() : "";
  if (name == "RGB") return ColorSpace::RGB;
  if (name == "Lab" || name == "LAB" || name == "CIELAB" || name == "CIELab") return ColorSpace::Lab;
  if (name == "Diverging") return ColorSpace::Diverging;
  if (name == "Step") return ColorSpace::Step;
  if (name == "HSV" || name == "WrappedHSV") {
    wrapHue = flag(preset, "HSVWrap") || name == "WrappedHSV";
    return ColorSpace::HSV;
  }
  fail(sourceName, member->value.at,
       "`ColorSpace`: expected RGB, HSV, Lab (CIELAB), Diverging or Step, found " + member->value.describe());
}

glm::dvec3 colorAt(const std::vector<double>& flat, size_t at) {
  const auto channel = [&](size_t c) { return std::clamp(flat[at + c], 0.0, 1.0); };
  return {channel(0), channel(1), channel(2)};
}

/// Returns the values of `Annotations`, a flat list of values and their names. A value may be written as text.
std::vector<double> annotatedValues(const JsonMember& member, const std::string& sourceName) {
  const JsonValue::Array* items = member.value.array();
  if (!items || items->size() % 2 != 0) {
    fail(sourceName, member.value.at,
         "`Annotations`: expected pairs of a value and a name, found " + member.value.describe());
  }
  std::vector<double> values;
  for (size_t i = 0; i < items->size(); i += 2) {
    const JsonValue& item = (*items)[i];
    double value = item.number() ? item.number()->value : std::numeric_limits<double>::quiet_NaN();
    if (const std::string* text = item.string()) {
      const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
      if (error != std::errc() || end != text->data() + text->size())
        value = std::numeric_limits<double>::quiet_NaN();
    }
    if (!std::isfinite(value))
      fail(sourceName, item.at, "`Annotations`: expected the number of a category, found " + item.describe());
    values.push_back(value);
  }
  return values;
}

/// Returns the map of categories. With `Annotations` there is one category for each of their values, and the
/// colours repeat if there are fewer. Without them there is one category for each colour.
ColorMap categories(const JsonValue& preset, const JsonMember& colors, const std::string& sourceName) {
  const std::vector<double> flat = numbers(colors, 3, sourceName);
  const size_t count = flat.size() / 3;
  std::vector<double> values;
  if (const JsonMember* annotations = preset.find("Annotations"))
    values = annotatedValues(*annotations, sourceName);
  if (values.empty())
    for (size_t i = 0; i < count; ++i) values.push_back(double(i));
  std::vector<ColorPoint> points;
  for (size_t i = 0; i < values.size(); ++i) points.push_back({values[i], colorAt(flat, i % count * 3)});
  std::stable_sort(points.begin(), points.end(), [](auto& a, auto& b) { return a.value < b.value; });
  const auto sameValue = [](auto& a, auto& b) { return a.value == b.value; };
  points.erase(std::unique(points.begin(), points.end(), sameValue), points.end());
  return nearestOf(points);
}

ColorMap colors(const JsonValue& preset, const std::string& sourceName) {
  const JsonMember *member = preset.find("RGBPoints"), *indexed = preset.find("IndexedColors");
  const bool asCategories = flag(preset, "IndexedLookup") || flag(preset, "InterpretValuesAsCategories");
  if (indexed && (asCategories || !member)) return categories(preset, *indexed, sourceName);
  if (!member) {
    fail(sourceName, preset.at,
         "no colours; expected a ParaView preset with `RGBPoints` (value, r, g, b, ...) or `IndexedColors` "
         "(r, g, b, ...)");
  }
  bool wrapHue = false;
  const ColorSpace space = colorSpace(preset, wrapHue, sourceName);
  const std::vector<double> flat = numbers(*member, 4, sourceName);
  std::vector<ColorPoint> points;
  for (size_t i = 0; i < flat.size(); i += 4) points.push_back({flat[i], colorAt(flat, i + 1)});
  std::stable_sort(points.begin(), points.end(), [](auto& a, auto& b) { return a.value < b.value; });
  constexpr size_t kMostCurved = 1024;  // Far beyond any real preset. Each may become 2048 points.
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
  if (const JsonMember* member = preset.find("NanColor")) {
    const std::vector<double> flat = numbers(*member, 3, sourceName);
    if (flat.size() != 3)
      fail(sourceName, member->value.at,
           "`NanColor`: expected three numbers, found " + std::to_string(flat.size()));
    out.colors.nan = colorAt(flat, 0);
  }
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
