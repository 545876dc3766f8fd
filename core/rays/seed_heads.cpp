// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <string>

#include "core/comm/error.h"
#include "core/rays/device_fields.h"

namespace gxy {

namespace {

struct Seed {
  CompiledFields::Place place;
  uint64_t line;
};

LineEnd outside(uint64_t line, bool backward, glm::dvec3 position) {
  LineEnd end;
  end.line = line;
  end.backward = backward;
  end.reason = EndReason::Outside;
  end.position = position;
  return end;
}

HeadList headsOf(int partition, const std::vector<Seed>& seeds, TraceDirection direction) {
  const bool both = direction == TraceDirection::Both;
  HeadList list(partition, int(seeds.size()) * (both ? 2 : 1));
  int i = 0;
  for (const Seed& seed : seeds) {
    if (direction != TraceDirection::Backward)
      list.start(i++, seed.line, false, seed.place.cell, seed.place.fraction);
    if (direction == TraceDirection::Forward) continue;
    list.start(i, seed.line, true, seed.place.cell, seed.place.fraction);
    list.view().points[i++] = both ? 1 : 0;
  }
  return list;
}

}  // namespace

SeedHeads seedHeads(const CompiledFields& fields, std::span<const glm::dvec3> positions,
                    std::span<const uint64_t> ids, TraceDirection direction) {
  if (positions.size() != ids.size())
    throw Error("seeds: " + std::to_string(positions.size()) + " positions have " +
                std::to_string(ids.size()) + " numbers of lines; expected as many");
  if (positions.size() > size_t(1) << 29)
    throw Error("seeds: " + std::to_string(positions.size()) + " at once; expected at most 2^29");
  std::map<int, std::vector<Seed>> byPartition;
  SeedHeads seeds;
  for (size_t i = 0; i < positions.size(); i++) {
    if (ids[i] > kLastLine)
      throw Error("seeds: a line has the number " + std::to_string(ids[i]) + "; expected at most 2^40 - 1");
    Seed seed{{}, ids[i]};
    if (fields.locate(positions[i], seed.place)) {
      byPartition[fields.partitionOf(seed.place.cell)].push_back(seed);
      continue;
    }
    if (direction != TraceDirection::Backward) seeds.ends.push_back(outside(ids[i], false, positions[i]));
    if (direction != TraceDirection::Forward) seeds.ends.push_back(outside(ids[i], true, positions[i]));
  }
  for (const auto& [partition, list] : byPartition)
    seeds.heads.push_back(headsOf(partition, list, direction));
  return seeds;
}

}  // namespace gxy
