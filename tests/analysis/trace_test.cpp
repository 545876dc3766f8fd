// SPDX-License-Identifier: Apache-2.0
// Tracer::trace() on ranks that are threads: the same path lines on all of them, whatever ends it.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "core/comm/collective.h"
#include "core/comm/error.h"
#include "core/comm/in_process.h"
#include "core/comm/random.h"
#include "core/rays/field_maker.h"
#include "tests/analysis/rank_flows.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

struct How {
  int64_t heads = 1 << 18;
  int packet = 4096;
  int runners = 2;
};

/// Ranks that trace lines through a flow, each on a thread.
class Ranks {
 public:
  struct Result {
    std::vector<std::string> errors;  ///< by rank
    std::vector<MadeLines> made;
    std::vector<AdvanceCounters> counters;
    uint64_t forwarded = 0;
    std::vector<double> progress;  ///< what rank 0 was told while lines were traced
    GeometryBlock merged() const {
      std::vector<GeometryBlock> blocks;
      for (const MadeLines& m : made) blocks.push_back(m.block);
      return gxy::merged(GeometryKind::PathLines, blocks);
    }
    uint64_t ends(EndReason reason) const { return made.front().ends[size_t(reason)]; }
  };

  explicit Ranks(const std::vector<RankFlow>& flow, How how = {}) : flow_(flow), ledgers_(flow.size()) {
    InProcessWorld::Options options;
    options.threaded = true;
    world_ = std::make_unique<InProcessWorld>(int(flow.size()), 1, std::move(options));
    for (size_t r = 0; r < flow.size(); r++) {
      Tracer::Options tracer;
      tracer.heads = how.heads;
      tracer.packetHeads = how.packet;
      tracer.runners = how.runners;
      tracer.ledger = &ledgers_[r];
      tracer.tenant = "test";
      tracers_.push_back(std::make_unique<Tracer>(world_->rank(int(r)), tracer));
      collectives_.push_back(std::make_unique<Collective>(world_->rank(int(r))));
    }
  }
  ~Ranks() {
    world_->run();
    tracers_.clear();
    collectives_.clear();
  }

  using Change = std::function<void(TraceRequest&, int rank)>;
  Result trace(const std::vector<glm::dvec3>& seeds, const TraceOptions& options,
               TraceDirection direction = TraceDirection::Forward, const Change& change = {}) {
    Result result;
    const size_t n = flow_.size();
    result.errors.resize(n), result.made.resize(n), result.counters.resize(n);
    const uint64_t key = ++key_;
    std::vector<std::thread> threads;
    for (size_t r = 0; r < n; r++)
      threads.emplace_back([&, r] {
        RankCollectives ranks(
            *collectives_[r], int(r), int(n), key, [this, r] { check(int(r)); },
            [this, r](double fraction) {
              if (r == 0) progress_.push_back(fraction);
            });
        try {
          TraceRequest request = requestOf(flow_[r], int(r), int(n), seeds, options, direction);
          request.takeMemory = [this, r](int64_t bytes) { return ledgers_[r].enter("test", "lines", bytes); };
          if (change) change(request, int(r));
          TracedLines lines = tracers_[r]->trace(std::move(request), ranks);
          result.counters[r] = lines.counters;
          if (r == 0) result.progress = progress_;
          const auto takeMemory = [this, r](int64_t bytes) {
            return ledgers_[r].enter("test", "geometry", bytes);
          };
          result.made[r] = makeLines(std::move(lines), {}, takeMemory, ranks);
        } catch (const std::exception& e) {
          result.errors[r] = e.what();
        }
        collectives_[r]->finish(key);
      });
    for (std::thread& thread : threads) thread.join();
    world_->run();
    for (const auto& tracer : tracers_) result.forwarded += tracer->counters().itemsForwarded;
    return result;
  }

  /// What ranks.check() does.
  std::function<void(int rank)> check = [](int) {};
  Ledger& ledger(int r) { return ledgers_[size_t(r)]; }
  Tracer& tracer(int r) { return *tracers_[size_t(r)]; }
  void expectNothingKept() {
    for (size_t r = 0; r < flow_.size(); r++) {
      EXPECT_EQ(ledgers_[r].total(), 0) << "rank " << r;
      const Tracer::Kept kept = tracers_[r]->kept();
      EXPECT_EQ(kept.shares + kept.flights.flights + kept.flights.completionSets + kept.flights.tasks +
                    size_t(kept.flights.credits) + kept.flights.parkedMessages + kept.flights.announced,
                0u);
    }
  }

 private:
  const std::vector<RankFlow>& flow_;
  std::vector<Ledger> ledgers_;
  std::unique_ptr<InProcessWorld> world_;
  std::vector<std::unique_ptr<Tracer>> tracers_;
  std::vector<std::unique_ptr<Collective>> collectives_;
  std::vector<double> progress_;
  uint64_t key_ = 0;
};

