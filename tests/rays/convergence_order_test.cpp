// SPDX-License-Identifier: Apache-2.0
// Orders of convergence (Etiene et al. 2014): the error's slope over halved steps and halved spacings.
#include <gtest/gtest.h>

#include "tests/rays/reference_march.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

// The median over rays of the difference from the reference at that rate (segments per cell): rays that graze a step of
// the map converge more slowly.
double marchError(const Field& f, const CompiledMap& map, double rate, Integrator integrator,
                  int perCell = 64) {
  Shown shown;
  shown.map = map;
  shown.plan = evenPlan(f, planOf(rate, integrator));
  const View<double> view(f, shown);
  Random random(61);
  std::vector<double> errors;
  constexpr int kRays = std::max(501, sweep(1001));  // of fewer the median is too uncertain
  for (int i = 0; i < kRays; i++) {
    const auto ray = rayIn(view, randomRay(random, f));
    errors.push_back(
        difference(march<double>(view, ray).L, referenceMarch(f, indexRay(ray, f), map, perCell)));
  }
  std::nth_element(errors.begin(), errors.begin() + kRays / 2, errors.end());
  return errors[kRays / 2];
}

/// From the first to the last, each half the step or spacing of the one before.
double fittedOrder(const std::vector<double>& errors) {
  return std::log2(errors.front() / errors.back()) / double(errors.size() - 1);
}

TEST(Convergence, MidpointSegmentsAreOfSecondOrderOnSmoothMaps) {
  const Field f =
      cube(24, [](glm::dvec3 p) { return 0.5 + 0.4 * std::sin(2 * p.x + p.y) * std::cos(2 * p.z); });
  const Maps m{{{{0, {1, 0, 0}}, {1, {0, 1, 0.5}}}}, {true, {{-1, 0}, {2, 6}}}};
  const CompiledMap map = compiled(m, f);
  std::vector<double> errors;
  for (double rate : {1.0, 2.0, 4.0, 8.0}) errors.push_back(marchError(f, map, rate, Integrator::Midpoint));
  EXPECT_GE(fittedOrder(errors), 1.9) << errors.front() << " to " << errors.back();
}

const Maps kStepped{{{{0, {1, 0, 0}}, {1, {0, 1, 0.5}}}},
                    {true, {{0, 0.1}, {0.45, 0.1}, {0.45, 0.6}, {0.6, 0.2}, {0.6, 0}, {1, 0}}}};
const Maps kSmooth{{{{-1, {1, 0, 0}}, {2, {0, 1, 0.5}}}}, {true, {{-1, 0}, {2, 3}}}};

/// The same with as many intervals as are integrated by antiderivatives: more than MAP_SMALL.
Maps withManyIntervals(const Maps& few) {
  Maps many = few;
  auto& points = many.opacity.points;
  for (int i = 0; i <= 40; i++) {
    const double v = i / 40.0, bump = 0.3 * v * (1 - v);
    const auto next = std::upper_bound(few.opacity.points.begin(), few.opacity.points.end(), v,
                                       [](double x, const OpacityPoint& p) { return x < p.value; });
    if (next == few.opacity.points.begin() || next == few.opacity.points.end()) continue;
    const OpacityPoint &a = *(next - 1), &b = *next;
    if (v == a.value) continue;
    points.push_back({v, a.opacity + (b.opacity - a.opacity) * (v - a.value) / (b.value - a.value) + bump});
  }
  std::stable_sort(points.begin(), points.end(),
                   [](const OpacityPoint& a, const OpacityPoint& b) { return a.value < b.value; });
  return many;
}
const Maps kManySmooth = withManyIntervals(kSmooth), kManyStepped = withManyIntervals(kStepped);

double waving(glm::dvec3 p) { return 0.5 + 0.4 * std::sin(2 * p.x + p.y) * std::cos(2 * p.z); }
/// One trilinear function: no kink between cells.
double trilinearEverywhere(glm::dvec3 p) {
  return 0.5 + 0.2 * p.x + 0.15 * p.y * p.z - 0.2 * p.z * p.x + 0.25 * p.x * p.y * p.z;
}

/// Over four halvings from `first` segments a cell on.
double orderOfPieces(const Field& f, const Maps& maps, double first) {
  const CompiledMap map = compiled(maps, f);
  std::vector<double> errors;
  for (double rate = first; rate <= 16 * first; rate *= 2)
    errors.push_back(marchError(f, map, rate, Integrator::ByCells, int(32 * first)));
  const double order = fittedOrder(errors);
  testing::Test::RecordProperty("order", std::to_string(order));
  return order;
}

TEST(Convergence, PiecesAreOfSecondOrderOnSmoothMapsInOneMacrocell) {
  EXPECT_GE(orderOfPieces(cube(9, waving), kSmooth, 4), 1.9);
}

TEST(Convergence, PiecesAreOfSecondOrderOnSteppedMapsInOneMacrocell) {
  EXPECT_GE(orderOfPieces(cube(9, trilinearEverywhere), kStepped, 4), 1.9);
}

// Antiderivatives in place of the cubic's roots. Longer segments that bow at a step are halved, so that errors of
// the longest are less than the order says.
TEST(Convergence, PiecesUnderMapsOfManyIntervalsAreOfSecondOrder) {
  const Field f = cube(9, trilinearEverywhere);
  for (const auto& [maps, first] : {std::pair(&kManySmooth, 4), std::pair(&kManyStepped, 8)}) {
    EXPECT_GT(compiled(*maps, f).intervals(), MAP_SMALL);
    EXPECT_GE(orderOfPieces(f, *maps, first), 1.9);
  }
}

