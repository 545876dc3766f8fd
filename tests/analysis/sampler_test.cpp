// SPDX-License-Identifier: Apache-2.0
// What sampling rays record, against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "backends/embree/embree_backend.h"
#include "core/comm/random.h"
#include "tests/analysis/sampling.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

constexpr double kRadius = 0.3;

SamplingCase sphereCase(int64_t points) {
  return isosurfaceOf(sampled(unitGrid(points), squaredDistance), kRadius * kRadius);
}

// The mean number of hits of a line, and its standard error; hits of one line depend on each other.
struct HitsPerLine {
  double mean, error;
};
HitsPerLine hitsPerLine(const SampleList& samples, uint64_t lines) {
  double sum = double(samples.size()), squares = 0;
  for (size_t i = 0; i < samples.size();) {
    size_t j = i;
    while (j < samples.size() && samples.ray[j] == samples.ray[i]) j++;
    squares += double(j - i) * double(j - i);
    i = j;
  }
  const double n = double(lines), mean = sum / n;
  return {mean, std::sqrt((squares / n - mean * mean) / n)};
}

TEST(UniformLines, MeetASphereAsOftenAsCauchyAndCroftonSay) {
  const auto lines = uint64_t(sweep(1'000'000));
  SamplingRanks ranks(whole(unitCube()), {});
  const SampleList samples = ranks.lines(sphereCase(129), 1, lines);
  const HitsPerLine hits = hitsPerLine(samples, lines);
  const double area = 4 * std::numbers::pi * kRadius * kRadius, surface = 6;
  EXPECT_NEAR(hits.mean, 2 * area / surface, 3 * hits.error);
  EXPECT_NEAR(surface / 2 * hits.mean, area, 3 * surface / 2 * hits.error);
  EXPECT_LT(hits.error, 8e-4 * std::sqrt(1e6 / double(lines)));
}

