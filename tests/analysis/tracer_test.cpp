// SPDX-License-Identifier: Apache-2.0
// Traces under many schedules: always complete, exact, nothing left behind. --schedules=20000 tries so many.
#include <gtest/gtest.h>

#include "tests/analysis/traces.h"
#include "tests/lines/same_lines.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

uint64_t schedules(int usual) {
  for (const std::string& arg : testing::internal::GetArgvs())
    if (arg.rfind("--schedules=", 0) == 0) return std::stoull(arg.substr(12));
  return uint64_t(seeds(usual));
}

glm::dvec3 smallFlow(glm::dvec3 p) { return abcFlow(1.7 * p); }

Grid smallGrid() { return gridOver({0, 0, 0}, {4, 4, 4}, {9, 9, 9}); }

std::vector<glm::dvec3> someSeeds(uint64_t seed, size_t n) {
  Random random(seed);
  std::vector<glm::dvec3> seeds;
  for (size_t i = 0; i < n; i++) {
    glm::dvec3 p;
    for (int a = 0; a < 3; a++) p[a] = 4.4 * (double(random.below(1 << 20)) / double(1 << 20)) - 0.2;
    seeds.push_back(p);  // some are outside
  }
  return seeds;
}

/// A flow on some ranks, and what lines through it are to be.
struct CutFlow {
  explicit CutFlow(const Cut& cut) : cut(cut), ranks(flowOnRanks(smallGrid(), smallFlow, cut)) {}
  Cut cut;
  std::vector<RankFlow> ranks;
};

const std::vector<CutFlow>& flows() {
  static const std::vector<CutFlow> all = [] {
    const Box box = smallGrid().box();
    std::vector<CutFlow> flows;
    flows.emplace_back(whole(box));
    flows.emplace_back(lattice(box, {2, 1, 1}, 2));
    flows.emplace_back(lattice(box, {7, 1, 1}, 3));
    flows.emplace_back(kdCut(box, 9, 4, 5));
    flows.emplace_back(lattice(box, {4, 4, 4}, 5));
    flows.emplace_back(octants(box, {1.3, 2.1, 1.9}, 3));
    return flows;
  }();
  return all;
}

const CutFlow& onePiece() { return flows().front(); }

Lines expectedOf(const std::vector<glm::dvec3>& seeds, const TraceOptions& options,
                 TraceDirection direction) {
  const RankFlow& one = onePiece().ranks.front();
  return trace(*one.device, *one.fields, seeds, options, direction);
}

// Runs to the end, and expects that nothing was refused.
void runAll(Traces& traces) {
  ASSERT_TRUE(traces.run()) << "there is no end";
  ASSERT_EQ(traces.errors(), std::vector<std::string>{});
}

void expectEnded(Traces& traces, FlightId id) {
  ASSERT_EQ(traces.outcome(id).complete, 1);
  ASSERT_TRUE(traces.endedEverywhere(id));
}

TEST(Tracer, GivesTheSameLinesUnderManySchedules) {
  uint64_t forwarded = 0;
  const TraceOptions options{.time = 1.5};
  for (uint64_t seed = 1; seed <= schedules(1000); seed++) {
    SCOPED_TRACE("schedule " + std::to_string(seed));
    const CutFlow& flow = flows()[seed % flows().size()];
    Traces::Options how;
    how.packet = 1 + int(seed % 5);
    how.heads = seed % 3 ? 1 + int64_t(seed % 7) : 1 << 18;
    how.runners = 1 + int(seed % 6);
    Traces traces(seed, flow.ranks, how);
    const auto direction = TraceDirection(seed % 3);
    const std::vector<glm::dvec3> first = someSeeds(seed, seed / 2 % 9), second = someSeeds(seed + 99, 5);
    const FlightId a = traces.announce(), b = traces.announce();
    traces.begin(a, first, options, direction);
    traces.begin(b, second, options, TraceDirection::Both, 1);
    runAll(traces);
    for (const FlightId id : {a, b}) {
      expectEnded(traces, id);
      ASSERT_TRUE(traces.outcome(id).ending.counts()) << traces.outcome(id).ending.error;
    }
    expectSameLines(traces.take(a), expectedOf(first, options, direction), flow.cut.name);
    expectSameLines(traces.take(b), expectedOf(second, options, TraceDirection::Both), flow.cut.name);
    forwarded += traces.forwarded();
    ASSERT_EQ(traces.leftOver(), "");
    if (HasFailure()) return;
  }
  EXPECT_GT(forwarded, schedules(1000));
}

