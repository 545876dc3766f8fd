// SPDX-License-Identifier: Apache-2.0
// Colour and opacity maps: evaluation, the maps that Galaxy ships, and ParaView's preset files.
#pragma once
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/scene/json_text.h"
#include "core/scene/scene.h"

namespace gxy {

/// The colour at a value: linear between the neighbouring points, the end points' outside. Where points share
/// a value the last of them holds from that value on. NaN gives the map's colour for it, else the first point's.
glm::dvec3 evaluate(const ColorMap& map, double value);
/// The opacity (or extinction) at a value, by the same rules.
double evaluate(const OpacityMap& map, double value);

/// The map stretched linearly so that its first point lies at range[0] and its last at range[1]; a map whose
/// points share one value is moved to range[0].
ColorMap rescaled(const ColorMap& map, const std::array<double, 2>& range);
OpacityMap rescaled(const OpacityMap& map, const std::array<double, 2>& range);

/// The maps of a Vis as rendering applies them: over its data range where it has one.
ColorMap effectiveColorMap(const Vis& vis);
OpacityMap effectiveOpacityMap(const Vis& vis);

/// Names of the shipped maps: Viridis, Inferno, Cool to Warm, Turbo, Gray. All over values 0 to 1, within
/// 1/255 of their published definitions.
std::span<const std::string_view> shippedColorMaps();
/// A shipped map by name, letter case and blanks aside ("cool to warm", "CoolToWarm"); nothing for other
/// names.
std::optional<ColorMap> shippedColorMap(std::string_view name);

/// The next double above a value that is no denormal number: where a step begins that leaves the value itself below it.
double justAbove(double value);

/// Of two neighbouring points the upper one's colour, from justAbove the lower one's value on: a map of constant pieces.
/// Points ascend.
ColorMap steppedAbove(const std::vector<ColorPoint>& points);

/// Categories without mixing: each point's colour holds for the values that are nearest to its own, from half way on.
/// Points ascend.
ColorMap nearestOf(const std::vector<ColorPoint>& points);

enum class ColorSpace { RGB, HSV, Lab, Diverging, Step };

/// The colour a fraction of the way from one to another, interpolated in a colour space as VTK does: Step (at once the
/// other's), HSV without or with the short way round the hue circle, CIE L*a*b* (D65, sRGB companding), or Moreland's
/// diverging Msh ("Diverging Color Maps for Scientific Visualization", ISVC 2009).
glm::dvec3 interpolate(const glm::dvec3& from, const glm::dvec3& to, double fraction, ColorSpace space,
                       bool wrapHue);

/// The map that follows points joined in a colour space, as one that is linear in RGB: within 1/1024, at the
/// price of up to 2047 more points between each two (Step: exactly, steppedAbove). Points ascend, at least one.
ColorMap resampled(const std::vector<ColorPoint>& points, ColorSpace space, bool wrapHue);

/// What a ParaView JSON preset (an array whose first element is used, or the object itself) says: `RGBPoints`
/// in its `ColorSpace`, resampled to linear RGB, or `IndexedColors` for the values of its `Annotations` (without these: 0, 1,
/// 2, ...), and `Points` (value, opacity, midpoint, sharpness; the last two are not used) where
/// present, and `NanColor`. Throws Error with the position in `sourceName` where the preset has no usable points.
struct ColorPreset {
  ColorMap colors;
  std::optional<OpacityMap> opacities;
};
ColorPreset parseColorPreset(const JsonValue& json, const std::string& sourceName);

}  // namespace gxy
