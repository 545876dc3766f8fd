// SPDX-License-Identifier: Apache-2.0
// The plan of segments keeps the error that was asked for, early termination included.
#include "core/rays/step_plan.h"

#include <gtest/gtest.h>

#include "tests/rays/reference_march.h"
#include "tests/support/seeds.h"

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
    const auto m = march<float>(view, ray, float(tolerance * kEarlyEnd));
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

/// `grazing`: rays for which a hundredth of a cell matters as much may miss the tolerance. `colors`: points of the colour map, or
/// some.
void expectTolerance(MapShape shape, int maps, int rays, bool grazing = true, int colors = 0) {
  for (const double tolerance : {1 / 128.0, 1 / 512.0, 1 / 4096.0}) {
    for (const Field* f : {&turbulent(), &lobb()}) {
      Random random(81 + uint64_t(shape));
      Cost all;
      for (int i = 0; i < maps; i++) {
        Maps m = randomMaps(random, shape);
        if (colors > 0) m.color = randomColors(random, colors);
        const Cost c = costOf(*f, compiled(m, *f), tolerance, uint64_t(i), sweep(rays));
        all.worst = std::max(all.worst, c.worst);
        all.samples += c.samples / maps;
        all.rays += c.rays;
        all.over += c.over;
        all.flips += c.flips;
      }
      const std::string where = nameOf(shape) + (" tolerance 1/" + std::to_string(1 / tolerance));
      EXPECT_LE(all.over - (grazing ? all.flips : 0), all.rays / 1000) << where;
      EXPECT_LE(all.flips, tolerance > 1e-3 ? all.rays / 100 : all.rays / 50) << where;
      const std::string key =
          std::string(f == &lobb() ? "lobb" : "turbulent") + std::to_string(int(1 / tolerance));
      testing::Test::RecordProperty(key + "SamplesPerCell", std::to_string(all.samples));
      testing::Test::RecordProperty(key + "Worst", std::to_string(all.worst));
    }
  }
}

TEST(StepPlan, SmoothMapsStayWithinTheTolerance) { expectTolerance(MapShape::Smooth, 6, 400); }
TEST(StepPlan, SpikyMapsStayWithinTheTolerance) { expectTolerance(MapShape::Spiky, 6, 400); }
TEST(StepPlan, SteppedMapsStayWithinTheTolerance) { expectTolerance(MapShape::Stepped, 6, 400, false); }
TEST(StepPlan, SteppedMapsOfManyIntervalsStayWithinTheTolerance) {
  expectTolerance(MapShape::Stepped, 2, 400, false, 40);
}
TEST(StepPlan, NearlyOpaqueMapsStayWithinTheTolerance) { expectTolerance(MapShape::NearlyOpaque, 6, 400); }
TEST(StepPlan, NearlyTransparentMapsStayWithinTheTolerance) {
  expectTolerance(MapShape::NearlyTransparent, 6, 400);
}

/// Largest error over rays, in tolerances of 1/512.
double worstOf(const Field& f, const Maps& maps, int rays) {
  return costOf(f, compiled(maps, f), 1 / 512.0, 91, rays).worst;
}
double ramp(glm::dvec3 p) { return 0.5 + 0.5 * p.x; }

// What is dense at a step of the map is what is seen there.
TEST(StepPlan, AStepOfColourAtAnOpaqueStepShowsTheDenseSide) {
  const Maps m{{{{0, {0, 0, 1}}, {0.503, {0, 0, 1}}, {0.503, {1, 0, 0}}, {1, {1, 0, 0}}}},
               {false, {{0, 0}, {0.503, 0}, {0.503, 1}, {1, 1}}}};
  for (int64_t n : {9, 17, 33}) EXPECT_LE(worstOf(cube(n, ramp), m, 200), 1) << n;
}