TEST(Tracer, EndsEverywhereWhenAnyRankStopsIt) {
  uint64_t stopped = 0, wholes = 0;
  const TraceOptions endless{.time = 1e9, .length = 1e9, .points = PointsMode::Ends};
  const TraceOptions options{.time = 1.5};
  for (uint64_t seed = 1; seed <= schedules(600); seed++) {
    SCOPED_TRACE("schedule " + std::to_string(seed));
    const CutFlow& flow = flows()[seed % flows().size()];
    Traces::Options how;
    how.heads = seed % 2 ? 4 : 1 << 18;
    how.runners = 4;
    Traces traces(seed, flow.ranks, how);
    const std::vector<glm::dvec3> some = someSeeds(seed, 6), other = someSeeds(seed + 99, 4);
    const FlightId id = traces.announce(), beside = traces.announce();
    traces.begin(id, some, seed % 4 ? options : endless, TraceDirection::Both);
    traces.begin(beside, other, options, TraceDirection::Forward, 1);
    const int rank = int(seed / 7 % flow.ranks.size());
    for (uint64_t steps = Random(seed).below(150); steps > 0 && traces.step(); steps--) {
    }
    traces.tracer(rank).stop(id, "cancelled");
    traces.tracer(0).stop(id, "too late");
    runAll(traces);
    traces.tracer(rank).stop(id, "over");
    runAll(traces);
    expectEnded(traces, id);
    const FlightEnding& ending = traces.outcome(id).ending;
    if (ending.counts()) {
      wholes++;
      const Lines lines = traces.take(id);
      if (seed % 4) expectSameLines(lines, expectedOf(some, options, TraceDirection::Both), flow.cut.name);
    } else {
      stopped++;
      ASSERT_TRUE(ending.error == "rank " + std::to_string(rank) + ": cancelled" ||
                  (rank > 0 && ending.error == "rank 0: too late"))
          << ending.error;
      traces.take(id);
    }
    ASSERT_TRUE(traces.outcome(beside).ending.counts());
    expectSameLines(traces.take(beside), expectedOf(other, options, TraceDirection::Forward), flow.cut.name);
    ASSERT_EQ(traces.leftOver(), "");
    if (HasFailure()) return;
  }
  EXPECT_GT(stopped, schedules(600) / 3);
  EXPECT_GT(wholes, 0u) << "some were complete before";
}

TEST(Tracer, FailsEverywhereWithTheErrorOfTheRankThatCannotDoItsPart) {
  uint64_t failed = 0;
  const TraceOptions options{.time = 1.5};
  for (uint64_t seed = 1; seed <= schedules(600); seed++) {
    SCOPED_TRACE("schedule " + std::to_string(seed));
    const CutFlow& flow = flows()[seed % flows().size()];
    Traces::Options how;
    how.heads = seed % 2 ? 3 : 1 << 18;
    how.runners = 4;
    how.failure = TraceFailure(1 + seed % 3);
    how.failingRank = int(seed / 5 % flow.ranks.size());
    Traces traces(seed, flow.ranks, how);
    const std::vector<glm::dvec3> some = someSeeds(seed, 12), other = someSeeds(seed + 99, 4);
    const FlightId id = traces.announce(), beside = traces.announce();
    traces.begin(id, some, options, TraceDirection::Both);
    traces.begin(beside, other, options, TraceDirection::Forward, 1);
    runAll(traces);
    expectEnded(traces, id);
    const FlightEnding& ending = traces.outcome(id).ending;
    if (ending.counts()) {  // no head came to the rank that would have failed
      expectSameLines(traces.take(id), expectedOf(some, options, TraceDirection::Both), flow.cut.name);
    } else {
      failed++;
      const char* reason = how.failure == TraceFailure::Result ? "the device is lost" : "no room";
      ASSERT_EQ(ending.error, "rank " + std::to_string(how.failingRank) + ": " + reason);
      traces.take(id);
    }
    ASSERT_TRUE(traces.outcome(beside).ending.counts());
    expectSameLines(traces.take(beside), expectedOf(other, options, TraceDirection::Forward), flow.cut.name);
    ASSERT_EQ(traces.leftOver(), "");
    if (HasFailure()) return;
  }
  EXPECT_GT(failed, schedules(600) * 8 / 10);
}

