// SPDX-License-Identifier: Apache-2.0
// Reads and writes the map keys of an operator: inline points, shipped maps and preset files.
#include <algorithm>

#include "core/comm/error.h"
#include "core/scene/colormaps.h"
#include "core/scene/schema.h"

namespace gxy {
namespace {

template <class Point>
void sortPoints(const Found& found, std::vector<Point>& points) {
  const auto ascending = [](const Point& a, const Point& b) { return a.value < b.value; };
  if (std::is_sorted(points.begin(), points.end(), ascending)) return;
  found.warn("points do not ascend by value and were sorted");
  std::stable_sort(points.begin(), points.end(), ascending);
}

std::string shippedNames() {
  std::string out;
  for (const std::string_view name : shippedColorMaps()) out += (out.empty() ? "" : ", ") + std::string(name);
  return out;
}

void readPreset(const Found& found, Vis& vis) {
  ReadContext& context = found.context;
  const std::string& name = found.text();
  try {
    auto known = context.presets.find(name);
    if (known == context.presets.end())
      known = context.presets.emplace(name, parseColorPreset(parseJson(context.contentOf(name), name), name))
                  .first;
    const ColorPreset& preset = known->second;
    context.presetPoints +=
        preset.colors.points.size() + (preset.opacities ? preset.opacities->points.size() : 0);
    if (context.presetPoints > kMaxJsonValues)
      throw Error(inQuotes(name) + ": with it presets give " + std::to_string(context.presetPoints) +
                  " points of maps, expected at most " + std::to_string(kMaxJsonValues));
    vis.colormap = preset.colors;
    if (vis.type == VisType::Volume) vis.colormap.nan.reset();  // NaN colours have no effect on volumes.
    if (preset.opacities && vis.volumeRendering) vis.opacitymap = *preset.opacities;
  } catch (const Error& e) {
    context.fail(found.value.at, inQuotes(found.key, '`') + ": expected the name of a shipped map (" +
                                     shippedNames() + ") or of a ParaView preset file; " + e.what());
  }
}

}  // namespace

void readColorMap(const Found& found, Vis& vis) {
  if (const std::string* name = found.value.string()) {
    if (name->empty() || *name == "default") return;
    if (auto shipped = shippedColorMap(*name)) {
      vis.colormap = std::move(*shipped);
    } else {
      readPreset(found, vis);
    }
    return;
  }
  const std::string expected = "a list of [value, r, g, b], or the name of a map";
  vis.colormap.points.clear();
  for (const Found& item : found.list(expected)) {
    const std::vector<double> v = item.numbers(4, 4, "[value, r, g, b]");
    const glm::dvec3 rgb{item.clampedToUnit(v[1]), item.clampedToUnit(v[2]), item.clampedToUnit(v[3])};
    vis.colormap.points.push_back({v[0], rgb});
  }
  if (vis.colormap.points.empty()) found.fail(expected + " (at least one)");
  sortPoints(found, vis.colormap.points);
}

OpacityMap readOpacityMap(const Found& found, bool extinction) {
  const std::string expected =
      extinction ? "a list of [value, extinction >= 0]" : "a list of [value, opacity]";
  OpacityMap map{extinction, {}};
  for (const Found& item : found.list(expected)) {
    const std::vector<double> v = item.numbers(2, 2, extinction ? "[value, extinction]" : "[value, opacity]");
    if (extinction && v[1] < 0) item.fail("[value, extinction >= 0]");
    map.points.push_back({v[0], extinction ? v[1] : item.clampedToUnit(v[1])});
  }
  if (map.points.empty()) found.fail(expected + " (at least one)");
  sortPoints(found, map.points);
  return map;
}

OrderedJson toJson(const ColorMap& map) {
  OrderedJson out = OrderedJson::array();
  for (const ColorPoint& p : map.points) out.push_back({p.value, p.rgb.r, p.rgb.g, p.rgb.b});
  return out;
}

OrderedJson toJson(const OpacityMap& map) {
  OrderedJson out = OrderedJson::array();
  for (const OpacityPoint& p : map.points) out.push_back({p.value, p.opacity});
  return out;
}

}  // namespace gxy