// Categories: the colour has steps, the opacity none.
TEST(StepPlan, StepsOfColourStayWithinTheTolerance) {
  const glm::dvec3 red{1, 0, 0}, green{0, 1, 0}, blue{0, 0, 1};
  const ColorMap categories{
      {{0, blue}, {0.4, blue}, {0.4, red}, {0.5, red}, {0.5, green}, {0.6, green}, {0.6, blue}}};
  for (const Field* f : {&turbulent(), &lobb()}) {
    const double perCell = 0.2 / f->shortestCell();
    const Maps m{categories, {true, {{0, 0}, {0.3, 0}, {1, perCell}}}};
    const Cost c = costOf(*f, compiled(m, *f), 1 / 512.0, 93, 2000);
    EXPECT_LE(c.over, c.rays / 1000) << c.worst;
  }
}

// However high a peak is, its depth is that of the part of a segment which it takes.
TEST(StepPlan, NarrowPeaksHaveTheirDepth) {
  const Field cells = cube(17, [](glm::dvec3 p) { return p.x < 0.001 ? 0.0 : 1.0; });
  const double L = cells.shortestCell();
  for (double width : {1e-4, 2e-4}) {
    const Maps m{{{{0, {1, 1, 1}}}}, {true, {{0.5 - width, 0}, {0.5, 0.5 / (width * L)}, {0.5 + width, 0}}}};
    Random random(92);
    Shown shown;
    shown.map = compiled(m, cells);
    shown.plan = stepPlan(cells.macrocells(), shown.map, cells.longestCell(), 1 / 512.0, 0);
    const View<float> view(cells, shown);
    for (int i = 0; i < 20; i++) {
      const RaySpec along{{-1, random.in(-0.4, 0.4), random.in(-0.4, 0.4)}, {1, 0, 0}};
      // float resolves the edges of the peak to 3e-4 of its width
      EXPECT_NEAR(march<float>(view, rayIn(view, along)).L.A, 1 - std::exp(-0.5), 1e-3) << width;
    }
  }
}

TEST(StepPlan, NoDataBehindTheFaceOfAMacrocellHidesNothingBeforeIt) {
  const Maps m{{{{0, {1, 0, 0}}, {1, {0, 0, 1}}}},
               {false, {{0, 0}, {0.3, 0}, {0.32, 0.3}, {0.34, 0}, {0.6, 0}, {0.62, 0.3}, {0.64, 0}, {1, 0}}}};
  for (int64_t missing : {9, 15}) {
    const Field f = makeField(gridOf({25, 25, 25}), [&](int64_t i, int64_t j, int64_t k, int) {
      return i == missing
                 ? std::nan("")
                 : 0.5 + 0.4 * std::sin(0.3 * double(i) + 0.2 * double(j)) * std::cos(0.25 * double(k));
    });
    EXPECT_LE(worstOf(f, m, 400), 1) << missing;
  }
}

// Extinction times colour is curved where both are linear, and the front of a segment hides its back.
TEST(StepPlan, LinearFieldsUnderLinearMapsStayWithinTheTolerance) {
  for (int64_t n : {2, 3, 5, 9, 17, 33}) {
    const Field f = cube(n, ramp);
    const double L = f.shortestCell();
    for (double first : {0.0, 0.055}) {
      const Maps m{{{{0, {0, 0, 0}}, {1, {1, 1, 1}}}}, {true, {{0, first / L}, {1, 0.055 / L}}}};
      EXPECT_LE(worstOf(f, m, 200), 1) << n << " from " << first;
    }
  }
}

// A kink of the map is as sharp in a dense part as in a thin one, and shows less.
TEST(StepPlan, KinksInDensePartsTakeFewerSegments) {
  const double L = 1 / 32.0;
  auto lengthOver = [&](double first, double last) {
    const OpacityMap extinction{true, {{0, first / L}, {0.6, first / L}, {1, last / L}}};
    const CompiledMap map({{{0, {1, 1, 1}}}}, &extinction, MapUnits{0, 1, 1, L});
    const std::vector<Macrocell> range{{0.5f, 0.7f, 0.15f, 0, false}};
    return double(single::planStep(stepPlan(range, map, L, 1 / 512.0, 0)[0]));
  };
  EXPECT_GT(lengthOver(3, 4), 1.4 * lengthOver(0, 1));
}

TEST(StepPlan, KinksOfColourInDensePartsStayWithinTheTolerance) {
  expectTolerance(MapShape::NearlyOpaque, 4, 400, true, 30);
}

}  // namespace
}  // namespace gxy::test
