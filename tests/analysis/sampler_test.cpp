// SPDX-License-Identifier: Apache-2.0
// What sampling rays record, against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/analysis/sampling.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

constexpr double kRadius = 0.3;

SamplingCase sphere(int64_t points) {
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
  const SampleList samples = ranks.lines(sphere(129), 1, lines);
  const HitsPerLine hits = hitsPerLine(samples, lines);
  const double area = 4 * std::numbers::pi * kRadius * kRadius, surface = 6;
  EXPECT_NEAR(hits.mean, 2 * area / surface, 3 * hits.error);
  EXPECT_NEAR(surface / 2 * hits.mean, area, 3 * surface / 2 * hits.error);
  EXPECT_LT(hits.error, 8e-4 * std::sqrt(1e6 / double(lines)));
}

TEST(UniformLines, HitASphereUniformlyByArea) {
  const auto lines = uint64_t(sweep(1'000'000));
  SamplingRanks ranks(whole(unitCube()), {});
  const SampleList samples = ranks.lines(sphere(65), 2, lines);
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
  const SampleList samples = ranks.lines(sphere(33), 3, 20'000);
  ASSERT_GT(samples.size(), 7000u);
  double worst = 0;
  for (const glm::dvec3& p : samples.position)
    worst = std::max(worst, std::abs(std::sqrt(squaredDistance(p)) - kRadius));
  // The trilinear interpolant of a square is too large by a quarter of the square of the spacing for each axis, at most.
  EXPECT_LT(worst, 3 * (1.0 / 32) * (1.0 / 32) / 4 / (2 * kRadius));
}

TEST(SamplingRays, RecordValuesOfOtherFieldsAndGradients) {
  SamplingCase c = sphere(65);
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

}  // namespace
}  // namespace gxy::test