TEST(UniformLines, HitASphereUniformlyByArea) {
  const auto lines = uint64_t(sweep(600'000));
  SamplingRanks ranks(whole(unitCube()), {});
  const SampleList samples = ranks.lines(sphereCase(65), 2, lines);
  std::vector<double> bins(48);
  double all = 0;
  for (size_t i = 0; i < samples.size(); i++) {
    if (samples.hit[i] != 0) continue;  // one hit of a line: the other one depends on it
    const glm::dvec3 q = (samples.position[i] - 0.5) / kRadius;
    const int band = std::clamp(int((q.z + 1) * 3), 0, 5);
    const int sector = std::clamp(int((std::atan2(q.y, q.x) / (2 * std::numbers::pi) + 0.5) * 8), 0, 7);
    bins[size_t(8 * band + sector)]++;
    all++;
  }
  double chiSquare = 0;
  for (const double n : bins) chiSquare += (n - all / 48) * (n - all / 48) / (all / 48);
  EXPECT_LT(chiSquare, 82.72);  // p = 1e-3 for 47 degrees of freedom
  EXPECT_GT(all, 0.18 * double(lines));
}

TEST(SamplingRays, MeetTheSphereWhereItIs) {
  SamplingRanks ranks(whole(unitCube()), {});
  const SampleList samples = ranks.lines(sphereCase(33), 3, 20'000);
  ASSERT_GT(samples.size(), 7000u);
  double worst = 0;
  for (const glm::dvec3& p : samples.position)
    worst = std::max(worst, std::abs(std::sqrt(squaredDistance(p)) - kRadius));
  // The trilinear interpolant of a square is too large by a quarter of the square of the spacing for each axis, at most.
  EXPECT_LT(worst, kRadius - std::sqrt(kRadius * kRadius - 0.75 / (32 * 32)) + 1e-6);
}

TEST(SamplingRays, RecordValuesOfOtherFieldsAndGradients) {
  SamplingCase c = sphereCase(65);
  c.volumes.push_back(sampled(unitGrid(9), [](glm::dvec3 p) { return 2 * p.x - p.y; }));
  c.fields = {{1, 0}, {0, 0}};
  c.recorded = 2;
  c.gradient = true;
  SamplingRanks ranks(whole(unitCube()), {});
  const SampleList samples = ranks.lines(c, 4, 5'000);
  ASSERT_GT(samples.size(), 1500u);
  for (size_t i = 0; i < samples.size(); i++) {
    const glm::dvec3 p = samples.position[i], g = samples.gradient[i];
    ASSERT_NEAR(samples.values[0][i], 2 * p.x - p.y, 2e-6);
    ASSERT_EQ(samples.values[1][i], float(kRadius * kRadius));
    for (int a = 0; a < 3; a++) ASSERT_NEAR(g[a], 2 * (p[a] - 0.5), 2e-4);
  }
}

/// Where a ray from outside enters {x >= 0.3 and y >= 0.4} within the unit cube; infinite if it does not.
double entryOf(const SampleRay& ray) {
  const glm::dvec3 d = glm::normalize(ray.direction);
  double from = 0, to = std::numeric_limits<double>::infinity();
  const double lo[3] = {0.3, 0.4, 0};
  for (int a = 0; a < 3; a++) {
    const double near = (lo[a] - ray.origin[a]) / d[a], far = (1 - ray.origin[a]) / d[a];
    from = std::max(from, std::min(near, far));
    to = std::min(to, std::max(near, far));
  }
  return from < to ? from : std::numeric_limits<double>::infinity();
}

TEST(SamplingRays, MeetTheBoundaryOfAConjunctionExactly) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  SamplingCase c;
  c.volumes = {sampled(unitGrid(17), [](glm::dvec3 p) { return p.x; }),
               sampled(unitGrid(12), [](glm::dvec3 p) { return p.y; })};
  Vis vis;
  vis.isovalues = {0.3};
  c.operators.push_back(vis);
  vis.isovalues = {0.4};
  c.operators.push_back(vis);
  c.shown = {0, 1};
  c.fields = {{0, 0}, {1, 0}};
  c.recorded = 2;
  c.rules = {{{{1, 0.4, kInfinity}}, 1}, {{{0, 0.3, kInfinity}}, 1}};
  std::vector<SampleRay> rays;
  Random random(11);
  const auto unit = [&random] { return double(random.below(1 << 30)) / (1 << 30); };
  while (rays.size() < size_t(sweep(100'000))) {
    const SampleRay ray{rays.size(), {unit(), unit(), unit()}, {unit() - 0.5, unit() - 0.5, unit() - 0.5}};
    if (ray.origin.x < 0.3 || ray.origin.y < 0.4) rays.push_back(ray);
  }
  SamplingRanks ranks(lattice(unitCube(), {2, 2, 2}, 2), {});
  const SampleList samples = ranks.all(c, [&](int rank) {
    return std::make_shared<GivenRays>(rank == 0 ? rays : std::vector<SampleRay>(), unitCube());
  });
  std::vector<double> met(rays.size(), kInfinity);
  for (size_t i = 0; i < samples.size(); i++) {
    const SampleRay& ray = rays[samples.ray[i]];
    met[samples.ray[i]] = glm::dot(samples.position[i] - ray.origin, glm::normalize(ray.direction));
    EXPECT_GE(samples.values[0][i], 0.3f);
    EXPECT_GE(samples.values[1][i], 0.4f);
  }
  int missed = 0, extra = 0;
  double worst = 0;
  for (size_t i = 0; i < rays.size(); i++) {
    const double expected = entryOf(rays[i]);
    missed += expected < kInfinity && met[i] == kInfinity;
    extra += expected == kInfinity && met[i] < kInfinity;
    if (expected < kInfinity && met[i] < kInfinity) worst = std::max(worst, std::abs(expected - met[i]));
  }
  EXPECT_EQ(missed, 0);
  EXPECT_EQ(extra, 0);
  EXPECT_LT(worst, 1e-4 / 11);
}

/// A backend that makes scenes, but no samplings.
class DrawingBackend final : public Backend {
 public:
  std::string name() const override { return "drawing"; }
  std::string device() const override { return "none"; }
  std::unique_ptr<DeviceScene> makeScene(std::shared_ptr<const CompiledScene>, int,
                                         const Advance&) const override {
    return std::make_unique<Scene>();
  }

 private:
  class Scene final : public DeviceScene {
   public:
    std::shared_ptr<const DeviceFrame> makeFrame(const CompiledFrame&) const override { return nullptr; }
    void spawn(const DeviceFrame&, const SpawnTile&, Done) const override {}
    void trace(const DeviceFrame&, int, bool, RayList, Done) const override {}
    size_t bytes() const override { return 0; }
  };
};

TEST(SamplingRays, AreTracedOnTheOtherBackendWhereTheFirstCannotSample) {
  const DrawingBackend drawing;
  const Cut cut = lattice(unitCube(), {2, 1, 1}, 2);
  SamplingRanks::Run run;
  run.backend = &drawing;
  EXPECT_THROW(SamplingRanks(cut, run).lines(sphereCase(9), 1, 100), Error);
  run.options.other = [](Ledger*) { return makeEmbreeBackend(); };
  SamplingRanks other(cut, run), first(cut, {});
  const SampleList samples = other.lines(sphereCase(9), 1, 100);
  EXPECT_GT(samples.size(), 10u);
  EXPECT_EQ(samples.position, first.lines(sphereCase(9), 1, 100).position);
}

TEST(SamplingRays, EndWhenTheirSamplesHaveNoRoomWhileAPacketIsTraced) {
  expectSamplesEnteredWhileTheyAreRecorded(embree());
}

TEST(SamplingRays, EndWithTheirNumberOfHits) {
  SamplingCase c = isosurfaceOf(sampled(unitGrid(17), [](glm::dvec3 p) { return std::abs(p.x - 0.5); }), 0);
  c.operators[0].isovalues = {0.1, 0.2, 0.3};
  SamplingRanks ranks(lattice(unitCube(), {3, 1, 1}, 2), {});
  const auto along = [&](int hits, double length) {
    c.rules[0].hits = hits;
    return ranks.all(c, [&](int rank) {
      std::vector<SampleRay> rays;
      if (rank == 0) rays.push_back({7, {-1, 0.5, 0.5}, {2, 0, 0}, length});
      return std::make_shared<GivenRays>(std::move(rays), unitCube());
    });
  };
  const double at[] = {0.2, 0.3, 0.4, 0.6, 0.7, 0.8};
  for (int hits = 1; hits <= 7; hits++) {
    const SampleList samples = along(hits, 3);
    ASSERT_EQ(samples.size(), size_t(std::min(hits, 6)));
    for (size_t i = 0; i < samples.size(); i++) {
      EXPECT_EQ(samples.hit[i], i);
      EXPECT_EQ(samples.ray[i], 7u);
      EXPECT_NEAR(samples.position[i].x, at[i], 1e-6);
    }
  }
  EXPECT_EQ(along(7, 1.65).size(), 4u);
}

}  // namespace
}  // namespace gxy::test
