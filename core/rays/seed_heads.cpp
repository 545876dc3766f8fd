// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <string>

#include "core/comm/error.h"
#include "core/rays/device_fields.h"

namespace gxy {

LineEnd outsideEnd(uint64_t line, bool backward, glm::dvec3 position) {
  LineEnd end;
  end.line = line;
  end.backward = backward;
  end.reason = EndReason::Outside;
  end.position = position;
  return end;
}

SeedHeads makeSeedHeads(std::span<const glm::dvec3> positions, std::span<const uint64_t> ids,
                        TraceDirection direction, HeadKind kind,
                        const std::function<int(size_t i)>& partitionOf,
                        const std::function<void(HeadList& heads, int k, size_t i, bool backward)>& start) {
  if (positions.size() != ids.size())
    throw Error("seeds: " + std::to_string(positions.size()) + " positions have " +
                std::to_string(ids.size()) + " numbers of lines; expected as many");
  if (positions.size() > size_t(1) << 29)
    throw Error("seeds: " + std::to_string(positions.size()) + " at once; expected at most 2^29");
  std::map<int, std::vector<size_t>> byPartition;
  SeedHeads seeds;
  for (size_t i = 0; i < positions.size(); i++) {
    if (ids[i] > kLastLine)
      throw Error("seeds: a line has the number " + std::to_string(ids[i]) + "; expected at most 2^40 - 1");
    if (const int partition = partitionOf(i); partition >= 0) {
      byPartition[partition].push_back(i);
      continue;
    }
    if (direction != TraceDirection::Backward) seeds.ends.push_back(outsideEnd(ids[i], false, positions[i]));
    if (direction != TraceDirection::Forward) seeds.ends.push_back(outsideEnd(ids[i], true, positions[i]));
  }
  const bool both = direction == TraceDirection::Both;
  for (const auto& [partition, list] : byPartition) {
    HeadList& heads = seeds.heads.emplace_back(partition, int(list.size()) * (both ? 2 : 1), kind);
    int k = 0;
    for (const size_t i : list) {
      if (direction != TraceDirection::Backward) start(heads, k++, i, false);
      if (direction == TraceDirection::Forward) continue;
      start(heads, k, i, true);
      heads.view().points[k++] = both ? 1 : 0;
    }
  }
  return seeds;
}

SeedHeads CompiledFields::seeds(std::span<const glm::dvec3> positions, std::span<const uint64_t> ids,
                                TraceDirection direction) const {
  std::vector<Place> places(positions.size());
  return makeSeedHeads(
      positions, ids, direction, kGridHeads,
      [&](size_t i) { return locate(positions[i], places[i]) ? partitionOf(places[i].cell) : -1; },
      [&](HeadList& heads, int k, size_t i, bool backward) {
        heads.start(k, ids[i], backward, places[i].cell, places[i].fraction);
      });
}

const char* CompiledFields::wrongHeads(const HeadList& heads) const {
  const Extent* extent = extentOf(heads.partition);
  return extent ? wrongIn(heads, *extent) : "the partition has no field";
}

}  // namespace gxy
