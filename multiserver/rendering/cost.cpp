// SPDX-License-Identifier: Apache-2.0
#include "multiserver/rendering/cost.h"

#include <string>

#include "core/comm/error.h"

namespace gxy {

namespace {

void check(const char* what, int64_t value, int64_t most) {
  if (value > most)
    throw Error(std::string("rendering: ") + std::to_string(value) + " " + what + ", expected at most " +
                std::to_string(most));
}

}  // namespace

void checkCost(const RenderSettings& settings, glm::ivec2 size) {
  constexpr int64_t kRays = int64_t(1) << 31;
  check("primary rays", int64_t(size.x) * size.y * settings.raysPerPixel, kRays);
}

void checkOperators(size_t count) {
  constexpr int64_t kOperators = 64;
  check("operators", int64_t(count), kOperators);
}

void checkCost(const Visualization& visualization) {
  constexpr int64_t kOcclusion = 256, kLights = 64;
  constexpr int64_t kSurfaces = 256, kClips = 64, kMapPoints = 65536;
  check("ambient-occlusion rays per hit", visualization.lighting.aoCount, kOcclusion);
  check("lights", int64_t(visualization.lighting.sources.size()), kLights);
  checkOperators(visualization.operators.size());
  // Compiling looks at all data for each isovalue and slice.
  size_t surfaces = 0, clips = 0, points = 0;
  for (const Vis& vis : visualization.operators) {
    surfaces += vis.isovalues.size() + vis.slices.size();
    clips += vis.clipPlanes.size();
    points += vis.colormap.points.size() + vis.opacitymap.points.size();
  }
  check("isovalues and slices", int64_t(surfaces), kSurfaces);
  check("clip planes", int64_t(clips), kClips);
  check("points of maps", int64_t(points), kMapPoints);
}

int64_t bytesOf(const Visualization& visualization) {
  size_t bytes = visualization.annotation.size() +
                 visualization.lighting.sources.size() * sizeof visualization.lighting.sources[0];
  for (const Vis& vis : visualization.operators)
    bytes += sizeof vis + vis.dataset.size() + vis.isovalues.size() * sizeof vis.isovalues[0] +
             (vis.slices.size() + vis.clipPlanes.size()) * sizeof vis.slices[0] +
             vis.colormap.points.size() * sizeof vis.colormap.points[0] +
             vis.opacitymap.points.size() * sizeof vis.opacitymap.points[0];
  return int64_t(bytes);
}

int64_t bytesOf(const State& state) {
  auto bytes =
      int64_t(state.visualizations.size() * sizeof(Visualization) + state.cameras.size() * sizeof(Camera) +
              state.datasets.size() * sizeof(DatasetSpec) + state.annotations.text.size());
  for (const Visualization& v : state.visualizations) bytes += bytesOf(v);
  return bytes;
}

}  // namespace gxy