TEST(Convergence, PiecesKeepTheirOrderWhereTheFieldKinksBetweenCells) {
  EXPECT_GE(orderOfPieces(cube(12, waving), kStepped, 8), 1.9);
}

// Not the design's 2 - 0.1: segments are whole numbers of a cell's chord, and a ray that cuts a corner takes one of them at
// rates 1, 2 and 4 alike, so that nominal halving does not halve its steps (docs/numerics.md). From 4 on the order is 2, above.
TEST(Convergence, PiecesHaveAnOrderBeyondOneAndAHalfFromOneSegmentACellOn) {
  EXPECT_GE(orderOfPieces(cube(12, trilinearEverywhere), kStepped, 1), 1.6);
}

/// What the kernels' twin sees along a ray with segments so short that they do not matter.
Picture fine(const View<double>& view, const RaySpec& spec) {
  const auto L = march<double>(view, rayIn(view, spec)).L;
  return {L.rgb, L.A};
}

const std::pair<const Maps*, Integrator> kMethods[] = {
    {&kSmooth, Integrator::Midpoint}, {&kSmooth, Integrator::ByCells}, {&kManySmooth, Integrator::ByCells}};

TEST(Convergence, ThePictureIsOfSecondOrderInTheSpacing) {
  const auto function = [](glm::dvec3 p) {
    return 0.5 + 0.4 * std::sin(3 * p.x + p.y) * std::cos(2 * p.z - p.y);
  };
  for (const auto& [maps, integrator] : kMethods) {
    // one map for all spacings: opacity of one length
    const CompiledMap map(maps->color, &maps->opacity, MapUnits{0, 1, 1, 1});
    std::vector<double> errors;
    for (int n : {9, 17, 33, 65}) {
      const Field f = cube(n, function);
      Shown shown;
      shown.map = map;
      shown.plan = evenPlan(f, planOf(16 * 64 / (n - 1), integrator));
      const View<double> view(f, shown);
      Random random(63);
      double sum = 0;
      for (int i = 0; i < 150; i++) {
        const glm::dvec3 d = random.direction(), o = random.point(-0.2, 0.2) - 1.5 * d;
        const IndexRay r = indexRay(rayIn(view, {o, d}), f);
        Picture exact;
        const int pieces = 4096;
        const double step = (r.t1 - r.t0) / pieces;
        for (int k = 0; k < pieces; k++) {
          const glm::dvec3 p = f.grid.origin + f.grid.spacing * (r.o + (r.t0 + (k + 0.5) * step) * r.d);
          const double s = function(2.0 * p);
          addPiece(map, s, s, step, exact);
        }
        const double e = difference(exact, fine(view, {o, d}));
        sum += e * e;
      }
      errors.push_back(std::sqrt(sum / 150));
    }
    EXPECT_GE(fittedOrder(errors), 1.9)
        << int(integrator) << ": " << errors.front() << " to " << errors.back();
  }
}

TEST(Convergence, ThePictureIsOfSecondOrderInThePixels) {
  // A pixel between two others is their mean, up to the square of their distance (Etiene et al., section 5.3).
  const Field f = cube(9, trilinearEverywhere);
  for (const auto& [maps, integrator] : kMethods) {
    Shown shown;
    shown.map = compiled(*maps, f);
    shown.plan = evenPlan(f, planOf(256, integrator));
    const View<double> view(f, shown);
    std::vector<double> errors;
    for (double pixel : {1.0 / 16, 1.0 / 32, 1.0 / 64}) {
      Random random(64);
      double sum = 0;
      for (int i = 0; i < 60; i++) {
        // towards one face, away from its border: all rays cross the same two faces of the box
        const double x = random.in(-0.2, 0.2), y = random.in(-0.2, 0.2);
        auto at = [&](double shift) { return fine(view, {{x + shift, y, -2}, {0.01, 0.02, 1}}); };
        const Picture a = at(-pixel), b = at(0), c = at(pixel);
        const double e = difference(Picture{0.5 * (a.rgb + c.rgb), 0.5 * (a.A + c.A)}, b);
        sum += e * e;
      }
      errors.push_back(std::sqrt(sum / 60));
    }
    EXPECT_GE(fittedOrder(errors), 1.9)
        << int(integrator) << ": " << errors.front() << " to " << errors.back();
  }
}

TEST(Convergence, TheFieldIsOfSecondOrderInTheSpacing) {
  const auto function = [](glm::dvec3 p) { return std::sin(3 * p.x + p.y) * std::cos(2 * p.z - p.y); };
  std::vector<double> errors;
  for (int n : {9, 17, 33, 65}) {
    const Field f = cube(n, function);
    Shown shown;
    shown.plan = evenPlan(f, 0);
    const View<double> view(f, shown);
    Random random(62);
    double sum = 0;
    for (int i = 0; i < 4000; i++) {
      const glm::dvec3 p = random.point(0, n - 1);
      const double d = sampleAt(*view, p) - function(2.0 * (f.grid.origin + f.grid.spacing * p));
      sum += d * d;
    }
    errors.push_back(std::sqrt(sum / 4000));
  }
  EXPECT_GE(fittedOrder(errors), 1.9);
}

}  // namespace
}  // namespace gxy::test
