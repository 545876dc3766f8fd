// SPDX-License-Identifier: Apache-2.0
// A line by the kernels' text in double: tells what the method does from what rounding does.
#pragma once
#include <array>
#include <cmath>
#include <functional>

#include "core/data/volume.h"
#include "core/kernels/twin.h"

namespace gxy::test {

/// A head that the twin moves through a field, which is trilinear between its values at grid points.
class TwinWalk {
 public:
  TwinWalk(const Grid& grid, std::function<glm::dvec3(glm::dvec3)> field, double theta, double kappa)
      : grid_(grid), field_(std::move(field)) {
    view_.spacingX = grid.spacing.x, view_.spacingY = grid.spacing.y, view_.spacingZ = grid.spacing.z;
    view_.theta = theta, view_.kappa = kappa;
    view_.lengthLimit = INFINITY;
    view_.cellsX = view_.endX = int(grid.cells()[0]);
    view_.cellsY = view_.endY = int(grid.cells()[1]);
    view_.cellsZ = view_.endZ = int(grid.cells()[2]);
  }

  /// Moves from a world point for a time. Returns where it comes to, or the last place in the grid.
  glm::dvec3 follow(glm::dvec3 from, double until) {
    view_.timeLimit = until;
    const glm::dvec3 x = (from - grid_.origin) / grid_.spacing;
    for (int a = 0; a < 3; a++)
      cell_[a] = int(std::min(std::floor(x[a]), double(grid_.points[size_t(a)] - 2)));
    f_ = x - glm::dvec3(cell_);
    reason_ = LINE_GOES_ON;
    while (reason_ == LINE_GOES_ON) goThroughCell();
    return grid_.origin + grid_.spacing * (glm::dvec3(cell_) + f_);
  }

  int steps() const { return steps_; }

 private:
  glm::dvec3 corner(int x, int y, int z) const {
    return field_(grid_.origin + grid_.spacing * glm::dvec3(cell_ + glm::ivec3(x, y, z))) / grid_.spacing;
  }

  void goThroughCell() {
    const twin::CellVectors c{corner(0, 0, 0), corner(1, 0, 0), corner(0, 1, 0), corner(1, 1, 0),
                              corner(0, 0, 1), corner(1, 0, 1), corner(0, 1, 1), corner(1, 1, 1)};
    const twin::CellFlow flow = cellFlow(c);
    const glm::dvec3 lo(0), hi(1);
    glm::dvec3 k = flowOnFaces(c, f_, flowAt(flow, f_));
    double speed = twin::flowSpeed(k, grid_.spacing), h = 0;
    int face = twin::faceAtOnce(f_, k, lo, hi), result = face >= 0 ? STEP_EXIT : STEP_AGAIN;
    while (result == STEP_AGAIN || result == STEP_INSIDE) {
      twin::StepShape shape;
      double part;
      result = twin::tryStep(view_, flow, flowDerivative(c), lo, hi, f_, k, speed, h, time_, timeRest_,
                             length_, lengthRest_, stalled_, way_, shape, part, face, reason_);
      steps_++;
    }
    if (result == STEP_EXIT) reason_ = twin::crossFace(view_, face, cell_, f_);
  }

  const Grid grid_;
  const std::function<glm::dvec3(glm::dvec3)> field_;
  twin::FlowView view_{};
  glm::ivec3 cell_{};
  glm::dvec3 f_{};
  double time_ = 0, timeRest_ = 0, length_ = 0, lengthRest_ = 0, way_ = 0;
  int stalled_ = 0, reason_ = LINE_GOES_ON, steps_ = 0;
};

}  // namespace gxy::test
