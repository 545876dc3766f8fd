// SPDX-License-Identifier: Apache-2.0
#include "selection.h"

#include <algorithm>

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
  visualization_ = std::min(visualization_, state_.visualizations.size() - 1);
  camera_ = std::min(camera_, state_.cameras.size() - 1);
}

State Selection::shown() const {
  return {state_.datasets, state_.settings, {state_.visualizations[visualization_]}, {camera()}};
}

State Selection::with(const Camera& camera) const {
  State state = state_;
  state.cameras[camera_] = camera;
  return state;
}

std::string Selection::text() const {
  const std::string first = place("visualization", visualization_, state_.visualizations.size(),
                                  state_.visualizations[visualization_].annotation),
                    second = place("camera", camera_, state_.cameras.size(), camera().annotation);
  return first + (first.empty() || second.empty() ? "" : ", ") + second;
}

}  // namespace gxy