std::vector<glm::dvec3> seedsIn(const Box& box, int n, uint64_t seed) {
  Random random(seed);
  std::vector<glm::dvec3> seeds;
  for (int i = 0; i < n; i++) {
    glm::dvec3 p;
    for (int a = 0; a < 3; a++)
      p[a] = box.lo[a] + (box.hi[a] - box.lo[a]) * double(random.below(1 << 20)) / double(1 << 20);
    seeds.push_back(p);
  }
  return seeds;
}

Cut cutInto(const Box& box, std::array<int, 3> parts, int ranks) { return lattice(box, parts, ranks); }

void expectNoError(const Ranks::Result& result) {
  for (const std::string& error : result.errors) ASSERT_EQ(error, "");
}

TEST(Trace, GivesTheSameBytesOnAllRanksCutsThreadsPacketsAndCredits) {
  const Grid grid = gridOver({0, 0, 0}, {5, 4, 6}, {16, 13, 19});
  const FlowFunction flow = [](glm::dvec3 p) { return abcFlow(1.7 * p); };
  const Box box = grid.box();
  std::vector<glm::dvec3> seeds = seedsIn(box, sweep(120), 1);
  for (int i = 0; i < 10; i++) seeds.push_back({-1 - i, 0, 0});
  seeds.push_back(box.lo);
  seeds.push_back(box.hi);
  std::vector<Cut> cuts = {whole(box),
                           cutInto(box, {7, 1, 1}, 2),
                           cutInto(box, {4, 4, 4}, 1),
                           cutInto(box, {4, 4, 4}, 3),
                           kdCut(box, 64, 4, 3),
                           kdCut(box, 3, 5, 7),
                           octants(box, {2.17, 1.9, 3.33}, 5)};
  const std::vector<How> ways = {{}, {1, 1, 1}, {100, 16, 4}, {1, 4096, 2}};
  std::string expected;
  std::array<uint64_t, kEndReasons> ends{};
  for (size_t c = 0; c < cuts.size(); c++) {
    const std::vector<RankFlow> ranks = flowOnRanks(grid, flow, cuts[c]);
    for (size_t w = 0; w < ways.size(); w++) {
      if (c > 1 && w != c % ways.size() && w != 0) continue;
      Ranks world(ranks, ways[w]);
      const Ranks::Result result = world.trace(seeds, {.time = 4}, TraceDirection::Both);
      expectNoError(result);
      const std::string bytes = bytesIn(result.merged());
      if (expected.empty()) {
        expected = bytes;
        ends = result.made.front().ends;
        EXPECT_EQ(result.ends(EndReason::Outside), 20u);
        EXPECT_GT(result.made.front().lines, seeds.size() / 2);
      }
      ASSERT_TRUE(bytes == expected) << cuts[c].name << ", way " << w;
      for (const MadeLines& made : result.made) ASSERT_EQ(made.ends, ends);
    }
  }
  uint64_t all = 0;
  for (const uint64_t n : ends) all += n;
  EXPECT_EQ(all, 2 * seeds.size()) << "every seed has an end in each direction";
}

glm::dvec3 rotation(glm::dvec3 p) { return {-p.y, p.x, 0}; }

TEST(Trace, JoinsALineThatCrossesABorderManyTimes) {
  const Grid grid = gridOver({-12, -12, -1}, {12, 12, 1}, {25, 25, 3});
  const TraceOptions options{.time = 2000, .length = 1e9};
  const std::vector<glm::dvec3> seed = {{9.3, 0.1, 0}};
  std::string expected;
  for (const int ranks : {1, 2, 3}) {
    const std::vector<RankFlow> flow = flowOnRanks(grid, rotation, cutInto(grid.box(), {ranks, 1, 1}, ranks));
    Ranks world(flow);
    const Ranks::Result result = world.trace(seed, options, TraceDirection::Both);
    expectNoError(result);
    EXPECT_EQ(result.made.front().lines, 1u);
    EXPECT_EQ(result.ends(EndReason::Time), 2u);
    EXPECT_TRUE(ranks == 1 || result.forwarded > 1000) << result.forwarded;
    const std::string bytes = bytesIn(result.merged());
    if (expected.empty()) expected = bytes;
    EXPECT_TRUE(bytes == expected) << ranks << " ranks";
  }
}

