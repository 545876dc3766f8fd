// SPDX-License-Identifier: Apache-2.0
// DeviceFields: advances heads of lines through fields on one kind of device.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/rays/compiled_fields.h"
#include "core/rays/heads.h"
#include "core/rays/path_points.h"
#include "core/rays/trace_options.h"

namespace gxy {

/// Counters of what was done. They add up.
struct AdvanceCounters {
  uint64_t headsAdvanced = 0;  ///< visits of heads to a partition
  uint64_t cells = 0;          ///< cells that heads went through
  uint64_t steps = 0;          ///< trial steps, repeated ones included
  uint64_t nsAdvance = 0;      ///< nanoseconds
  AdvanceCounters& operator+=(const AdvanceCounters& o);
};

/// What became of heads. It is an ItemResult (core/render/flight.h).
struct AdvanceResult {
  std::vector<HeadList> leaving;  ///< heads that go on in other partitions, one list for each
  PathPoints points;
  std::vector<LineEnd> ends;
  uint64_t retired = 0, created = 0;
  std::string error;  ///< not empty: the call failed, and only `retired` counts
  AdvanceCounters counters;
};

/// Fields on a device, for the partitions of one rank. Calls may come from any number of threads at once.
/// `done` is called once with the result, on any thread, possibly before the call returns, otherwise soon and
/// without further calls; it must be short and must not throw. Until then the object must live. If the device
/// fails, the result says so. A call that throws does not call `done`.
class DeviceFields {
 public:
  using Done = std::function<void(AdvanceResult)>;
  virtual ~DeviceFields() = default;

  /// Advances heads through a local partition until each has ended or left the partition's block. A head that
  /// has no points yet stores its seed. What becomes of a head, to the last bit, depends neither on the
  /// partition nor on the heads beside it. The heads have been checked (wrongHeads), and so have the options.
  virtual void advance(int partition, HeadList heads, const TraceOptions& options, Done done) const = 0;

  /// Bytes that the device holds besides the data.
  virtual size_t bytes() const = 0;
};

/// Fields in plain C++: the kernels' float text without a device. Slow; others are compared with it. Throws
/// Error if a local partition's data cannot be read.
std::unique_ptr<DeviceFields> makePlainFields(std::shared_ptr<const CompiledFields> fields, int rank);

}  // namespace gxy
