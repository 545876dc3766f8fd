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

/// Returns the colour at a value: linear between the neighbouring points, and the colour of an end point
/// outside. If points share a value, the last of them holds from that value on. NaN gives the map's colour
/// for NaN, or the first point's colour if the map has none.
glm::dvec3 evaluate(const ColorMap& map, double value);
/// Returns the opacity (or extinction) at a value, by the same rules; NaN gives that of the first point.
double evaluate(const OpacityMap& map, double value);

/// Returns the map stretched linearly so that its first point lies at range[0] and its last at range[1]. A
/// map whose points share one value is moved to range[0].
ColorMap rescaled(const ColorMap& map, const std::array<double, 2>& range);
OpacityMap rescaled(const OpacityMap& map, const std::array<double, 2>& range);

/// Returns the map of a Vis as rendering applies it: stretched over the Vis's data range, if it has one.
ColorMap effectiveColorMap(const Vis& vis);
OpacityMap effectiveOpacityMap(const Vis& vis);

/// Returns the names of the shipped maps: Viridis, Inferno, Cool to Warm, Turbo, Gray. They span values 0 to
/// 1 and are within 1/255 of their published definitions.
std::span<const std::string_view> shippedColorMaps();
/// Returns the shipped map with this name, or nothing. Letter case and blanks do not matter ("cool to
/// warm", "CoolToWarm").
std::optional<ColorMap> shippedColorMap(std::string_view name);

/// Returns the next double above `value` that is not a denormal number. A step placed there leaves `value`
/// itself below the step.
double justAbove(double value);

/// Returns a map of constant pieces. Between two neighbouring points it has the upper point's colour, from
/// justAbove() the lower point's value on. Points ascend.
ColorMap steppedAbove(const std::vector<ColorPoint>& points);

/// Returns a map for categories, without mixed colours: each value gets the colour of the nearest point, and
/// the upper one half way between two. Points ascend.
ColorMap nearestOf(const std::vector<ColorPoint>& points);

enum class ColorSpace { RGB, HSV, Lab, Diverging, Step };

/// Returns the colour at a fraction, 0 to 1, of the way from `from` to `to`, interpolated in a colour space
/// as VTK does. Step gives `to` at once. HSV takes the short way round the hue circle if `wrapHue` is set.
/// Lab is CIE L*a*b* (D65, sRGB companding). Diverging is Moreland's Msh ("Diverging Color Maps for
/// Scientific Visualization", ISVC 2009).
glm::dvec3 interpolate(const glm::dvec3& from, const glm::dvec3& to, double fraction, ColorSpace space,
                       bool wrapHue);

/// Returns a map linear in RGB that approximates `points` interpolated in `space`, within 1/1024. It adds up to
/// 2047 points between each two. Step gives steppedAbove(), which is exact. Points ascend; there is at least one.
ColorMap resampled(const std::vector<ColorPoint>& points, ColorSpace space, bool wrapHue);

/// The maps of a ParaView JSON preset.
struct ColorPreset {
  ColorMap colors;
  std::optional<OpacityMap> opacities;
};

/// Reads a ParaView JSON preset: an object, or an array whose first element is used. Colours come from
/// `RGBPoints` in the preset's `ColorSpace`, resampled to linear RGB, or from `IndexedColors` at the values
/// of `Annotations` (0, 1, 2, ... if there are none), and the colour for NaN from `NanColor`. Opacities come
/// from `Points`, if present: value, opacity, midpoint and sharpness, of which the last two are not used.
/// Throws Error with the position in `sourceName` if the preset is malformed or has no colours.
ColorPreset parseColorPreset(const JsonValue& json, const std::string& sourceName);

}  // namespace gxy
