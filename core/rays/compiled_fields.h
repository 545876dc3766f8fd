// SPDX-License-Identifier: Apache-2.0
// CompiledFields: fields on one grid through which lines go, in the kernels' units, and who owns which cell.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/data/partitioning.h"
#include "core/data/volume.h"
#include "core/rays/line_fields.h"

namespace gxy {

/// The most volumes that lines can read.
inline constexpr size_t kMostFields = 8;

/// A component of a volume whose values are recorded at stored points.
struct RecordedField {
  int volume = 1;     ///< index into CompiledFields::volumes()
  int component = 0;  ///< < 0: the magnitude of all
  bool operator==(const RecordedField&) const = default;
};

/// The units of the kernel. Velocities are in cells per unit of time and axis, divided by a power of two, so
/// that a field of any size becomes one of about 1. Lengths are in units that make the longest side of a cell
/// about 1. Both are powers of two, so that nothing is rounded on the way.
struct FlowUnits {
  std::array<float, 3> scale{}, shift{};  ///< cells per kernel time = scale * stored + shift
  std::array<float, 3> spacing{};         ///< kernel lengths per cell
  double time = 1;                        ///< world time of one kernel time
  double length = 1;                      ///< world length of one kernel length
};

/// Up to 8 volumes of one grid and one partitioning. Immutable and thread safe. Keeps the volumes alive.
///
/// A cell belongs to exactly one partition: the one that contains its centre (Partitioning::nearest of it).
/// All ranks compute that alike. The block of that partition has all of the cell's points, and 4 layers of
/// cells around them that heads may go on in.
class CompiledFields final : public LineFields {
 public:
  /// The first volume is the vectors. All components of the others are recorded, in order. Throws Error
  /// unless there are 1 to 8 volumes, the first has 3 components, and all have the same grid and local blocks.
  CompiledFields(std::vector<std::shared_ptr<const Volume>> volumes,
                 std::shared_ptr<const Partitioning> partitioning);

  const Volume& vectors() const { return *volumes_.front(); }
  std::span<const std::shared_ptr<const Volume>> volumes() const { return volumes_; }
  std::span<const RecordedField> recorded() const { return recorded_; }
  const Partitioning& partitioning() const override { return *partitioning_; }
  size_t recordedComponents() const override { return recorded_.size(); }
  HeadKind headKind() const override { return kGridHeads; }
  SeedHeads seeds(std::span<const glm::dvec3> positions, std::span<const uint64_t> ids,
                  TraceDirection direction) const override;
  const char* wrongHeads(const HeadList& heads) const override;
  const Grid& grid() const { return volumes_.front()->grid; }
  const FlowUnits& units() const { return units_; }

  /// The partition that owns a cell of the grid.
  int partitionOf(const Index3& cell) const;
  /// The extent of a local partition's blocks; null if it has none.
  const Extent* extentOf(int partition) const;

  struct Place {
    Index3 cell;
    float fraction[3];  ///< in [0, 1]
  };
  /// Finds the cell of a world point. A point on a face belongs to the upper cell, at the grid's upper end to
  /// the last. Returns false outside the data's box (closed, within 1e-9 cells) and for points that are not
  /// finite.
  bool locate(glm::dvec3 world, Place& place) const;
  /// The world position of a place: one function, so that equal places have equal bits.
  glm::dvec3 worldOf(const Index3& cell, const std::array<float, 3>& fraction) const {
    glm::dvec3 p;
    for (int a = 0; a < 3; a++)
      p[a] = grid().origin[a] + grid().spacing[a] * (double(cell[size_t(a)]) + double(fraction[size_t(a)]));
    return p;
  }

  /// Bytes besides the data.
  size_t bytes() const;

 private:
  std::vector<std::shared_ptr<const Volume>> volumes_;
  std::shared_ptr<const Partitioning> partitioning_;
  std::vector<RecordedField> recorded_;
  FlowUnits units_;
  std::array<std::vector<int32_t>, 3> lattice_;  ///< per axis: the partitioning's lattice cell of each cell
};

}  // namespace gxy
