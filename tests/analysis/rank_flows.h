// SPDX-License-Identifier: Apache-2.0
// A flow cut over ranks, as each of them has it, and the same flow in one piece.
#pragma once
#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "core/analysis/lines.h"
#include "core/analysis/tracer.h"
#include "tests/lines/flow_fields.h"
#include "tests/support/partitionings.h"

namespace gxy::test {

/// What one rank has of a flow.
struct RankFlow {
  std::shared_ptr<const LineFields> fields;
  std::shared_ptr<const DeviceFields> device;
};

/// The flow, and a scalar x * y + z beside it, which is recorded.
inline std::vector<RankFlow> flowOnRanks(const Grid& grid, const FlowFunction& flow, const Cut& cut) {
  const auto partitioning = std::make_shared<const Partitioning>(cut.partitioning);
  const auto vectors = volumeOf(grid, cut.partitioning, 3, vectorsOf(flow));
  const auto scalar =
      volumeOf(grid, cut.partitioning, 1, [](glm::dvec3 p) { return std::vector<double>{p.x * p.y + p.z}; });
  std::vector<RankFlow> ranks;
  for (int r = 0; r < cut.ranks; r++) {
    std::vector<std::shared_ptr<const Volume>> volumes;
    for (const auto& whole : {vectors, scalar}) {
      const auto mine = std::make_shared<Volume>(*whole);
      std::erase_if(mine->blocks, [&](const auto& b) { return cut.partitioning.owner(b.first) != r; });
      volumes.push_back(mine);
    }
    RankFlow& rank = ranks.emplace_back();
    const auto fields = std::make_shared<const CompiledFields>(std::move(volumes), partitioning);
    rank.fields = fields;
    rank.device = makePlainFields(fields, r);
  }
  return ranks;
}

/// A request of rank `r`: of all seeds, the rank has every so many-th, wherever they are.
inline TraceRequest requestOf(const RankFlow& flow, int r, int ranks, const std::vector<glm::dvec3>& seeds,
                              const TraceOptions& options, TraceDirection direction) {
  TraceRequest request;
  request.fields = flow.fields;
  request.device = flow.device;
  request.direction = direction;
  request.options = options;
  for (size_t i = size_t(r); i < seeds.size(); i += size_t(ranks)) {
    request.seeds.push_back(seeds[i]);
    request.lines.push_back(i);
  }
  return request;
}

/// What all ranks have stored, in order of the keys.
inline Lines joined(std::vector<TracedLines> ranks) {
  Lines lines;
  for (TracedLines& rank : ranks) {
    for (PathPoints& piece : rank.points) lines.points.append(std::move(piece));
    lines.ends.insert(lines.ends.end(), rank.ends.begin(), rank.ends.end());
    lines.counters += rank.counters;
  }
  lines.points.sort();
  std::sort(lines.ends.begin(), lines.ends.end(), [](const LineEnd& a, const LineEnd& b) {
    return std::pair(a.line, a.backward) < std::pair(b.line, b.backward);
  });
  return lines;
}

template <class T>
std::string bytesIn(const std::vector<T>& list) {
  return {reinterpret_cast<const char*>(list.data()), list.size() * sizeof(T)};
}

/// All bits of path lines.
inline std::string bytesIn(const GeometryBlock& b) {
  return bytesIn(b.points) + bytesIn(b.values) + bytesIn(b.segments) + bytesIn(b.neighbours) + bytesIn(b.ids);
}

}  // namespace gxy::test
