// SPDX-License-Identifier: Apache-2.0
#include "backends/embree/embree_fields.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <utility>

#include "advect_ispc.h"

namespace gxy {

namespace {

// The heads that another call goes on with. Those that have moved since their last stored point come first: if
// a call has time for few more cells, they must get where they can stop.
std::vector<int> goingOn(const HeadList& heads) {
  std::vector<int> which;
  for (int i = 0; i < heads.size(); i++)
    if (heads.view().reason[i] == LINE_GOES_ON) which.push_back(i);
  std::stable_partition(which.begin(), which.end(), [&](int i) { return heads.view().fresh[i] != 0; });
  return which;
}

}  // namespace

EmbreeFields::EmbreeFields(std::shared_ptr<const CompiledFields> fields, int rank)
    : fields_(std::move(fields)), parts_(flowPartsOf(*fields_, rank)) {}

void EmbreeFields::addPoints(const FlowPart& part, const TraceOptions& options, const HeadList& heads,
                             const StoredView& points, size_t count, PathPoints& out) const {
  const RecordValues record = [&](size_t k, const StoredView& stored, size_t n, float* values) {
    const Volume& volume = *fields_->volumes()[size_t(fields_->recorded()[k].volume)];
    ispc::recordValues(&part.recorded[k], &stored, int(n), values);
    for (size_t i = 0; i < n; i++) values[i] = float(volume.shift + volume.scale * double(values[i]));
  };
  appendPoints(*fields_, options, heads, points, count, record, out);
}

void EmbreeFields::advance(int partition, HeadList heads, const TraceOptions& options, Done done) const {
  const auto start = std::chrono::steady_clock::now();
  const FlowPart& part = partIn(parts_, partition);
  AdvanceResult result;
  result.counters.headsAdvanced = uint64_t(heads.size());
  const single::FlowView flow = flowViewOf(*fields_, *part.extent, options);
  const single::VolumeView* condition =
      options.condition ? &part.recorded[size_t(options.condition->field)] : nullptr;
  // It is small enough to stay in the cache, and memory that was used before costs less.
  thread_local const StoredPoints stored(8192);
  HeadView view = heads.view();
  StoredView points = stored.view();
  int64_t counts[2] = {0, 0};
  std::fill_n(view.reason, heads.size(), LINE_GOES_ON);
  std::vector<int> which(size_t(heads.size()));
  std::iota(which.begin(), which.end(), 0);
  for (bool full = true; full && !which.empty();) {
    int count = 0;
    const int64_t left = std::max<int64_t>(kCellsPerCall - counts[0] - counts[1] / kStepsPerCell, 1);
    full = ispc::advanceHeads(&flow, part.vectors.data(), condition, &view, which.data(), int(which.size()),
                              left, &points, int(stored.capacity()), count, counts);
    addPoints(part, options, heads, points, size_t(count), result.points);
    if (full) which = goingOn(heads);
  }
  finishHeads(*fields_, options, std::move(heads), result);
  result.counters.cells = uint64_t(counts[0]);
  result.counters.steps = uint64_t(counts[1]);
  result.counters.nsAdvance =
      uint64_t(std::chrono::nanoseconds(std::chrono::steady_clock::now() - start).count());
  done(std::move(result));
}

}  // namespace gxy
