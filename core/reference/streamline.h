// SPDX-License-Identifier: Apache-2.0
// Lines through a vector field in double, by tiny steps: the truth that others are compared with.
#pragma once
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "core/reference/field.h"

namespace gxy::reference {

/// Where a line has come to: a place in a cell, and the time and length since its start.
struct StreamlinePlace {
  Index3 cell{0, 0, 0};
  glm::dvec3 fraction{0};
  double time = 0, length = 0;
};

/// A vector field, trilinear in each cell, and lines through it. A step goes over a small part of a cell by the
/// classical Runge-Kutta method with the polynomial of that cell; the last one in a cell is halved until it
/// ends on the face. Immutable; safe to use from any thread; keeps the volume alive.
class Streamlines {
 public:
  /// A step is 1 / `steps` of a cell long at most. Throws Error unless the volume is whole in partition 0 and
  /// has three components.
  explicit Streamlines(std::shared_ptr<const Volume> volume, int steps = 64, bool backward = false);

  /// Why a line has not gone on; None: it has.
  enum class End { None, Time, Left, NoData, Zero };

  StreamlinePlace start(glm::dvec3 world) const;
  glm::dvec3 world(const StreamlinePlace& place) const;
  /// The velocity at a place, world units per unit of time.
  glm::dvec3 velocity(const StreamlinePlace& place) const;

  /// Moves a line out of its cell into the next one, or for `time` at most.
  End crossCell(StreamlinePlace& place, double time) const;
  /// Moves a line until `place.time` has grown by `time`, through at most `cells` cells.
  End follow(StreamlinePlace& place, double time, int64_t cells = 1 << 30) const;

 private:
  using Corners = std::array<CellCorners, 3>;
  struct State {
    glm::dvec3 f;
    double length;
  };
  std::optional<Corners> corners(const Index3& cell) const;
  glm::dvec3 cellVelocity(const Corners& c, glm::dvec3 f) const;
  State step(const Corners& c, const State& s, double h) const;
  End leave(StreamlinePlace& place, int axis, bool up) const;

  std::array<Field, 3> components_;
  const int steps_;
  const double sign_;
};

}  // namespace gxy::reference
