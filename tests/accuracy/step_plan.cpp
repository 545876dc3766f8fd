// SPDX-License-Identifier: Apache-2.0
// The plan of segments keeps the error that was asked for, early termination included.
#include "gxy/rays/step_plan.h"

#include <gtest/gtest.h>

#include "reference_march.h"

namespace gxy::test {
namespace {

struct Cost {
  double worst = 0, samples = 0;  // worst: error over tolerance; samples: per cell
  int rays = 0;
  int over = 0;   // with an error beyond the tolerance
  int flips = 0;  // of these: grazing, a hundredth of a cell aside the true result differs by as much
};

// Whether the result of a ray jumps by more than the tolerance within a hundredth of a cell: it grazes a step of the map.
bool grazes(const Field& f, const CompiledMap& map, const IndexRay& r, const Picture& here,
            double tolerance) {
  for (int axis = 0; axis < 3; axis++) {
    for (double side : {-0.01, 0.01}) {
      IndexRay moved = r;
      moved.o[axis] += side;
      if (difference(referenceMarch(f, moved, map), here) > tolerance) return true;
    }
  }
  return false;
}

Cost costOf(const Field& f, const CompiledMap& map, double tolerance, uint64_t seed, int rays) {
  Shown shown;
  shown.map = map;
  shown.plan = stepPlan(f.macrocells(), map, f.longestCell(), tolerance, 0);
  const View<float> view(f, shown);
  Random random(seed);
  Cost c;
  double cells = 0;
  for (int i = 0; i < rays; i++) {
    const auto ray = rayIn(view, randomRay(random, f));
    if (!(ray.t0 < ray.t1)) continue;
    const auto m = march<float>(view, ray, float(tolerance / 4));
    const Picture truth = referenceMarch(f, indexRay(ray, f), map, tolerance > 1e-3 ? 24 : 64);
    const double error = difference(m.L, truth) / tolerance;
    c.worst = std::max(c.worst, error);
    c.rays++;
    if (error > 1) {
      c.over++;
      c.flips += grazes(f, map, indexRay(ray, f), truth, tolerance);
    }
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
      Cost all;
      for (int i = 0; i < maps; i++) {
        const Cost c = costOf(*f, compiled(randomMaps(random, shape), *f), tolerance, uint64_t(i), rays);
        all.worst = std::max(all.worst, c.worst);
        all.samples += c.samples / maps;
        all.rays += c.rays;
        all.over += c.over;
        all.flips += c.flips;
      }
      EXPECT_LE(all.over - all.flips, all.rays / 1000) << nameOf(shape) << " tolerance 1/" << 1 / tolerance;
      EXPECT_LE(all.flips, tolerance > 1e-3 ? all.rays / 100 : all.rays / 50)
          << nameOf(shape) << " tolerance 1/" << 1 / tolerance;
      const std::string key =
          std::string(f == &lobb() ? "lobb" : "turbulent") + std::to_string(int(1 / tolerance));
      testing::Test::RecordProperty(key + "SamplesPerCell", std::to_string(all.samples));
      testing::Test::RecordProperty(key + "Worst", std::to_string(all.worst));
    }
  }
}

TEST(StepPlan, SmoothMapsStayWithinTheTolerance) { expectTolerance(MapShape::Smooth, 6, 400); }
TEST(StepPlan, SpikyMapsStayWithinTheTolerance) { expectTolerance(MapShape::Spiky, 6, 400); }
TEST(StepPlan, SteppedMapsStayWithinTheTolerance) { expectTolerance(MapShape::Stepped, 6, 400); }
TEST(StepPlan, NearlyOpaqueMapsStayWithinTheTolerance) { expectTolerance(MapShape::NearlyOpaque, 6, 400); }
TEST(StepPlan, NearlyTransparentMapsStayWithinTheTolerance) {
  expectTolerance(MapShape::NearlyTransparent, 6, 400);
}

}  // namespace
}  // namespace gxy::test
