// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/selection.h"

#include <algorithm>
#include <cstdio>

#include "tools/gxyviewer/data_range.h"

namespace gxy {

namespace {

std::string place(const char* what, size_t index, size_t of, const std::string& name) {
  if (of == 1) return {};
  return std::string(what) + " " + std::to_string(index + 1) + " of " + std::to_string(of) +
         (name.empty() ? "" : ", " + name);
}

}  // namespace

void Selection::replace(State state) {
  state_ = std::move(state);
  original_ = state_;
  visualization_ = std::min(visualization_, state_.visualizations.size() - 1);
  camera_ = std::min(camera_, state_.cameras.size() - 1);
  if (operator_ >= operators().size()) operator_ = 0;
}

void Selection::nextVisualization(int by) {
  visualization_ = next(visualization_, state_.visualizations.size(), by);
  operator_ = 0;
}

void Selection::nextOperator(int by) {
  if (!operators().empty()) operator_ = next(operator_, operators().size(), by);
}

void Selection::changeRange(double factor, double shift) {
  if (!operators().empty()) changeDataRange(operators()[operator_], factor, shift);
}

void Selection::resetRange() {
  if (operators().empty()) return;
  const Vis& before = original_.visualizations[visualization_].operators[operator_];
  Vis& vis = operators()[operator_];
  vis.dataRange = before.dataRange;
  vis.colormap = before.colormap;
  vis.opacitymap = before.opacitymap;
}

std::string Selection::operatorText() const {
  const std::vector<Vis>& all = state_.visualizations[visualization_].operators;
  if (all.empty()) return "there is no operator";
  const Vis& vis = all[operator_];
  constexpr const char* kTypes[] = {"Volume", "Particles", "PathLines", "Triangles"};
  std::string range = ": its maps are constant";
  if (const auto r = dataRangeOf(vis)) {
    char text[64];
    std::snprintf(text, sizeof text, ": data range %.4g to %.4g", (*r)[0], (*r)[1]);
    range = text;
  }
  return "operator " + std::to_string(operator_ + 1) + " of " + std::to_string(all.size()) + ", " +
         kTypes[size_t(vis.type)] + " " + vis.dataset + range;
}

Camera Selection::camera() const {
  Camera camera = view().camera.value_or(state_.cameras[camera_]);
  if (view().size) camera.dimensions = *view().size;
  return camera;
}

State Selection::shown() const {
  State shown{state_.datasets, state_.settings,    {state_.visualizations[visualization_]},
              {camera()},      state_.annotations, {}};
  shown.visualizations[0].view = {};
  return shown;
}

State Selection::with(const Camera& camera) const {
  State state = state_;
  ViewSettings& view = state.visualizations[visualization_].view;
  if (view.size) view.size = camera.dimensions;
  (view.camera ? *view.camera : state.cameras[camera_]) = camera;
  return state;
}

std::string Selection::text() const {
  const std::string first = place("visualization", visualization_, state_.visualizations.size(),
                                  state_.visualizations[visualization_].annotation),
                    second = view().camera
                                 ? std::string()
                                 : place("camera", camera_, state_.cameras.size(), camera().annotation);
  return first + (first.empty() || second.empty() ? "" : ", ") + second;
}

}  // namespace gxy
