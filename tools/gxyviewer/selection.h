// SPDX-License-Identifier: Apache-2.0
// The visualization and camera of a state that are shown.
#pragma once
#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace gxy {

/// A state with a selected visualization, a selected camera, and a selected operator whose maps the user
/// changes. The first of each is selected initially.
class Selection {
 public:
  /// `state` has at least one visualization and one camera.
  explicit Selection(State state) : state_(std::move(state)), original_(state_) {}

  /// Replaces the state. The selected numbers stay, or become the last ones if there are fewer; the operator
  /// then is the first.
  void replace(State state);

  /// Replaces the files of the datasets.
  void setDatasets(const std::vector<DatasetSpec>& datasets) {
    state_.datasets = original_.datasets = datasets;
  }

  /// Select the next (by = 1) or previous (by = -1), cyclically.
  void nextVisualization(int by);
  void nextOperator(int by);
  void nextCamera(int by) { camera_ = next(camera_, state_.cameras.size(), by); }

  /// Calls changeDataRange() for the selected operator. resetRange() restores its range and maps from the
  /// state file.
  void changeRange(double factor, double shift);
  void resetRange();
  /// Returns text for users: "operator 1 of 2, Volume balls: data range 0 to 1.7".
  std::string operatorText() const;

  /// The selected visualization's own camera, if it has one, else the selected one.
  Camera camera() const;
  /// Returns a state with only the selected visualization and camera.
  State shown() const;
  /// Returns the whole state, in which `camera` replaces camera().
  State with(const Camera& camera) const;
  /// Returns text for users: "visualization 2 of 3, NAME, camera 1 of 2". If there is only one of either, it
  /// is not mentioned.
  std::string text() const;

 private:
  static size_t next(size_t at, size_t of, int by) { return (at + of + size_t(by)) % of; }

  const ViewSettings& view() const { return state_.visualizations[visualization_].view; }
  std::vector<Vis>& operators() { return state_.visualizations[visualization_].operators; }

  State state_, original_;
  size_t visualization_ = 0, camera_ = 0, operator_ = 0;
};

}  // namespace gxy
