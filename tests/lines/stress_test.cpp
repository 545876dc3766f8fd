// SPDX-License-Identifier: Apache-2.0
// Every line ends, for a reason that can be told, on whatever field and grid.
#include <gtest/gtest.h>

#include "tests/lines/stress_flows.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

void expectSound(const StressFlow& stress, const Lines& lines, const std::vector<glm::dvec3>& seeds) {
  ASSERT_EQ(lines.ends.size(), 2 * seeds.size()) << stress.name;
  EXPECT_EQ(lines.count(EndReason::Stuck), 0u) << stress.name;
  EXPECT_EQ(lines.count(EndReason::Closed), 0u) << stress.name;
  EXPECT_EQ(lines.count(EndReason::Outside), 0u) << stress.name;
  const Box box = stress.grid.box();
  const PathPoints& p = lines.points;
  for (size_t i = 0; i < p.size(); i++) {
    for (int a = 0; a < 3; a++) {
      const double slack = 1e-9 * stress.grid.spacing[a];
      ASSERT_GE(p.position[i][a], box.lo[a] - slack) << stress.name;
      ASSERT_LE(p.position[i][a], box.hi[a] + slack) << stress.name;
    }
    if (i + 1 == p.size() || p.line[i + 1] != p.line[i]) continue;
    ASSERT_EQ(p.number[i + 1], p.number[i] + 1) << stress.name;
    ASSERT_LE(p.time[i], p.time[i + 1]) << stress.name;
    ASSERT_LE(p.length[i], p.length[i + 1]) << stress.name;
  }
}

TEST(LinesUnderStress, EndForAReasonAndTheirPointsAreInOrderOfTime) {
  for (const StressFlow& stress : stressFlows()) {
    const Flow flow(stress.grid, stress.flow);
    const std::vector<glm::dvec3> seeds = stressSeeds(stress.grid, sweep(160), 1);
    const double length = stress.length * stress.grid.spacing.x;
    expectSound(stress, flow.trace(seeds, {.length = length}, TraceDirection::Both), seeds);
  }
}

TEST(LinesUnderStress, CoincidentSeedsMakeTheSameLine) {
  const Flow flow(gridOver(glm::dvec3(-1), glm::dvec3(1), {9, 9, 9}),
                  [](glm::dvec3 p) { return abcFlow(3.0 * p); });
  const std::vector<glm::dvec3> seeds(size_t(sweep(50000)), glm::dvec3(0.25, -0.5, 0));
  const Lines lines = flow.trace(seeds, {.steps = 2, .points = PointsMode::Ends});
  ASSERT_EQ(lines.ends.size(), seeds.size());
  for (const LineEnd& e : lines.ends) {
    ASSERT_EQ(e.position, lines.ends[0].position);
    ASSERT_EQ(e.time, lines.ends[0].time);
  }
}

TEST(LinesUnderStress, WithoutSeedsThereIsNothing) {
  const Flow flow(gridOver(glm::dvec3(-1), glm::dvec3(1), {3, 3, 3}), abcFlow);
  EXPECT_EQ(flow.trace({}).ends.size(), 0u);
}

// Calls are short: a head that has been through many cells goes on in the next.
TEST(LinesUnderStress, NoCallGoesThroughMoreCellsThanItMay) {
  const Flow flow(gridOver({-1, -1, -1}, {1, 1, 1}, {9, 9, 3}),
                  [](glm::dvec3 p) { return glm::dvec3(-p.y, p.x, 0); });
  const std::vector<uint64_t> ids{0};
  SeedHeads seeds = flow.fields->seeds(std::vector<glm::dvec3>{{0.9, 0, 0}}, ids, TraceDirection::Forward);
  const TraceOptions options{.length = 1e6, .points = PointsMode::Ends};
  int calls = 0;
  flow.device->advance(0, std::move(seeds.heads[0]), options, [&](AdvanceResult r) {
    calls++;
    EXPECT_EQ(r.retired, 0u);
    EXPECT_LE(r.counters.cells, uint64_t(kCellsPerCall) + 1);
    ASSERT_EQ(r.leaving.size(), 1u);
    EXPECT_EQ(r.leaving[0].partition, 0);
    EXPECT_EQ(wrongIn(r.leaving[0], *flow.fields->extentOf(0)), nullptr);
  });
  EXPECT_EQ(calls, 1);
}

}  // namespace
}  // namespace gxy::test
