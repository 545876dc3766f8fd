// SPDX-License-Identifier: Apache-2.0
// Samplings under many seeded schedules of messages and tasks.
#include <gtest/gtest.h>

#include <optional>

#include "core/comm/random.h"
#include "tests/analysis/sampling.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

constexpr uint64_t kScheduledLines = 100;

bool sameSamples(const SampleList& a, const SampleList& b) {
  return a.ray == b.ray && a.hit == b.hit && a.surface == b.surface && a.t == b.t && a.position == b.position;
}

/// Samplers of a seeded world, and a sampling that all of its worlds share.
class Scheduled {
 public:
  explicit Scheduled(const Cut& cut) : cut_(cut), samplings_(size_t(cut.ranks)) {
    SamplingCase c = isosurfaceOf(sampled(unitGrid(6), squaredDistance), 0.09);
    SamplingRanks ranks(cut, {});
    for (const std::string& error :
         ranks.run(c, [&](int rank, Sampler&, std::shared_ptr<const Sampling> sampling, Collectives&) {
           samplings_[size_t(rank)] = std::move(sampling);
         }))
      if (!error.empty()) throw Error(error);
  }

  struct Outcome {
    std::optional<FlightEnding> ending;
    SampleList samples;
    std::string left;
  };
  /// Runs one sampling; it is cancelled after so many steps, unless that is negative.
  Outcome run(uint64_t seed, int64_t credits, int cancelAfter = -1) {
    InProcessWorld world(cut_.ranks, seed);
    std::vector<std::unique_ptr<Sampler>> samplers;
    for (int r = 0; r < cut_.ranks; r++) {
      Sampler::Options options;
      options.raysInFlight = credits;
      options.packetRays = 16;
      options.processorTime = [] { return std::chrono::nanoseconds(0); };
      samplers.push_back(std::make_unique<Sampler>(world.rank(r), embree(), options));
    }
    Outcome outcome;
    const FlightId id = samplers[0]->announce();
    for (int r = 0; r < cut_.ranks; r++)
      samplers[size_t(r)]->add(
          id, samplings_[size_t(r)],
          std::make_shared<UniformLines>(unitCube(), 7, 0, kScheduledLines, r, cut_.ranks));
    samplers[0]->begin(id, [&](const FlightEnding& ending) { outcome.ending = ending; });
    for (int i = 0; i != cancelAfter && world.step(); i++) {
    }
    if (cancelAfter >= 0) samplers[0]->cancel(id);
    world.run();
    for (const auto& sampler : samplers) {
      outcome.samples.append(std::move(sampler->take(id).list));
      const FlightControl::Kept kept = sampler->kept();
      if (kept.flights || kept.parkedMessages || kept.announced || kept.completionSets || kept.tasks ||
          kept.credits)
        outcome.left = "something";
    }
    SamplingRanks::sort(outcome.samples);
    return outcome;
  }

 private:
  const Cut cut_;
  std::vector<std::shared_ptr<const Sampling>> samplings_;
};

TEST(ScheduledSampling, FindsTheSameSamplesUnderAnySchedule) {
  SamplingRanks alone(whole(unitCube()), {});
  const SampleList expected =
      alone.lines(isosurfaceOf(sampled(unitGrid(6), squaredDistance), 0.09), 7, kScheduledLines);
  ASSERT_GT(expected.size(), 10u);
  Scheduled scheduled(lattice(unitCube(), {2, 2, 2}, 3));
  for (int seed = 1; seed <= seeds(300); seed++) {
    const auto outcome = scheduled.run(uint64_t(seed), seed % 3 ? 1 << 20 : 1);
    ASSERT_TRUE(outcome.ending && outcome.ending->counts()) << seed;
    ASSERT_TRUE(sameSamples(outcome.samples, expected)) << seed;
    ASSERT_EQ(outcome.left, "") << seed;
  }
}

TEST(ScheduledSampling, ACancelledOneLeavesNothingBehind) {
  Random random(5);
  for (int seed = 1; seed <= seeds(100); seed++) {
    Scheduled scheduled(kdCut(unitCube(), 9, 4, 3));  // A sampling ends with a cancelled flight.
    const auto outcome = scheduled.run(uint64_t(seed), 64, int(random.below(120)));
    ASSERT_TRUE(outcome.ending) << seed;
    ASSERT_TRUE(outcome.ending->cancelled || outcome.ending->counts()) << seed;
    ASSERT_EQ(outcome.samples.empty(), outcome.ending->cancelled) << seed;
    ASSERT_EQ(outcome.left, "") << seed;
  }
}

}  // namespace
}  // namespace gxy::test
