// SPDX-License-Identifier: Apache-2.0
// Lines do not depend on how the domain is cut, nor on packets.
#include <gtest/gtest.h>

#include "tests/kernels/random.h"
#include "tests/lines/flow_fields.h"
#include "tests/lines/same_lines.h"
#include "tests/support/partitionings.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

struct Cutting {
  std::shared_ptr<const CompiledFields> fields;
  std::unique_ptr<DeviceFields> device;
};

Cutting cutInto(const Grid& grid, const Partitioning& partitioning, const FlowFunction& flow) {
  // All partitions are this rank's.
  std::vector<Box> boxes;
  for (int p = 0; p < partitioning.partitions(); p++) boxes.push_back(partitioning.box(p));
  const auto cut = std::make_shared<const Partitioning>(
      Partitioning::fromBoxes(boxes, std::vector<int32_t>(boxes.size(), 0)));
  const auto scalar =
      volumeOf(grid, *cut, 1, [](glm::dvec3 p) { return std::vector<double>{p.x * p.y + p.z}; });
  Cutting c;
  c.fields = std::make_shared<const CompiledFields>(
      std::vector{volumeOf(grid, *cut, 3, vectorsOf(flow)), scalar}, cut);
  c.device = makePlainFields(c.fields, 0);
  return c;
}

void expectSameOnAllCuts(const Grid& grid, const FlowFunction& flow, const std::vector<glm::dvec3>& seeds,
                         const TraceOptions& options, bool hops = true) {
  const Box box = grid.box();
  const Cutting one = cutInto(grid, Partitioning::single(box), flow);
  const Lines expected = trace(*one.device, *one.fields, seeds, options, TraceDirection::Both);
  EXPECT_EQ(expected.count(EndReason::Stuck), 0u);
  std::vector<Cut> cuts = manyCuts(box, 11);
  cuts.push_back(lattice(box, {7, 1, 1}, 1));
  cuts.push_back(lattice(box, {4, 4, 4}, 1));
  cuts.push_back(kdCut(box, 64, 1, 3));
  cuts.push_back(octants(box, (box.lo + box.hi) / 2.0 + grid.spacing * 0.3, 1));
  uint64_t handed = 0;
  for (const Cut& cut : cuts) {
    const Cutting c = cutInto(grid, cut.partitioning, flow);
    const int packet = cut.partitioning.partitions() % 2 ? 4096 : 5;
    const Lines lines = trace(*c.device, *c.fields, seeds, options, TraceDirection::Both, packet);
    expectSameLines(lines, expected, cut.name);
    handed += lines.hops;
  }
  EXPECT_EQ(handed > seeds.size(), hops);
}

std::vector<glm::dvec3> seedsIn(const Box& box, const Grid& grid, int n, uint64_t seed) {
  Random random(seed);
  std::vector<glm::dvec3> seeds;
  for (int i = 0; i < n; i++) {
    glm::dvec3 p = box.lo + (box.hi - box.lo) * random.point(0, 1);
    // Some are on faces, edges and nodes.
    for (int a = 0; a < 3; a++)
      if (i % 8 & (1 << a))
        p[a] = grid.origin[a] + grid.spacing[a] * random.below(int(grid.points[size_t(a)]));
    seeds.push_back(p);
  }
  return seeds;
}

TEST(LinesOnCuts, HaveTheSameBitsHoweverTheDomainIsCut) {
  const Grid grid = gridOver({0, 0, 0}, {6, 5, 7}, {25, 22, 30});
  const FlowFunction flow = [](glm::dvec3 p) { return abcFlow(1.7 * p); };
  const std::vector<glm::dvec3> seeds = seedsIn(grid.box(), grid, sweep(200), 1);
  expectSameOnAllCuts(grid, flow, seeds, {});
  expectSameOnAllCuts(grid, flow, seeds, {.time = 3, .points = PointsMode::EqualTime, .interval = 0.017});
  expectSameOnAllCuts(grid, flow, seeds, {.length = 9, .points = PointsMode::EqualLength, .interval = 0.05});
  expectSameOnAllCuts(
      grid, flow, seeds,
      {.tolerance = 1e-2, .points = PointsMode::Ends, .condition = TraceCondition{0, 30, 40}});
}

// The ghosts of each partition are the whole grid.
TEST(LinesOnCuts, OfOneCellHaveTheSameBits) {
  const Grid grid = gridOver({0, 0, 0}, {4, 4, 4}, {5, 5, 5});
  const FlowFunction flow = [](glm::dvec3 p) { return abcFlow(p); };
  expectSameOnAllCuts(grid, flow, seedsIn(grid.box(), grid, 60, 2), {}, false);
}

// A line that winds about the border between two partitions is not handed over at each crossing: the ghosts hold it.
TEST(LinesOnCuts, ALineThatWindsAboutABorderStaysInOnePartition) {
  const Grid grid = gridOver({-8, -8, -1}, {8, 8, 1}, {17, 17, 3});
  const FlowFunction flow = [](glm::dvec3 p) { return glm::dvec3(-p.y, p.x, 0); };
  const Cutting c = cutInto(grid, lattice(grid.box(), {2, 1, 1}, 1).partitioning, flow);
  const Lines lines = trace(*c.device, *c.fields, {{2, 0.3, 0}}, {.time = 1000, .length = 1e9});
  EXPECT_EQ(lines.hops, 0u);
  EXPECT_GT(lines.counters.cells, 1000u);
}

}  // namespace
}  // namespace gxy::test
