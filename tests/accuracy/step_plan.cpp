// SPDX-License-Identifier: Apache-2.0
// The plan of segments keeps the error that was asked for, early termination included.
#include "gxy/rays/step_plan.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "reference_march.h"

namespace gxy::test {
namespace {

struct Cost {
  double worst = 0, samples = 0, macrocells = 0;  // worst: error over tolerance
};

Cost costOf(const Field& f, const CompiledMap& map, double tolerance, uint64_t seed, int rays) {
  Shown shown;
  shown.map = map;
  shown.plan = stepPlan(f.macrocells(), map, f.longestCell(), tolerance, false);
  const View<float> view(f, shown);
  Random random(seed);
  Cost c;
  double cells = 0;
  for (int i = 0; i < rays; i++) {
    const auto ray = rayIn(view, randomRay(random, f));
    if (!(ray.t0 < ray.t1)) continue;
    const auto m = march<float>(view, ray, float(tolerance / 4));
    c.worst = std::max(c.worst, difference(m.L, referenceMarch(f, indexRay(ray, f), map)) / tolerance);
    c.samples += m.count.samples;
    cells += (ray.t1 - ray.t0) * ray.cells;
  }
  c.samples /= cells;
  return c;
}

const Field& turbulent() {
  static const Field f = cube(33, turbulence);
  return f;
}
const Field& lobb() {
  static const Field f = cube(41, marschnerLobb);
  return f;
}

void expectTolerance(MapShape shape, int maps, int rays) {
  for (const double tolerance : {1 / 128.0, 1 / 512.0, 1 / 4096.0}) {
    for (const Field* f : {&turbulent(), &lobb()}) {
      Random random(81 + uint64_t(shape));
      double worst = 0, samples = 0, median = 0;
      std::vector<double> all;
      for (int i = 0; i < maps; i++) {
        const Cost c = costOf(*f, compiled(randomMaps(random, shape), *f), tolerance, uint64_t(i), rays);
        EXPECT_LE(c.worst, 1) << nameOf(shape) << " map " << i << " tolerance 1/" << 1 / tolerance;
        worst = std::max(worst, c.worst);
        samples += c.samples / maps;
        all.push_back(c.worst);
      }
      std::sort(all.begin(), all.end());
      median = all[all.size() / 2];
      std::printf("%-18s %-4s 1/%-5.0f worst %.3f median %.3f of the tolerance, %.2f samples per cell\n", nameOf(shape),
                  f == &lobb() ? "ML" : "turb", 1 / tolerance, worst, median, samples);
    }
  }
}

TEST(StepPlan, SmoothMapsStayWithinTheTolerance) { expectTolerance(MapShape::Smooth, 6, 400); }
TEST(StepPlan, SpikyMapsStayWithinTheTolerance) { expectTolerance(MapShape::Spiky, 6, 400); }
TEST(StepPlan, SteppedMapsStayWithinTheTolerance) { expectTolerance(MapShape::Stepped, 6, 400); }
TEST(StepPlan, NearlyOpaqueMapsStayWithinTheTolerance) { expectTolerance(MapShape::NearlyOpaque, 6, 400); }
TEST(StepPlan, NearlyTransparentMapsStayWithinTheTolerance) { expectTolerance(MapShape::NearlyTransparent, 6, 400); }

}  // namespace
}  // namespace gxy::test
