// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/sampled_points.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "core/analysis/made_geometry.h"
#include "core/analysis/sample_order.h"
#include "core/comm/error.h"

namespace gxy {

namespace {

SampleKey sampleKeyOf(const SampleList& list, size_t i) { return {list.ray[i], list.depth[i], list.hit[i]}; }

std::vector<uint32_t> sampleOrderOf(const SampleList& list) {
  if (list.size() > UINT32_MAX)
    throw Error("a rank has " + std::to_string(list.size()) + " samples, expected at most 2^32 - 1");
  std::vector<uint32_t> order(list.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](uint32_t a, uint32_t b) { return sampleKeyOf(list, a) < sampleKeyOf(list, b); });
  return order;
}

// The values and fields of the samples `which`, in that order. A rank without samples has no lists.
void takeSampledFields(const SampleList& list, std::span<const uint32_t> which,
                       const SampledVolumes& recorded, bool gradient, GeometryBlock& block) {
  if (which.empty()) return;
  size_t next = 0;
  if (!recorded.sampled.empty()) {
    for (const uint32_t i : which) block.values.push_back(list.values[0][i]);
    next = 1;
  }
  for (const PointField& f : recorded.fields) {
    PointField& made = block.fields.emplace_back(f);
    made.values.reserve(which.size() * size_t(f.components));
    for (const uint32_t i : which)
      for (size_t c = 0; c < size_t(f.components); c++) made.values.push_back(list.values[next + c][i]);
    next += size_t(f.components);
  }
  if (!gradient) return;
  PointField& made = block.fields.emplace_back(PointField{kGradientField, 3, {}});
  for (const uint32_t i : which)
    for (int a = 0; a < 3; a++) made.values.push_back(list.gradient[i][a]);
}

}  // namespace

std::shared_ptr<Dataset> sampledPoints(FilterRun& run, const std::string& name, TakenSamples samples,
                                       uint64_t most, std::shared_ptr<const Partitioning> partitioning,
                                       const SampledVolumes& recorded, bool gradient) {
  const SampleList& list = samples.list;
  std::vector<uint32_t> order;
  std::vector<SampleKey> keys;
  agree(run.ranks, [&] {
    order = sampleOrderOf(list);
    keys.reserve(order.size());
    for (const uint32_t i : order) keys.push_back(sampleKeyOf(list, i));
  });
  const std::vector<uint64_t> places = placesAmong(keys, run.ranks);
  const auto kept = size_t(std::lower_bound(places.begin(), places.end(), most) - places.begin());
  GeometryBlock block;
  LedgerEntry memory;
  agree(run.ranks, [&] {
    const size_t floats = recorded.sampled.size() + (gradient ? 3 : 0);
    memory = run.takeMemory("geometry",
                            int64_t(kept * (sizeof(glm::dvec3) + sizeof(uint64_t) + floats * sizeof(float))));
    block.points.reserve(kept);
    block.ids.assign(places.begin(), places.begin() + std::ptrdiff_t(kept));
    for (size_t k = 0; k < kept; k++) block.points.push_back(list.position[order[k]]);
    takeSampledFields(list, std::span(order).first(kept), recorded, gradient, block);
  });
  return madeGeometry(run, name, GeometryKind::Particles, std::move(block), std::move(partitioning),
                      std::move(memory), recorded.array);
}

}  // namespace gxy