// The bound holds: heads that are under way are at most the credits, or one seed's where these are fewer.
TEST(Tracer, KeepsToItsCredits) {
  for (const int64_t credits : {1, 6, 40}) {
    Traces::Options how;
    how.heads = credits;
    Traces traces(uint64_t(credits), flows()[4].ranks, how);
    const FlightId id = traces.announce();
    traces.begin(id, someSeeds(1, 100), {.time = 1.5}, TraceDirection::Both);
    runAll(traces);
    int64_t most = 0;
    for (int r = 0; r < 5; r++) most = std::max(most, traces.tracer(r).counters().mostCredits);
    EXPECT_LE(most, std::max<int64_t>(credits, 2));
    EXPECT_GE(most, 2);
    traces.take(id);
  }
}

TEST(Tracer, RefusesHeadsThatNoRankWouldSend) {
  const CutFlow& flow = flows()[1];
  const auto message = [](FlightId id, int32_t partition, float fraction) {
    HeadList heads(partition, 1);
    heads.start(0, 7, false, {0, 0, 0}, {fraction, 0.5f, 0.5f});
    Bytes out =
        Writer().write(id).write(partition).write(int32_t(0)).write(int32_t(1)).write(uint32_t(0)).take();
    heads.write(out);
    return out;
  };
  struct Case {
    int32_t partition;
    float fraction;
    const char* expected;
  };
  for (const Case& c : {Case{1, 0.5f, "partition 1 is not one"}, Case{2, 0.5f, "partition 2 is not one"},
                        Case{-1, 0.5f, "partition -1 is not one"}, Case{0, 1.5f, "outside its cell"}}) {
    InProcessWorld::Options options;
    std::vector<std::string> errors;
    options.onError = [&](int, const std::string& error) { errors.push_back(error); };
    InProcessWorld world(2, 1, std::move(options));
    std::vector<std::unique_ptr<Tracer>> tracers;
    std::vector<std::shared_ptr<TraceShare>> shares;
    std::string error;
    for (int r = 0; r < 2; r++) {
      Tracer::Options how;
      how.longTasks = false;
      tracers.push_back(std::make_unique<Tracer>(world.rank(r), how));
    }
    const FlightId id = tracers[0]->announce();
    for (int r = 0; r < 2; r++) {
      shares.push_back(std::make_shared<TraceShare>(
          requestOf(flow.ranks[size_t(r)], r, 2, someSeeds(1, 4), {.time = 1}, TraceDirection::Forward)));
      tracers[size_t(r)]->join(id, shares.back());
    }
    tracers[0]->begin(id, [&](const FlightEnding& ending) { error = ending.error; });
    world.rank(1).send(0, Channel::Items, message(id, c.partition, c.fraction));
    for (int i = 0; i < 3000 && world.step(); i++) {  // the head that was not counted keeps waves going
    }
    ASSERT_FALSE(errors.empty()) << c.expected;
    EXPECT_NE(errors[0].find(c.expected), std::string::npos) << errors[0];
    for (int r = 0; r < 2; r++) tracers[size_t(r)]->leave(id);
  }
}

}  // namespace
}  // namespace gxy::test
