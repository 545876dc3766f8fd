// SPDX-License-Identifier: Apache-2.0
// One head of a line on its way through a block of a mesh.
#pragma once
#include <cstdint>
#include <optional>

#include "core/analysis/cell_motion.h"
#include "core/analysis/cell_step.h"
#include "core/analysis/mesh_fields.h"
#include "core/analysis/mesh_heads.h"

namespace gxy {

/// What is asked of all lines of a call.
struct MeshTrace {
  MeshTrace(const MeshFields& fields, int partition, const TraceOptions& options);

  const MeshFields& fields;
  const int partition;
  const TraceOptions& options;
  const TraceLimits limits;
  const PointsMode points;  ///< EqualLength of field lines, whose time is length
  const double tolerance;   ///< cells of error that a step may add for each cell of way
  const MeshBlock* block;   ///< null: no cell is in the partition
  const double margin;      ///< how far from a point cells are looked for at most, world units
};

/// Moves one head from cell to cell. What becomes of it depends on the head alone: on its place, its cell and what it has behind it. A
/// step lies in one cell and looks at the vectors of this cell only; it ends where it leaves the cell, and the next one begins in the
/// neighbour across that face. Where the block has none, cells around the point are searched, so that lines go on over hanging points and
/// into cells that overlap. One that has all cells of the point must do that: the partition of the point.
class MeshWalk {
 public:
  MeshWalk(const MeshTrace& trace, MeshHead& head, bool backward, uint64_t line, AdvanceResult& result);

  /// Why a head stops.
  enum class Stop : uint8_t { GoesOn, Leaves, Ends };
  /// Goes through cells until the head ends or leaves the block, or has been in `most` more.
  Stop run(int64_t most);
  /// Ends: why.
  EndReason reason() const { return *reason_; }
  /// Leaves: the partition in which it goes on.
  int next() const { return next_; }
  glm::dvec3 world() const { return motion_ ? motion_->worldAt(head_.place) : head_.place; }

  static int64_t spent(const AdvanceCounters& c);

 private:
  bool findCell();
  void goThroughCell();
  std::optional<EndReason> endBeforeStep() const;
  void takeSteps(glm::dvec3 rate);
  enum class Tried : uint8_t { Again, Inside, OnFace, Done };
  double longestStep(glm::dvec3 rate) const;
  Tried takeStep(glm::dvec3& rate, double& time);
  Tried accept(const CellStep& step, StepExit exit, bool shortened, glm::dvec3& rate);
  void setNextStep(const CellStep& step, bool shortened);
  void leave(int face);
  void cross(int face);
  bool findNextCell(glm::dvec3 world);
  void enter(uint32_t cell, glm::dvec3 place);

  bool isSlow(double speed) const;
  bool meetsCondition() const;
  double valueHere(size_t recorded, const reference::ShapeFunctions& shape) const;
  void storeMultiples(const CellStep& step, double part, double time, double length);
  void storeHere() { store(head_.place, head_.time, head_.length); }
  void store(glm::dvec3 place, double time, double length);
  void end(EndReason reason) {
    if (!reason_) reason_ = reason;
  }

  const MeshTrace& t_;
  MeshHead& head_;
  const bool backward_;
  const uint64_t line_;
  AdvanceResult& result_;
  std::optional<CellMotion> motion_;
  std::optional<EndReason> reason_;
  int next_ = -1;
};

}  // namespace gxy
