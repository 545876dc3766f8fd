// SPDX-License-Identifier: Apache-2.0
#include "core/data/mesh_values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/wire.h"
#include "core/data/point_averages.h"

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

/// Whether values come before others: NaN is behind all numbers.
bool isLower(const float* a, const float* b, size_t components) {
  for (size_t c = 0; c < components; c++)
    if (a[c] != b[c] && !(std::isnan(a[c]) && std::isnan(b[c]))) return std::isnan(b[c]) || a[c] < b[c];
  return false;
}

/// The value that is kept of cells with the same points.
struct KeptValue {
  const float* values = nullptr;
  uint64_t cells = 0;  ///< that are no duplicates
  bool differ = false;
};

KeptValue keptOf(std::span<const CellSources::Source> same, std::span<const float> values,
                 size_t components) {
  const auto valuesOf = [&](const CellSources::Source& source) {
    return values.data() + source.from * components;
  };
  KeptValue kept;
  for (const CellSources::Source& source : same) {
    const float* const own = valuesOf(source);
    const bool isFirst = !kept.values || (!source.isDuplicate && kept.cells == 0);
    const bool competes = source.isDuplicate == (kept.cells == 0);
    if (isFirst || (competes && isLower(own, kept.values, components))) kept.values = own;
    kept.cells += !source.isDuplicate;
  }
  kept.differ = kept.cells > 1 && std::any_of(same.begin(), same.end(), [&](const auto& source) {
                  return !source.isDuplicate && !areSame(valuesOf(source), kept.values, components);
                });
  return kept;
}

std::vector<float> averagesOf(const MeshBlock& block, const CellSources& sources,
                              std::span<const float> served, int components, const Advance& advance) {
  if (!sources.served)
    return averagesAtPoints({block.points.data(), block.points.size()}, block.cells.view(), block.cellValues,
                            components, advance);
  const std::vector<float> all =
      averagesAtPoints(sources.served->points, sources.served->cells.view(), served, components, advance);
  const auto n = size_t(components);
  std::vector<float> kept;
  kept.reserve(sources.served->keptPoints.size() * n);
  for (const uint32_t point : sources.served->keptPoints)
    kept.insert(kept.end(), all.begin() + std::ptrdiff_t(point * n),
                all.begin() + std::ptrdiff_t((point + 1) * n));
  return kept;
}

/// One array of values of points, or one for each type of cells.
constexpr size_t arraysOf(bool ofCells) { return ofCells ? kCellTypes : 1; }

std::vector<Bytes> packValues(const ValueRoutes& routes, std::span<const float> values, size_t components,
                              bool ofCells) {
  std::vector<Bytes> messages;
  std::vector<float> some;
  for (const std::vector<ValueRoutes::Sent>& toRank : routes.sent) {
    Writer writer;
    for (const ValueRoutes::Sent& sent : toRank) {
      writer.write(int32_t(sent.partition));
      for (size_t array = 0; array < arraysOf(ofCells); array++) {
        some.clear();
        for (const uint32_t entry : ofCells ? sent.cells[array] : sent.points) {
          const auto of = values.subspan(entry * components, components);
          some.insert(some.end(), of.begin(), of.end());
        }
        writer.write(some);
      }
    }
    messages.push_back(writer.take());
  }
  return messages;
}

/// The values of the piece of each partition, as they come from all ranks.
std::map<int, std::vector<float>> unpackValues(const ValueRoutes& routes, std::span<const Bytes> received,
                                               size_t components, bool ofCells) {
  std::map<int, std::array<std::vector<float>, kCellTypes>> arrays;
  for (const Bytes& message : received) {
    Reader reader(message, "values of a mesh");
    while (!reader.rest().empty()) {
      const auto partition = reader.read<int32_t>();
      if (routes.taken.count(partition) == 0)
        reader.fail("partition " + std::to_string(partition) + " came, expected one with cells of this rank");
      for (size_t array = 0; array < arraysOf(ofCells); array++) {
        const auto some = reader.readVector<float>();
        std::vector<float>& all = arrays[partition][array];
        all.insert(all.end(), some.begin(), some.end());
      }
    }
  }
  std::map<int, std::vector<float>> values;
  for (const auto& [partition, sources] : routes.taken) {
    std::vector<float>& all = values[partition];
    for (std::vector<float>& array : arrays[partition]) {
      if (all.empty())
        all = std::move(array);
      else
        all.insert(all.end(), array.begin(), array.end());
    }
    const uint64_t expected =
        !ofCells ? sources.points.pointsOfPiece : (sources.cells ? sources.cells->cellsOfPiece : 0);
    if (all.size() != expected * components)
      throw Error("values of a mesh: " + std::to_string(all.size()) + " came for partition " +
                  std::to_string(partition) + ", expected " + std::to_string(components) + " for each of " +
                  std::to_string(expected) + (ofCells ? " cells" : " points"));
  }
  return values;
}

}  // namespace

