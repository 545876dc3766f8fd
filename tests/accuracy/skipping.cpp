// SPDX-License-Identifier: Apache-2.0
// What is skipped changes no bit: empty macrocells of the march, macrocells without the isovalue.
#include <gtest/gtest.h>

#include "maps.h"

namespace gxy::test {
namespace {

TEST(Skipping, OfTransparentMacrocellsChangesNoBit) {
  Random random(91);
  int skipped = 0, seen = 0;
  for (int scene = 0; scene < 20; scene++) {
    const Index3 n{9 + random.below(30), 9 + random.below(30), 9 + random.below(30)};
    const Field f =
        sampled(gridOf(n, random.point(0.3, 1)), [](glm::dvec3 p) { return 0.7 * glm::length(p); });
    Shown on;
    on.map = compiled(randomMaps(random, scene % 2 ? MapShape::Spiky : MapShape::NearlyOpaque), f);
    on.plan = stepPlan(f.macrocells(), on.map, f.longestCell(), 1 / 512.0, 0);
    Shown off = on;
    for (int32_t& plan : off.plan)
      if (plan == 0)
        plan = planOf(scene % 4 < 2 ? 0.4 : 0.8,
                      scene % 4 < 2 ? Integrator::Midpoint : Integrator::PreIntegrated);
    const View<float> with(f, on), without(f, off);
    for (int i = 0; i < 200; i++) {
      const auto ray = rayIn(with, randomRay(random, f));
      const auto a = march<float>(with, ray), b = march<float>(without, ray);
      EXPECT_EQ(a.L.A, b.L.A);
      EXPECT_EQ(a.L.rgb, b.L.rgb);
      skipped += a.count.skipped;
      seen += a.L.A > 0;
    }
  }
  EXPECT_GT(skipped, 100);
  EXPECT_GT(seen, 500);
}

TEST(Skipping, OfMacrocellsWithoutTheIsovalueChangesNoBit) {
  Random random(92);
  int skipped = 0, hits = 0;
  for (int scene = 0; scene < 20; scene++) {
    const Index3 n{9 + random.below(30), 9 + random.below(30), 9 + random.below(30)};
    const Field f =
        sampled(gridOf(n, random.point(0.3, 1)), [](glm::dvec3 p) { return 0.7 * glm::length(p); });
    Shown on;
    on.isovalues = {float(random.in(0.2, 0.6)), 0.55f};
    Shown off = on;
    off.isoEverywhere = true;
    const View<float> with(f, on), without(f, off);
    for (int i = 0; i < 200; i++) {
      const auto ray = rayIn(with, randomRay(random, f));
      int cells = 0, passed = 0, none = 0;
      const auto a = firstIsosurface(*with, ray, 0.f, 1e30f, -1.f, {-1, 0}, cells, passed);
      const auto b = firstIsosurface(*without, ray, 0.f, 1e30f, -1.f, {-1, 0}, cells, none);
      EXPECT_EQ(a.t, b.t);
      EXPECT_EQ(a.index, b.index);
      EXPECT_EQ(none, 0);
      skipped += passed;
      hits += a.index >= 0;
    }
  }
  EXPECT_GT(skipped, 1000);
  EXPECT_GT(hits, 500);
}

}  // namespace
}  // namespace gxy::test