// The ghosts hold it, so it is not forwarded, however often it crosses.
TEST(Trace, ForwardsNoHeadThatWindsAboutABorderByTwoCells) {
  const Grid grid = gridOver({-8, -8, -1}, {8, 8, 1}, {17, 17, 3});
  const std::vector<RankFlow> flow = flowOnRanks(grid, rotation, cutInto(grid.box(), {2, 1, 1}, 2));
  Ranks world(flow);
  const Ranks::Result result =
      world.trace({{-1.9, 0.3, 0}}, {.time = 1000, .length = 1e9, .points = PointsMode::Ends});
  expectNoError(result);
  EXPECT_EQ(result.forwarded, 0u);
  EXPECT_GT(result.counters[0].cells, 1000u);
}

TEST(Trace, OfManySeedsThatAllEndInOnePartition) {
  const Grid grid = gridOver({-4, -4, -4}, {4, 4, 4}, {33, 33, 33});
  const FlowFunction sink = [](glm::dvec3 p) { return glm::dvec3(3.5, 3.5, 3.5) - p; };
  const std::vector<RankFlow> flow = flowOnRanks(grid, sink, cutInto(grid.box(), {4, 2, 2}, 4));
  const int n = sweep(8000);
  Ranks world(flow, {.heads = 1000});
  {
    const Ranks::Result result =
        world.trace(seedsIn(grid.box(), n, 3), {.tolerance = 0.01, .points = PointsMode::Ends});
    expectNoError(result);
    EXPECT_EQ(result.ends(EndReason::Slow), uint64_t(n));
    EXPECT_EQ(result.made.front().lines, uint64_t(n));
    // All segments belong to the rank of the sink, since they end there.
    for (size_t r = 0; r < 4; r++) EXPECT_EQ(result.made[r].block.ids.size(), r == 3 ? size_t(n) : 0u);
  }
  world.expectNothingKept();
}

TEST(Trace, OfManyCoincidentSeedsGivesEachItsLine) {
  const Grid grid = gridOver({-4, -4, -4}, {4, 4, 4}, {9, 9, 9});
  const std::vector<RankFlow> flow = flowOnRanks(grid, rotation, cutInto(grid.box(), {2, 2, 1}, 3));
  const auto n = size_t(sweep(20000));
  Ranks world(flow);
  const Ranks::Result result = world.trace(std::vector<glm::dvec3>(n, {2, 2, 0}),
                                           {.time = 3, .points = PointsMode::Ends}, TraceDirection::Both);
  expectNoError(result);
  EXPECT_EQ(result.ends(EndReason::Time), 2 * n);
  EXPECT_EQ(result.made.front().lines, n);
  EXPECT_EQ(result.made.front().points, 3 * n);
  const GeometryBlock all = result.merged();
  ASSERT_EQ(all.ids.size(), 2 * n);
  for (uint64_t i = 0; i < 2 * n; i++) ASSERT_EQ(all.ids[i], (i / 2) << 24 | i % 2);
  EXPECT_EQ(all.points.size(), 3u) << "equal points become one";
}

TEST(Trace, EndsOnAllRanksWhereTheQuotaOfOneIsReached) {
  const Grid grid = gridOver({-12, -12, -1}, {12, 12, 1}, {25, 25, 3});
  const std::vector<RankFlow> flow = flowOnRanks(grid, rotation, cutInto(grid.box(), {3, 1, 1}, 3));
  Ranks world(flow);
  const auto result = world.trace(seedsIn({{-5, -5, -1}, {5, 5, 1}}, 200, 1), {.length = 1e5},
                                  TraceDirection::Forward, [&](TraceRequest& request, int rank) {
                                    request.takeMemory = [&world, rank](int64_t bytes) {
                                      EXPECT_EQ(bytes % (1 << 20), 0) << "steps of 1 MiB";
                                      Ledger& ledger = world.ledger(rank);
                                      if (rank == 1 && ledger.total() + bytes > 20 << 20)
                                        throw Error(std::to_string(bytes) + " bytes are needed");
                                      return ledger.enter("test", "lines", bytes);
                                    };
                                  });
  for (const std::string& error : result.errors) {
    EXPECT_EQ(error, result.errors.front());
    EXPECT_TRUE(error.starts_with("rank 1: ") && error.ends_with(" bytes are needed")) << error;
  }
  EXPECT_GT(world.ledger(1).peak(), 4 << 20) << "it was reached in the middle";
  world.expectNothingKept();
  expectNoError(world.trace({{1, 1, 0}}, {.time = 1}));
}

