// SPDX-License-Identifier: Apache-2.0
#include "reference_scene.h"

#include <glm/geometric.hpp>

#include "gxy/kernels/single.h"
#include "gxy/scene/colormaps.h"

namespace gxy {

namespace {

/// As backends compare it: with samples as these are stored, so that one equal to a sample meets it.
double asStored(double value, const Volume& volume) {
  return volume.shift + volume.scale * double(float((value - volume.shift) / volume.scale));
}

/// The same for steps of a map, which are points at one value.
template <class Point>
void storeSteps(std::vector<Point>& points, const Volume& volume) {
  for (size_t i = 0, next; i < points.size(); i = next) {
    for (next = i + 1; next < points.size() && points[next].value == points[i].value;) next++;
    const double value = next > i + 1 ? asStored(points[i].value, volume) : points[i].value;
    for (size_t k = i; k < next; k++) points[k].value = value;
  }
}

}  // namespace

reference::ReferenceScene referenceScene(const Visualization& visualization,
                                         std::span<const OperatorData> data, const RenderSettings& settings) {
  reference::ReferenceScene scene{visualization, {}, settings};
  for (size_t i = 0; i < data.size(); i++) {
    Vis& vis = scene.visualization.operators[i];
    if (data[i].volume) {
      scene.data.emplace_back(data[i].volume);
      for (double& v : vis.isovalues) v = asStored(v, *data[i].volume);
      vis.colormap = effectiveColorMap(vis);
      vis.opacitymap = effectiveOpacityMap(vis);
      vis.dataRange.reset();
      storeSteps(vis.colormap.points, *data[i].volume);
      storeSteps(vis.opacitymap.points, *data[i].volume);
    } else {
      scene.data.emplace_back(data[i].geometry);
      // the reference takes the map's first colour for geometry without values
      if (!hasValues(*data[i].geometry)) vis.colormap = {{ColorPoint{0, data[i].color}}};
    }
  }
  return scene;
}

reference::ReferenceScene referenceScene(const State& state, const LoadedState& loaded, size_t v) {
  return referenceScene(loaded.visualization(state, v), loaded.data[v], state.settings);
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