void giveCellValues(MeshBlock& block, const BlockSources& sources, std::span<const float> values,
                    int components, const Partitioning& partitioning, int partition, MeshBlockCounts& counts,
                    const Advance& advance) {
  const CellSources& cells = *sources.cells;
  const std::vector<uint8_t>& isHere = sources.points.isHere;
  const auto n = size_t(components);
  std::vector<float> served;
  uint32_t cell = 0;  // of the block
  const auto isCellHere = [&] {
    const auto points = block.cells.pointsOf(cell);
    return isHere[*std::min_element(points.begin(), points.end())] != 0;
  };
  block.cellValues.reserve(block.cells.size() * n);
  for (auto from = cells.sources.begin(); from != cells.sources.end();) {
    const auto end =
        std::find_if(from, cells.sources.end(), [&](const auto& source) { return source.to != from->to; });
    const KeptValue kept = keptOf({from, end}, values, n);
    from = end;
    if (cells.served) served.insert(served.end(), kept.values, kept.values + n);
    if (kept.cells == 0) continue;
    const bool lacksData = isNoData(kept.values, n);
    counts.differingCells += kept.differ && isCellHere();
    counts.noDataCells += lacksData && isCellHere();
    if (lacksData)
      block.cellValues.insert(block.cellValues.end(), n, std::numeric_limits<float>::quiet_NaN());
    else
      block.cellValues.insert(block.cellValues.end(), kept.values, kept.values + n);
    cell++;
  }
  block.values = averagesOf(block, cells, served, components, advance);
  std::vector<uint32_t> here;
  for (uint32_t p = 0; p < isHere.size() && partitioning.partitions() > 1; p++)
    if (isHere[p]) here.push_back(p);
  if (!here.empty()) counts.differing[partition] = std::move(here);
}

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
    for (const ValueRoutes::Sent& sent : toRank) {
      bytes += sent.points.size() * sizeof(uint32_t);
      for (const auto& cells : sent.cells) bytes += cells.size() * sizeof(uint32_t);
    }
  for (const auto& [partition, sources] : routes.taken) {
    bytes += sources.points.sources.size() * sizeof(PointSources::Source) + sources.points.isHere.size();
    if (!sources.cells) continue;
    bytes += sources.cells->sources.size() * sizeof(CellSources::Source);
    if (!sources.cells->served) continue;
    const CellSources::Served& served = *sources.cells->served;
    bytes += served.points.size() * sizeof(glm::dvec3) + served.keptPoints.size() * sizeof(uint32_t);
    for (const auto& cells : served.cells.points) bytes += cells.size() * sizeof(uint32_t);
  }
  return int64_t(bytes);
}

std::map<int, MeshBlock> distributeValues(const std::map<int, MeshBlock>& blocks, const ValueRoutes& routes,
                                          std::span<const float> values, int components, bool ofCells,
                                          const Partitioning& partitioning, MeshBlockCounts& counts,
                                          Collectives& ranks, const std::function<void(int64_t)>& toTake) {
  std::vector<Bytes> messages;
  agree(ranks, [&] {
    if (toTake) toTake(int64_t(values.size_bytes()));
    messages = packValues(routes, values, size_t(components), ofCells);
  });
  std::vector<Bytes> received = ranks.allToAll(std::move(messages));
  std::map<int, MeshBlock> made;
  counts.differingPoints = counts.noDataPoints = counts.differingCells = counts.noDataCells = 0;
  counts.differing.clear();
  agree(ranks, [&] {
    int64_t bytes = 0;
    for (const Bytes& message : received) bytes += int64_t(message.size());
    if (toTake) toTake(2 * bytes);
    const std::map<int, std::vector<float>> ofPieces =
        unpackValues(routes, received, size_t(components), ofCells);
    for (const auto& [partition, block] : blocks) {
      MeshBlock other{block.points, {}, block.cells, block.neighbours, block.shell};
      const BlockSources& sources = routes.taken.at(partition);
      const std::vector<float>& ofPiece = ofPieces.at(partition);
      if (ofCells)
        giveCellValues(other, sources, ofPiece, components, partitioning, partition, counts,
                       [&](double) { ranks.check(); });
      else
        other.values = valuesOfBlock(sources.points, ofPiece, components, partition, counts);
      made.emplace(partition, std::move(other));
    }
  });
  uint64_t* const sums[] = {&counts.differingPoints, &counts.noDataPoints, &counts.differingCells,
                            &counts.noDataCells};
  settle(made, partitioning, counts, sums, ranks, ofCells);
  return made;
}

}  // namespace gxy