// A trace that would take hours.
TEST(Trace, EndsOnAllRanksWhenItIsCancelledOnOne) {
  const Grid grid = gridOver({-12, -12, -1}, {12, 12, 1}, {25, 25, 3});
  for (const int ranks : {1, 3}) {
    const std::vector<RankFlow> flow = flowOnRanks(grid, rotation, cutInto(grid.box(), {ranks, 1, 1}, ranks));
    Ranks world(flow);
    std::atomic<int> asked = 0;
    world.check = [&](int rank) {
      if (rank == ranks - 1 && asked++ > 3) throw Error("cancelled");
    };
    const Ranks::Result result =
        world.trace(seedsIn({{-5, -5, -1}, {5, 5, 1}}, 1000, 1), {.length = 1e9, .points = PointsMode::Ends});
    for (const std::string& error : result.errors)
      EXPECT_EQ(error, ranks == 1 ? "cancelled" : "rank 2: cancelled");
    world.check = [](int) {};
    world.expectNothingKept();
    expectNoError(world.trace({{1, 1, 0}}, {.time = 1}));
  }
}

TEST(Trace, TellsWhichFractionOfTheLinesHasEnded) {
  const Grid grid = gridOver({-12, -12, -1}, {12, 12, 1}, {25, 25, 3});
  const std::vector<RankFlow> flow = flowOnRanks(grid, rotation, cutInto(grid.box(), {3, 1, 1}, 3));
  Ranks world(flow, {.heads = 40});
  const Ranks::Result result =
      world.trace(seedsIn({{-5, -5, -1}, {5, 5, 1}}, 400, 1), {.length = 1000, .points = PointsMode::Ends});
  expectNoError(result);
  const std::vector<double>& told = result.progress;
  ASSERT_FALSE(told.empty());
  for (const double fraction : told) EXPECT_TRUE(fraction >= 0 && fraction <= 1) << fraction;
  EXPECT_EQ(told.back(), 1);
}

TEST(Trace, RefusesRequestsThatCannotBe) {
  const Grid grid = gridOver({-4, -4, -4}, {4, 4, 4}, {5, 5, 5});
  const std::vector<RankFlow> flow = flowOnRanks(grid, rotation, cutInto(grid.box(), {2, 1, 1}, 2));
  Ranks world(flow);
  const auto refused = [&](const Ranks::Change& change, const std::string& expected) {
    const auto result = world.trace({{1, 1, 0}, {2, 1, 0}}, {.time = 1}, TraceDirection::Forward, change);
    for (const std::string& error : result.errors) EXPECT_EQ(error, expected);
    world.expectNothingKept();
  };
  refused(
      [](TraceRequest& r, int rank) {
        r.options.time = rank;
        r.options.tolerance = 1 - 2 * rank;
      },
      "rank 1: trace: tolerance is -1.000000; expected a number of cells above 0");
  refused(
      [](TraceRequest& r, int rank) {
        if (rank == 1) r.lines[0] = uint64_t(1) << 40;
      },
      "rank 1: trace: a line has the number 1099511627776, expected at most 2^40 - 1");
  refused([](TraceRequest& r, int) { r.lines.push_back(3); },
          "rank 0: trace: 1 seeds have 2 numbers of lines, expected as many");
  refused([](TraceRequest& r, int) { r.device = nullptr; },
          "rank 0: trace: there are no fields, expected some");
}

/// A backend that advances lines, or not.
class SomeBackend final : public Backend {
 public:
  explicit SomeBackend(bool advances) : advances_(advances) {}
  std::string name() const override { return "some"; }
  std::string device() const override { return "none"; }
  std::unique_ptr<DeviceScene> makeScene(std::shared_ptr<const CompiledScene>, int,
                                         const Advance&) const override {
    throw Error("no scenes");
  }
  std::unique_ptr<DeviceFields> makeFields(std::shared_ptr<const CompiledFields> fields,
                                           int rank) const override {
    return advances_ ? makePlainFields(std::move(fields), rank) : nullptr;
  }

 private:
  const bool advances_;
};

TEST(FieldMaker, TakesTheOtherBackendOnlyWhereTheOneInUseCannot) {
  const Grid grid = gridOver({-4, -4, -4}, {4, 4, 4}, {5, 5, 5});
  const auto fields = std::dynamic_pointer_cast<const CompiledFields>(
      flowOnRanks(grid, rotation, whole(grid.box())).front().fields);
  int made = 0;
  BackendRegistry registry;
  registry.addForFields([&made](Ledger*) {
    made++;
    return std::make_unique<SomeBackend>(true);
  });
  const SomeBackend able(true), unable(false);
  EXPECT_NE(FieldMaker(able, registry).make(fields, 0), nullptr);
  EXPECT_EQ(made, 0);
  FieldMaker maker(unable, registry);
  for (int i = 0; i < 2; i++) EXPECT_NE(maker.make(fields, 0), nullptr);
  EXPECT_EQ(made, 1) << "it is kept";
  try {
    FieldMaker(unable, BackendRegistry()).make(fields, 0);
    FAIL();
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "backend some cannot trace lines, and this program has no other one that can");
  }
}

}  // namespace
}  // namespace gxy::test
