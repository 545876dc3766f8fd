// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyrender/reference_scene.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "core/kernels/single.h"
#include "core/scene/colormaps.h"

namespace gxy {

namespace {

/// As backends compare it: with samples as these are stored, so that one equal to a sample meets it.
double asStored(double value, double shift, double scale) {
  return shift + scale * double(float((value - shift) / scale));
}

/// The same for steps of a map, which are points at one value, or justAbove another.
template <class Point>
void storeSteps(std::vector<Point>& points, double shift, double scale) {
  double before = std::numeric_limits<double>::quiet_NaN();  // as given
  for (size_t i = 0, next; i < points.size(); i = next) {
    const double given = points[i].value;
    for (next = i + 1; next < points.size() && points[next].value == given;) next++;
    const bool step = next > i + 1, above = step && given == justAbove(before);
    if (above) points[i - 1].value = asStored(before, shift, scale);
    const double value = above  ? justAbove(points[i - 1].value)
                         : step ? asStored(given, shift, scale)
                                : given;
    for (size_t k = i; k < next; k++) points[k].value = value;
    before = given;
  }
}

/// The same for all values in the Vis of a volume or a mesh; its maps are then over values.
void storeFieldVis(Vis& vis, double shift, double scale) {
  for (double& v : vis.isovalues) v = asStored(v, shift, scale);
  vis.colormap = effectiveColorMap(vis);
  vis.opacitymap = effectiveOpacityMap(vis);
  vis.dataRange.reset();
  storeSteps(vis.colormap.points, shift, scale);
  storeSteps(vis.opacitymap.points, shift, scale);
}

}  // namespace

reference::ReferenceScene referenceScene(const Visualization& visualization,
                                         std::span<const OperatorData> data, const RenderSettings& settings) {
  reference::ReferenceScene scene{visualization, {}, settings};
  for (size_t i = 0; i < data.size(); i++) {
    Vis& vis = scene.visualization.operators[i];
    if (data[i].volume) {
      scene.data.emplace_back(data[i].volume);
      storeFieldVis(vis, data[i].volume->shift, data[i].volume->scale);
    } else if (data[i].mesh) {
      scene.data.emplace_back(
          std::make_shared<const reference::MeshField>(*data[i].mesh, vis.component, vis.cells));
      storeFieldVis(vis, data[i].mesh->shift, data[i].mesh->scale);
    } else {
      scene.data.emplace_back(data[i].geometry);
      vis.colormap = effectiveColorMap(vis);
      vis.dataRange.reset();
      storeSteps(vis.colormap.points, 0, 1);
      // the reference takes the map's first colour for geometry without values
      if (!hasValues(*data[i].geometry)) vis.colormap = {{ColorPoint{0, data[i].color}}};
    }
  }
  return scene;
}

reference::ReferenceScene referenceScene(const State& state, const LoadedState& loaded, size_t v) {
  const Visualization visualization = loaded.visualization(state, v);
  std::vector<OperatorData> data = loaded.data[v];
  SingleRank alone;
  const EnterMemory enter = [](const char*, int64_t) { return LedgerEntry(); };
  for (size_t i = 0; i < data.size(); i++)  // what is compiled has no blocks any more
    if (data[i].owned)
      data[i].geometry =
          distributed(data[i].owned, visualization.operators[i], *loaded.partitioning, alone, enter);
  return referenceScene(visualization, data, state.settings);
}

reference::AoDirections occlusionDirections(int aoCount, int width, uint32_t frameNumber) {
  const auto count = uint32_t(aoCount), columns = uint32_t(width);
  return [=](const reference::AoRequest& request) {
    const single::vec3 normal =
        single::make_v3(float(request.normal.x), float(request.normal.y), float(request.normal.z));
    const uint32_t pixel = uint32_t(request.pixel.y) * columns + uint32_t(request.pixel.x);
    std::vector<glm::dvec3> directions;
    for (uint32_t k = 0; k < count; k++) {
      const single::vec3 d =
          single::occlusionDirection(normal, pixel, uint32_t(request.sample), frameNumber, k, count);
      directions.push_back(glm::normalize(glm::dvec3(d.x, d.y, d.z)));
    }
    return directions;
  };
}

}  // namespace gxy
