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

}  // namespace

std::shared_ptr<Dataset> sampledPoints(FilterRun& run, const std::string& name, TakenSamples samples,
                                       uint64_t most, std::shared_ptr<const Partitioning> partitioning) {
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
    const bool valued = !list.values.empty();
    memory = run.takeMemory("geometry",
                            int64_t(kept * (sizeof(glm::dvec3) + sizeof(uint64_t) + (valued ? 4 : 0))));
    block.points.reserve(kept);
    block.ids.assign(places.begin(), places.begin() + std::ptrdiff_t(kept));
    for (size_t k = 0; k < kept; k++) block.points.push_back(list.position[order[k]]);
    if (valued)
      for (size_t k = 0; k < kept; k++) block.values.push_back(list.values[0][order[k]]);
  });
  return madeGeometry(run, name, GeometryKind::Particles, std::move(block), std::move(partitioning),
                      std::move(memory));
}

}  // namespace gxy
