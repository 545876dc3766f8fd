// SPDX-License-Identifier: Apache-2.0
// Fills the structures that the kernels of lines read from compiled fields and options, and makes results of
// what they write; the same for all devices.
#pragma once
#include <array>
#include <functional>
#include <map>
#include <vector>

#include "core/kernels/single.h"
#include "core/rays/compiled_fields.h"
#include "core/rays/device_fields.h"
#include "core/rays/stored_fields.h"

namespace gxy {

/// What is asked of lines in a partition's block, in the kernels' units.
single::FlowView flowViewOf(const CompiledFields& fields, const Extent& block, const TraceOptions& options);

/// One component of a volume's block, for reading samples only; component < 0: the magnitude.
single::VolumeView samplesViewOf(const Volume& volume, const VolumeBlock& block, int component);

/// The volumes in one partition, as kernels read them.
struct FlowPart {
  const Extent* extent = nullptr;
  std::array<single::VolumeView, 3> vectors{};  ///< by component
  std::vector<single::VolumeView> recorded;
};
using FlowParts = std::map<int, FlowPart>;  ///< by partition
FlowParts flowPartsOf(const CompiledFields& fields, int rank);
size_t bytesOf(const FlowParts& parts);
/// Throws Error if there is nothing in the partition.
const FlowPart& partIn(const FlowParts& parts, int partition);

/// The most cells that heads go through in one call. The rest of them then goes on in the same partition, so
/// that no call takes long and no result is large.
inline constexpr int64_t kCellsPerCall = 1 << 18;
/// So many trial steps count as a cell there: heads may go round in one cell.
inline constexpr int64_t kStepsPerCell = 8;

/// Stored points as kernels write them (stored_fields.h).
struct StoredView {
#define GXY_FIELD(type, name) type* name;
  GXY_STORED_FIELDS(GXY_FIELD)
#undef GXY_FIELD
};

/// Owns the arrays of up to `capacity` stored points. Movable.
class StoredPoints {
 public:
  explicit StoredPoints(size_t capacity);
  const StoredView& view() const { return view_; }
  size_t capacity() const { return capacity_; }

 private:
  size_t capacity_;
  std::vector<uint32_t> storage_;
  StoredView view_{};
};

/// Fills values[i] with a recorded component at stored points, where there are any.
using RecordValues =
    std::function<void(size_t component, const StoredView& points, size_t count, float* values)>;

/// Appends stored points of a packet to a result.
void appendPoints(const CompiledFields& fields, const TraceOptions& options, const HeadList& heads,
                  const StoredView& points, size_t count, const RecordValues& record, PathPoints& out);

/// Sorts a packet into ends and heads that leave, by `reason`; those that go on (LINE_GOES_ON) leave to the
/// partition that they are in.
void finishHeads(const CompiledFields& fields, const TraceOptions& options, HeadList heads,
                 AdvanceResult& result);

}  // namespace gxy
