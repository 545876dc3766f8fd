// SPDX-License-Identifier: Apache-2.0
// Small vector fields for tests of lines, and lines traced through them on one rank.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "core/data/bricks.h"
#include "core/data/volume.h"
#include "core/rays/device_fields.h"
#include "core/rays/flow_views.h"

namespace gxy::test {

/// Values of a field's components at a world point.
using FieldFunction = std::function<std::vector<double>(glm::dvec3)>;
using FlowFunction = std::function<glm::dvec3(glm::dvec3)>;

/// A grid of n points per axis over [lo, hi].
inline Grid gridOver(glm::dvec3 lo, glm::dvec3 hi, Index3 n) {
  return {lo, (hi - lo) / glm::dvec3(n[0] - 1, n[1] - 1, n[2] - 1), n};
}

template <class T>
void fillBlock(VolumeBlock& block, const Grid& grid, int components, const FieldFunction& f) {
  const Extent& e = block.extent;
  block.samples.resize(size_t(e.count()) * size_t(components) * sizeof(T));
  std::byte* out = block.samples.data();
  for (int64_t k = 0; k < e.points[2]; k++)
    for (int64_t j = 0; j < e.points[1]; j++)
      for (int64_t i = 0; i < e.points[0]; i++)
        for (double x :
             f(grid.origin + grid.spacing * glm::dvec3(e.first[0] + i, e.first[1] + j, e.first[2] + k))) {
          const T t = T(x);
          std::memcpy(out, &t, sizeof t);
          out += sizeof t;
        }
  putIntoBricks(block.samples, e.points, size_t(components) * sizeof(T));
}

/// A volume with blocks for all partitions, as one rank that owns them all has it.
inline std::shared_ptr<const Volume> volumeOf(const Grid& grid, const Partitioning& cut, int components,
                                              const FieldFunction& f,
                                              ScalarType stored = ScalarType::Float32) {
  auto volume = std::make_shared<Volume>();
  volume->name = "field";
  volume->grid = grid;
  volume->stored = stored;
  volume->components = components;
  volume->ranges.resize(components > 1 ? size_t(components) + 1 : 1);
  for (int64_t k = 0; k < grid.points[2]; k++)
    for (int64_t j = 0; j < grid.points[1]; j++)
      for (int64_t i = 0; i < grid.points[0]; i++) {
        const std::vector<double> x = f(grid.origin + grid.spacing * glm::dvec3(i, j, k));
        for (size_t c = 0; c < x.size(); c++) volume->ranges[c].extend(x[c]);
      }
  for (int p = 0; p < cut.partitions(); p++) {
    const Extent extent = extentOf(grid, cut.box(p), kGhostLayers);
    if (extent.count() == 0) continue;
    VolumeBlock& block = volume->blocks[p];
    block.extent = extent;
    if (stored == ScalarType::Float32) fillBlock<float>(block, grid, components, f);
    if (stored == ScalarType::UInt8) fillBlock<uint8_t>(block, grid, components, f);
    if (stored == ScalarType::Int8) fillBlock<int8_t>(block, grid, components, f);
    if (stored == ScalarType::UInt16) fillBlock<uint16_t>(block, grid, components, f);
    if (stored == ScalarType::Int16) fillBlock<int16_t>(block, grid, components, f);
  }
  return volume;
}

inline FieldFunction vectorsOf(const FlowFunction& f) {
  return [f](glm::dvec3 p) {
    const glm::dvec3 v = f(p);
    return std::vector<double>{v.x, v.y, v.z};
  };
}

/// What became of lines, in order of their keys.
struct Lines {
  PathPoints points;
  std::vector<LineEnd> ends;
  AdvanceCounters counters;
  uint64_t hops = 0;  ///< heads that were handed on to another partition

  const LineEnd& end(uint64_t line, bool backward = false) const {
    for (const LineEnd& e : ends)
      if (e.line == line && e.backward == backward) return e;
    static const LineEnd none;
    return none;
  }
  size_t count(EndReason reason) const {
    size_t n = 0;
    for (const LineEnd& e : ends) n += e.reason == reason;
    return n;
  }
};

/// Lines of seeds, numbered from 0, through fields whose partitions are all here. Heads travel in packets of at
/// most `packet`, as messages do.
inline Lines trace(const DeviceFields& device, const LineFields& fields, const std::vector<glm::dvec3>& seeds,
                   const TraceOptions& options, TraceDirection direction = TraceDirection::Forward,
                   int packet = 4096) {
  checkOptions(options, fields);
  std::vector<uint64_t> ids(seeds.size());
  for (size_t i = 0; i < ids.size(); i++) ids[i] = i;
  SeedHeads start = fields.seeds(seeds, ids, direction);
  Lines lines;
  lines.ends = std::move(start.ends);
  std::vector<HeadList> waiting;
  for (HeadList& list : start.heads)
    for (HeadList& part : list.split(packet)) waiting.push_back(std::move(part));
  while (!waiting.empty()) {
    HeadList list = std::move(waiting.back());
    waiting.pop_back();
    const int from = list.partition;
    device.advance(from, std::move(list), options, [&](AdvanceResult r) {
      lines.counters += r.counters;
      lines.points.append(std::move(r.points));
      lines.ends.insert(lines.ends.end(), r.ends.begin(), r.ends.end());
      for (HeadList& left : r.leaving)
        for (HeadList& part : left.split(packet)) {
          lines.hops += part.partition != from ? uint64_t(part.size()) : 0;
          waiting.push_back(std::move(part));
        }
    });
  }
  lines.points.sort();
  std::sort(lines.ends.begin(), lines.ends.end(), [](const LineEnd& a, const LineEnd& b) {
    return std::pair(a.line, a.backward) < std::pair(b.line, b.backward);
  });
  return lines;
}

/// A flow in one piece, and lines through it in plain C++.
class Flow {
 public:
  Flow(const Grid& grid, const FlowFunction& f, ScalarType stored = ScalarType::Float32)
      : cut(Partitioning::single(grid.box())),
        volume(volumeOf(grid, cut, 3, vectorsOf(f), stored)),
        fields(
            std::make_shared<const CompiledFields>(std::vector{volume}, std::make_shared<Partitioning>(cut))),
        device(makePlainFields(fields, 0)) {}

  Lines trace(const std::vector<glm::dvec3>& seeds, const TraceOptions& options = {},
              TraceDirection direction = TraceDirection::Forward) const {
    return test::trace(*device, *fields, seeds, options, direction);
  }

  const Partitioning cut;
  const std::shared_ptr<const Volume> volume;
  const std::shared_ptr<const CompiledFields> fields;
  const std::unique_ptr<DeviceFields> device;
};

/// The flow of Arnold, Beltrami and Childress: curl v = v.
inline glm::dvec3 abcFlow(glm::dvec3 p) {
  return {std::sin(p.z) + std::cos(p.y), std::sin(p.x) + std::cos(p.z), std::sin(p.y) + std::cos(p.x)};
}

}  // namespace gxy::test
