// SPDX-License-Identifier: Apache-2.0
#include "reference_scene.h"

#include <glm/geometric.hpp>

#include "gxy/kernels/single.h"

namespace gxy {

reference::ReferenceScene referenceScene(const State& state, const LoadedState& loaded, size_t v) {
  reference::ReferenceScene scene{loaded.visualization(state, v), {}, state.settings};
  for (size_t i = 0; i < loaded.data[v].size(); i++) {
    const OperatorData& data = loaded.data[v][i];
    if (data.volume) {
      scene.data.emplace_back(data.volume);
    } else {
      scene.data.emplace_back(data.geometry);
      // the reference takes the map's first colour for geometry without values
      if (data.geometry->range.empty())
        scene.visualization.operators[i].colormap = {{ColorPoint{0, data.color}}};
    }
  }
  return scene;
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
