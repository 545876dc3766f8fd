// SPDX-License-Identifier: Apache-2.0
#include "core/data/mesh_values.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/wire.h"

namespace gxy {

namespace {

bool isNoData(const float* values, size_t components) {
  return std::any_of(values, values + components, [](float v) { return !std::isfinite(v); });
}

/// Whether two points have the same values; NaN is NaN.
bool areSame(const float* a, const float* b, size_t components) {
  for (size_t c = 0; c < components; c++)
    if (a[c] != b[c] && !(std::isnan(a[c]) && std::isnan(b[c]))) return false;
  return true;
}

std::vector<Bytes> packValues(const ValueRoutes& routes, std::span<const float> values, size_t components) {
  std::vector<Bytes> messages;
  std::vector<float> some;
  for (const std::vector<ValueRoutes::Sent>& toRank : routes.sent) {
    Writer writer;
    for (const auto& [partition, points] : toRank) {
      some.clear();
      for (const uint32_t point : points) {
        const auto of = values.subspan(point * components, components);
        some.insert(some.end(), of.begin(), of.end());
      }
      writer.write(int32_t(partition)).write(some);
    }
    messages.push_back(writer.take());
  }
  return messages;
}

/// The values of the piece of each partition, as they come from all ranks.
std::map<int, std::vector<float>> unpackValues(const ValueRoutes& routes, std::span<const Bytes> received,
                                               size_t components) {
  std::map<int, std::vector<float>> values;
  for (const Bytes& message : received) {
    Reader reader(message, "values of a mesh");
    while (!reader.rest().empty()) {
      const auto partition = reader.read<int32_t>();
      const auto some = reader.readVector<float>();
      if (routes.taken.count(partition) == 0)
        reader.fail("partition " + std::to_string(partition) + " came, expected one with cells of this rank");
      std::vector<float>& all = values[partition];
      all.insert(all.end(), some.begin(), some.end());
    }
  }
  for (const auto& [partition, sources] : routes.taken)
    if (values[partition].size() != sources.pointsOfPiece * components)
      throw Error("values of a mesh: " + std::to_string(values[partition].size()) + " came for partition " +
                  std::to_string(partition) + ", expected " + std::to_string(components) + " for each of " +
                  std::to_string(sources.pointsOfPiece) + " points");
  return values;
}

}  // namespace

std::vector<float> valuesOfBlock(const PointSources& sources, std::span<const float> values, int components,
                                 int partition, MeshBlockCounts& counts) {
  const auto n = size_t(components);
  std::vector<float> made;
  made.reserve(sources.isHere.size() * n);
  std::vector<uint32_t> differing;
  for (const auto& [from, to, merged] : sources.sources) {
    const float* of = values.data() + from * n;
    if (made.size() == to * n) {
      made.insert(made.end(), of, of + n);
      counts.noDataPoints += sources.isHere[to] && isNoData(of, n);
    } else if (merged && !areSame(of, made.data() + to * n, n)) {
      counts.differingPoints++;
      if (differing.empty() || differing.back() != to) differing.push_back(to);
    }
  }
  if (!differing.empty()) counts.differing[partition] = std::move(differing);
  return made;
}

int64_t bytesOf(const ValueRoutes& routes) {
  size_t bytes = 0;
  for (const auto& toRank : routes.sent)
    for (const ValueRoutes::Sent& sent : toRank) bytes += sent.points.size() * sizeof(uint32_t);
  for (const auto& [partition, sources] : routes.taken)
    bytes += sources.sources.size() * sizeof(PointSources::Source) + sources.isHere.size();
  return int64_t(bytes);
}

std::map<int, MeshBlock> distributeValues(const std::map<int, MeshBlock>& blocks, const ValueRoutes& routes,
                                          std::span<const float> values, int components,
                                          const Partitioning& partitioning, MeshBlockCounts& counts,
                                          Collectives& ranks, const std::function<void(int64_t)>& toTake) {
  std::vector<Bytes> messages;
  agree(ranks, [&] {
    if (toTake) toTake(int64_t(values.size_bytes()));
    messages = packValues(routes, values, size_t(components));
  });
  std::vector<Bytes> received = ranks.allToAll(std::move(messages));
  std::map<int, MeshBlock> made;
  counts.differingPoints = counts.noDataPoints = 0;
  counts.differing.clear();
  agree(ranks, [&] {
    int64_t bytes = 0;
    for (const Bytes& message : received) bytes += int64_t(message.size());
    if (toTake) toTake(2 * bytes);
    const std::map<int, std::vector<float>> ofPieces = unpackValues(routes, received, size_t(components));
    for (const auto& [partition, block] : blocks) {
      MeshBlock other{block.points, {}, block.cells, block.neighbours, block.shell};
      other.values =
          valuesOfBlock(routes.taken.at(partition), ofPieces.at(partition), components, partition, counts);
      made.emplace(partition, std::move(other));
    }
  });
  uint64_t* const sums[] = {&counts.differingPoints, &counts.noDataPoints};
  settle(made, partitioning, counts, sums, ranks);
  return made;
}

}  // namespace gxy
