// SPDX-License-Identifier: Apache-2.0
#include "core/scene/state_pictures.h"

#include <algorithm>
#include <cctype>
#include <cstdio>

#include "core/scene/resolve.h"

namespace gxy {
namespace {

std::string joined(const std::string& annotation) {
  const bool separates = !annotation.empty() && std::ispunct(static_cast<unsigned char>(annotation[0]));
  return annotation.empty() || separates ? annotation : "_" + annotation;
}

}  // namespace

std::vector<StatePicture> picturesOf(const State& state) {
  const size_t rounds = std::max<size_t>(state.cameras.size(), 1);
  std::vector<StatePicture> pictures;
  for (size_t c = 0; c < rounds; c++)
    for (size_t v = 0; v < state.visualizations.size(); v++) {
      const ViewSettings& view = state.visualizations[v].view;
      if (view.camera && c > 0) continue;
      Camera camera = view.camera ? *view.camera : state.cameras.empty() ? defaultCamera() : state.cameras[c];
      if (view.size) camera.dimensions = *view.size;
      pictures.push_back({v, std::move(camera)});
    }
  return pictures;
}

void useOwnCamera(State& state) {
  if (state.visualizations.size() != 1) return;
  ViewSettings& view = state.visualizations[0].view;
  if (view.camera) state.cameras = {*view.camera};
  view.camera.reset();
  if (view.size && state.cameras.empty()) state.cameras = {defaultCamera()};
  if (view.size)
    for (Camera& camera : state.cameras) camera.dimensions = *view.size;
  view.size.reset();
}

std::string pictureName(const std::string& prefix, size_t number, const Visualization& visualization,
                        const Camera& camera) {
  char text[24];
  std::snprintf(text, sizeof text, "_%05zu", number);
  return prefix + text + joined(visualization.annotation) + joined(camera.annotation);
}

}  // namespace gxy
