// SPDX-License-Identifier: Apache-2.0
// Orders of convergence (Etiene et al. 2014): the error's slope over halved steps and halved spacings.
#include <gtest/gtest.h>

#include "reference_march.h"

namespace gxy::test {
namespace {

// The median over rays of the difference from the reference at that rate (segments per cell): rays that graze a step of
// the map converge more slowly.
double marchError(const Field& f, const CompiledMap& map, double rate, Integrator integrator) {
  Shown shown;
  shown.map = map;
  shown.plan = evenPlan(f, planOf(rate, integrator));
  const View<double> view(f, shown);
  Random random(61);
  std::vector<double> errors;
  constexpr int kRays = 301;
  for (int i = 0; i < kRays; i++) {
    const auto ray = rayIn(view, randomRay(random, f));
    errors.push_back(difference(march<double>(view, ray).L, referenceMarch(f, indexRay(ray, f), map, 64)));
  }
  std::nth_element(errors.begin(), errors.begin() + kRays / 2, errors.end());
  return errors[kRays / 2];
}

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

double orderOfPieces(const Field& f) {
  const CompiledMap map = compiled(kStepped, f);
  std::vector<double> errors;
  for (double rate : {1.0, 2.0, 4.0, 8.0, 16.0})
    errors.push_back(marchError(f, map, rate, Integrator::PreIntegrated));
  return fittedOrder(errors);
}

TEST(Convergence, PiecesHaveAnOrderBeyondOneAndAHalfOnSteppedMaps) {
  EXPECT_GE(orderOfPieces(cube(12,
                               [](glm::dvec3 p) {
                                 return 0.5 + 0.2 * p.x + 0.15 * p.y * p.z - 0.2 * p.z * p.x +
                                        0.25 * p.x * p.y * p.z;  // no kink between cells
                               })),
            1.6);
}

TEST(Convergence, PiecesKeepTheirOrderWhereTheFieldKinksBetweenCells) {
  EXPECT_GE(orderOfPieces(cube(
                12, [](glm::dvec3 p) { return 0.5 + 0.4 * std::sin(2 * p.x + p.y) * std::cos(2 * p.z); })),
            1.6);
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
