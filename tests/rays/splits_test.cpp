// SPDX-License-Identifier: Apache-2.0
// Where a ray is cut into partitions changes no bit: each segment and each hit belongs to exactly one interval.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/rays/maps.h"

namespace gxy::test {
namespace {

// 1 to 64 intervals that end anywhere, at planes of cells and of macrocells, and at ends of segments.
template <class Real>
std::vector<Real> randomCuts(Random& random, const typename Kernels<Real>::Ray& ray, double rate) {
  std::vector<Real> cuts;
  for (int i = random.below(64); i > 0; i--) {
    const int kind = random.below(4), axis = random.below(3);
    Real t = Real(random.in(0, 2.5));
    if (kind == 1) t = (Real(random.below(40)) - ray.g.po[axis]) * ray.g.rpd[axis];
    if (kind == 2) t = (Real(8 * random.below(6)) - ray.g.po[axis]) * ray.g.rpd[axis];
    if (kind == 3) t = Real(ray.t0 + random.below(200) / (rate * ray.cells));
    if (t > 0 && t < 10) cuts.push_back(t);
  }
  std::sort(cuts.begin(), cuts.end());
  return cuts;
}

template <class Real>
void expectSameBits(MapShape shape) {
  Random random(23 + uint64_t(shape));
  int different = 0, marched = 0;
  for (int scene = 0; scene < 12; scene++) {
    const Index3 n{2 + random.below(30), 2 + random.below(40), 2 + random.below(40)};
    const Field f = sampled(gridOf(n, random.point(0.3, 1)), turbulence);
    Shown shown;
    shown.map = compiled(randomMaps(random, shape), f);
    for (size_t i = 0; i < f.macrocells().size(); i++)
      shown.plan.push_back(
          random.below(4) ? planOf(random.scale(0.2, 8), kIntegrators[random.below(2)], random.scale(0.05, 8))
                          : 0);
    const View<Real> view(f, shown);
    for (int i = 0; i < 200; i++) {
      const auto ray = rayIn(view, randomRay(random, f));
      const Real tMin = random.below(3) ? Real(0) : Real(0.05),
                 tStop = random.below(4) ? Real(1e30) : Real(random.in(0, 2));
      const auto whole = march<Real>(view, ray, tMin, {}, tStop);
      const auto split = march<Real>(view, ray, tMin, randomCuts<Real>(random, ray, 2), tStop);
      marched += whole.L.A > 0;
      different +=
          whole.L.A != split.L.A || whole.L.rgb != split.L.rgb || whole.count.samples != split.count.samples;
    }
  }
  EXPECT_EQ(different, 0);
  EXPECT_GT(marched, 400);
}

TEST(March, SplitsChangeNoBitWithSmoothMaps) { expectSameBits<float>(MapShape::Smooth); }
TEST(March, SplitsChangeNoBitWithSpikyMaps) { expectSameBits<float>(MapShape::Spiky); }
TEST(March, SplitsChangeNoBitWithSteppedMaps) { expectSameBits<float>(MapShape::Stepped); }
TEST(March, SplitsChangeNoBitWithNearlyOpaqueMaps) { expectSameBits<float>(MapShape::NearlyOpaque); }
TEST(March, EndsWhereSegmentsAreShorterThanFloatResolves) {
  const Field f = sampled(gridOf({1 << 17, 2, 2}, {1, 0.3, 0.3}), [](glm::dvec3) { return 0.5; });
  const OpacityMap map{true, {{0, 0.7}}};
  Shown shown;
  shown.map = CompiledMap({{{0, glm::dvec3(1)}}}, &map, {});
  shown.plan = evenPlan(f, planOf(256, Integrator::Midpoint));
  const View<float> view(f, shown);
  const auto ray = rayIn(view, {{3 * f.grid.origin.x, 0, 0}, {1, 0, 0}});
  ASSERT_LT(ray.t0, ray.t1);
  ASSERT_EQ(ray.t0 + 1 / (256 * ray.cells), ray.t0);
  EXPECT_NEAR(march<float>(view, ray).L.A, -std::expm1(-0.7 * double(ray.t1 - ray.t0)), 1e-3);
}

TEST(March, SplitsChangeNoBitInTheTwin) { expectSameBits<double>(MapShape::Smooth); }

}  // namespace
}  // namespace gxy::test
