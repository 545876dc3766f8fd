// SPDX-License-Identifier: Apache-2.0
// Lines by each ISPC target against lines in plain C++, to the bit.
#include <gtest/gtest.h>

#include <thread>

#include "core/rays/backend.h"
#include "tests/lines/same_lines.h"
#include "tests/lines/stress_flows.h"

std::unique_ptr<gxy::Backend> makeBackend_sse4();
std::unique_ptr<gxy::Backend> makeBackend_avx2();
std::unique_ptr<gxy::Backend> makeBackend_avx512skx();

namespace gxy::test {
namespace {

std::vector<std::unique_ptr<Backend>> backends() {
  std::vector<std::unique_ptr<Backend>> all;
  all.push_back(makeBackend_sse4());
  if (__builtin_cpu_supports("avx2")) all.push_back(makeBackend_avx2());
  if (__builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq"))
    all.push_back(makeBackend_avx512skx());
  return all;
}

void expectSameOnAll(const std::shared_ptr<const CompiledFields>& fields,
                     const std::vector<glm::dvec3>& seeds, const TraceOptions& options,
                     const std::string& what) {
  const auto plain = makePlainFields(fields, 0);
  const Lines expected = trace(*plain, *fields, seeds, options, TraceDirection::Both);
  for (const auto& backend : backends()) {
    const auto device = backend->makeFields(fields, 0);
    expectSameLines(trace(*device, *fields, seeds, options, TraceDirection::Both), expected,
                    what + " " + backend->device());
  }
}

TEST(Lines, HaveTheBitsOfPlainCppOnAllFieldsUnderStress) {
  for (const StressFlow& stress : stressFlows()) {
    const Flow flow(stress.grid, stress.flow);
    const std::vector<glm::dvec3> seeds = stressSeeds(stress.grid, 32, 2);
    const double spacing = stress.grid.spacing.x, length = 20 * spacing;
    expectSameOnAll(flow.fields, seeds, {.length = length}, stress.name);
    expectSameOnAll(flow.fields, seeds, {.length = length, .points = PointsMode::Ends}, stress.name);
    expectSameOnAll(flow.fields, seeds,
                    {.length = length, .points = PointsMode::EqualLength, .interval = 0.1 * spacing},
                    stress.name);
  }
}

TEST(Lines, HaveTheBitsOfPlainCppWithFieldsBesideThemAndInPieces) {
  const Grid grid = gridOver({0, 0, 0}, {6, 5, 7}, {25, 22, 30});
  const auto cut = std::make_shared<const Partitioning>(Partitioning::lattice(
      {std::vector{0.0, 2.3, 6.0}, std::vector{0.0, 5.0}, std::vector{0.0, 3.1, 7.0}}, 1));
  const auto flow = [](glm::dvec3 p) { return 40.0 * abcFlow(1.7 * p); };
  const auto beside = [](glm::dvec3 p) { return std::vector<double>{20 * p.x + p.y, p.z}; };
  using Types = std::pair<ScalarType, ScalarType>;
  for (const auto& [type, other] :
       {Types(ScalarType::Float32, ScalarType::UInt8), Types(ScalarType::Int8, ScalarType::UInt16),
        Types(ScalarType::Int16, ScalarType::Float32)}) {
    const auto fields = std::make_shared<const CompiledFields>(
        std::vector{volumeOf(grid, *cut, 3, vectorsOf(flow), type), volumeOf(grid, *cut, 2, beside, other)},
        cut);
    const std::vector<glm::dvec3> seeds = stressSeeds(grid, 60, 3);
    const std::string what = std::string(nameOf(type)) + " " + nameOf(other);
    expectSameOnAll(fields, seeds, {.condition = TraceCondition{0, 90, 95}}, what);
    expectSameOnAll(fields, seeds, {.time = 0.1, .points = PointsMode::EqualTime, .interval = 1e-4}, what);
    expectSameOnAll(fields, seeds, {.tolerance = 0.1, .length = 7, .minimumSpeed = 10, .normalised = true},
                    what);
  }
}

// More points than a call has room for, of which many lie in one step.
TEST(Lines, HaveTheBitsOfPlainCppWithThousandsOfPointsACell) {
  const Flow flow(gridOver(glm::dvec3(-1), glm::dvec3(1), {5, 5, 5}),
                  [](glm::dvec3 p) { return abcFlow(3.0 * p); });
  const std::vector<glm::dvec3> seeds = stressSeeds(flow.fields->grid(), 30, 4);
  expectSameOnAll(flow.fields, seeds, {.time = 0.5, .points = PointsMode::EqualTime, .interval = 1e-4},
                  "time");
  expectSameOnAll(flow.fields, seeds, {.length = 0.5, .points = PointsMode::EqualLength, .interval = 1e-4},
                  "length");
}

TEST(Lines, OfLongOrbitsHaveTheBitsOfPlainCppOverManyCalls) {
  const Flow flow(gridOver({-1, -1, -1}, {1, 1, 1}, {9, 9, 3}),
                  [](glm::dvec3 p) { return glm::dvec3(-p.y, p.x, 0); });
  std::vector<glm::dvec3> seeds;
  for (int i = 1; i <= 40; i++) seeds.push_back({0.024 * i, 0, 0.1});
  expectSameOnAll(flow.fields, seeds, {.length = 900, .points = PointsMode::Ends}, "orbits");
  expectSameOnAll(flow.fields, seeds, {.length = 60}, "orbits");
}

TEST(Lines, OfManyThreadsAtOnceHaveTheSameBits) {
  const Flow flow(gridOver(glm::dvec3(-1), glm::dvec3(1), {9, 9, 9}),
                  [](glm::dvec3 p) { return abcFlow(3.0 * p); });
  const std::vector<glm::dvec3> seeds = stressSeeds(flow.fields->grid(), 200, 5);
  const Lines expected = flow.trace(seeds);
  const auto backend = makeBackend_sse4();
  const auto device = backend->makeFields(flow.fields, 0);
  std::vector<Lines> each(4);
  std::vector<std::thread> threads;
  for (Lines& lines : each) threads.emplace_back([&] { lines = trace(*device, *flow.fields, seeds, {}); });
  for (std::thread& t : threads) t.join();
  for (const Lines& lines : each) expectSameLines(lines, expected, "thread");
}

}  // namespace
}  // namespace gxy::test
