// SPDX-License-Identifier: Apache-2.0
// A uniform field absorbs by Beer and Lambert's law, whatever the step.
#include <gtest/gtest.h>

#include "tests/rays/maps.h"

namespace gxy::test {
namespace {

struct Slab {
  Field field;
  Shown shown;
  double sigma;
};

Slab uniformSlab(Random& random, Integrator integrator) {
  const Index3 n{2 + random.below(40), 2 + random.below(100), 2 + random.below(120)};
  Slab s{
      makeField(gridOf(n, random.point(0.3, 1)), [](int64_t, int64_t, int64_t, int) { return 0.5; }), {}, 0};
  const OpacityMap map{true, {{0, random.scale(1e-4, 30)}}};
  s.shown.map = CompiledMap({{{0, glm::dvec3(1)}}}, &map, {});
  s.shown.plan = evenPlan(s.field, planOf(random.scale(0.25, 16), integrator));
  s.sigma = s.shown.map.pieces[0];  // as the kernels know it
  return s;
}

// The length in t of the part of the ray, as the view sees it, inside the grid.
template <class Ray>
double chord(const Ray& ray, const Field& f) {
  double t0 = 0, t1 = 1e30;
  const Index3 cells = f.grid.cells();
  for (int k = 0; k < 3; k++) {
    const double p = ray.g.po[k], d = ray.g.pd[k];
    if (d == 0 && (p < 0 || p >= double(cells[size_t(k)]))) return 0;
    if (d == 0) continue;
    const double a = -p / d, b = (double(cells[size_t(k)]) - p) / d;
    t0 = std::max(t0, std::min(a, b));
    t1 = std::min(t1, std::max(a, b));
  }
  return std::max(0.0, t1 - t0);
}

template <class Real>
void expectBeerLambert(double absolute, double relative) {
  Random random(11);
  int reached = 0;
  double worst = 0;
  for (int scene = 0; scene < 60; scene++) {
    const Slab s = uniformSlab(random, kIntegrators[scene % 2]);
    const View<Real> view(s.field, s.shown);
    for (int i = 0; i < 60; i++) {
      const auto ray = rayIn(view, randomRay(random, s.field));
      const double expected = -std::expm1(-s.sigma * chord(ray, s.field));
      const auto m = march<Real>(view, ray);
      const double bound = std::max(absolute, relative * expected);
      worst = std::max(worst, std::abs(double(m.L.A) - expected) / bound);
      EXPECT_NEAR(double(m.L.A), expected, bound) << "scene " << scene << " samples " << m.count.samples;
      EXPECT_NEAR(double(m.L.rgb.x), expected, bound) << "scene " << scene << " samples " << m.count.samples;
      reached += expected > 0;
    }
  }
  EXPECT_GT(reached, 2000);
  testing::Test::RecordProperty("worstOfBound", std::to_string(worst));
}

TEST(Transmittance, UniformSlabMatchesBeerLambert) { expectBeerLambert<float>(1e-6, 1e-4); }
TEST(Transmittance, UniformSlabMatchesBeerLambertInTheTwin) { expectBeerLambert<double>(1e-12, 0); }

}  // namespace
}  // namespace gxy::test
