// SPDX-License-Identifier: Apache-2.0
// Which of a state's visualizations and cameras is shown.
#pragma once
#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace gxy {

/// A state, the one visualization and the one camera of it that are shown, and the operator whose maps are changed: the first
/// of each at first.
class Selection {
 public:
  /// `state` has a visualization and a camera.
  explicit Selection(State state) : state_(std::move(state)), original_(state_) {}

  /// Another state, as far as it has as many of both shown at the same places.
  void replace(State state);

  /// The same data of other files.
  void setDatasets(const std::vector<DatasetSpec>& datasets) {
    state_.datasets = original_.datasets = datasets;
  }

  /// The next, before the first the last.
  void nextVisualization(int by);
  void nextOperator(int by);
  void nextCamera(int by) { camera_ = next(camera_, state_.cameras.size(), by); }

  /// Of the operator's maps; as in the state file again.
  void changeRange(double factor, double shift);
  void resetRange();
  /// "operator 1 of 2, Volume balls: data range 0 to 1.7", for people.
  std::string operatorText() const;

  const Camera& camera() const { return state_.cameras[camera_]; }
  /// What is shown as a state of its own, with one visualization and one camera.
  State shown() const;
  /// The whole state, with `camera` in the place of the one that is shown.
  State with(const Camera& camera) const;
  /// "visualization 2 of 3, NAME, camera 1 of 2", for people; of what there is one of, nothing.
  std::string text() const;

 private:
  static size_t next(size_t at, size_t of, int by) { return (at + of + size_t(by)) % of; }

  std::vector<Vis>& operators() { return state_.visualizations[visualization_].operators; }

  State state_, original_;
  size_t visualization_ = 0, camera_ = 0, operator_ = 0;
};

}  // namespace gxy
