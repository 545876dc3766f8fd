// SPDX-License-Identifier: Apache-2.0
// What is skipped changes no bit: empty macrocells of the march, macrocells without the isovalue.
#include <gtest/gtest.h>

#include "tests/rays/maps.h"

namespace gxy::test {
namespace {

TEST(Skipping, OfTransparentMacrocellsChangesNoBit) {
  // Nothing that a sample in a skipped macrocell could add: extinction is 0 to the bit wherever the march passes it.
  Random random(91);
  int skipped = 0, tried = 0;
  for (int scene = 0; scene < 20; scene++) {
    const Index3 n{40 + random.below(30), 40 + random.below(30), 40 + random.below(30)};
    const Field f =
        sampled(gridOf(n, random.point(0.3, 1)), [](glm::dvec3 p) { return 0.7 * glm::length(p); });
    Shown on;
    on.map = compiled(randomMaps(random, scene % 2 ? MapShape::Spiky : MapShape::NearlyOpaque), f);
    on.plan = stepPlan(f.macrocells(), on.map, f.longestCell(), 1 / 512.0, 0);
    const View<float> view(f, on);
    for (int i = 0; i < 200; i++) {
      const auto ray = rayIn(view, randomRay(random, f));
      if (!(ray.t0 < ray.t1)) continue;
      auto w = startMacroWalk(*view, ray, ray.t0);
      for (float out = 0; out < ray.t1; stepMacroWalk(*view, ray, w.index, w.plane, w.far, w.t)) {
        out = std::min(single::min3(w.far), ray.t1);
        if (planAt(*view, w.index) != 0) continue;
        skipped++;
        for (int k = 0; k < 16; k++) {
          const float t = w.t + (out - w.t) * random.in(0.001, 0.999);
          const float s = sampleAt(*view, pointAt(ray.g, t));
          if (macroAt(*view, pointAt(ray.g, t)) != w.index || !(s == s)) continue;
          const auto place = mapPlace(view.map(), s);
          EXPECT_EQ(sigmaAt(mapPiece(view.map(), place.k), place.f), 0);
          tried++;
        }
      }
    }
  }
  EXPECT_GT(skipped, 1000);
  EXPECT_GT(tried, 10000);
}

// Cells have the same segments whether the macrocells before them are skipped or not.
TEST(Skipping, OfTransparentMacrocellsLeavesTheBitsOfTheOthers) {
  Random random(93);
  int skipped = 0, seen = 0;
  for (int scene = 0; scene < 20; scene++) {
    const Index3 n{40 + random.below(30), 40 + random.below(30), 40 + random.below(30)};
    const Field f =
        sampled(gridOf(n, random.point(0.3, 1)), [](glm::dvec3 p) { return 0.7 * glm::length(p); });
    Shown on, off;
    on.map = off.map = compiled(randomMaps(random, scene % 2 ? MapShape::Spiky : MapShape::NearlyOpaque), f);
    on.plan = stepPlan(f.macrocells(), on.map, f.longestCell(), 1 / 512.0, 0);
    const int32_t cells = planOf(2, Integrator::ByCells);
    for (int32_t& p : on.plan) p = p == 0 ? 0 : cells;
    off.plan = evenPlan(f, cells);
    const View<float> with(f, on), without(f, off);
    for (int i = 0; i < 200; i++) {
      const auto ray = rayIn(with, randomRay(random, f));
      if (!(ray.t0 < ray.t1)) continue;
      const auto a = march<float>(with, ray, 1e-4f), b = march<float>(without, ray, 1e-4f);
      EXPECT_EQ(a.L.A, b.L.A);
      EXPECT_EQ(a.L.rgb.x, b.L.rgb.x);
      EXPECT_EQ(a.L.rgb.y, b.L.rgb.y);
      EXPECT_EQ(a.L.rgb.z, b.L.rgb.z);
      skipped += a.count.skipped;
      seen += a.L.A > 0;
    }
  }
  EXPECT_GT(skipped, 1000);
  EXPECT_GT(seen, 500);
}

// A cell that no step of the map goes through is integrated exactly by its value at both ends, as far as that is linear.
TEST(Skipping, OfSegmentsInCellsWithoutAStepOfTheMap) {
  Random random(94);
  int fine = 0, coarse = 0, seen = 0;
  for (int scene = 0; scene < 20; scene++) {
    const Index3 n{40 + random.below(30), 40 + random.below(30), 40 + random.below(30)};
    const Field f =
        sampled(gridOf(n, random.point(0.3, 1)), [](glm::dvec3 p) { return 0.5 + 0.3 * (p.x + p.y - p.z); });
    Shown few, many;
    few.map = many.map = compiled(randomMaps(random, MapShape::Stepped), f);
    few.plan = evenPlan(f, planOf(8, Integrator::ByCells, 0.2));
    many.plan = evenPlan(f, planOf(8, Integrator::ByCells));
    const View<float> with(f, few), without(f, many);
    for (int i = 0; i < 100; i++) {
      const auto ray = rayIn(with, randomRay(random, f));
      if (!(ray.t0 < ray.t1)) continue;
      const auto a = march<float>(with, ray, 1e-4f), b = march<float>(without, ray, 1e-4f);
      EXPECT_NEAR(a.L.A, b.L.A, 2e-4);
      EXPECT_NEAR(a.L.rgb.x, b.L.rgb.x, 2e-4);
      coarse += a.count.samples;
      fine += b.count.samples;
      seen += a.L.A > 0;
    }
  }
  EXPECT_LT(3 * coarse, fine);
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
