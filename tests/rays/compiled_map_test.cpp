// SPDX-License-Identifier: Apache-2.0
// Maps as the kernels evaluate them, against their definition in double.
#include "tests/rays/maps.h"

#include <gtest/gtest.h>

#include "core/scene/colormaps.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

// Up to 12 points anywhere in [0, 1], some at one value (a step, or a peak of no width), some only one.
Maps wildMaps(Random& random) {
  Maps m;
  auto values = [&] {
    std::vector<double> v;
    for (int n = 1 + random.below(6); n > 0; n--) {
      v.push_back(random.unit());
      for (int same = random.below(4) == 0 ? 1 + random.below(2) : 0; same > 0; same--) v.push_back(v.back());
    }
    std::sort(v.begin(), v.end());
    return v;
  };
  for (double v : values()) m.color.points.push_back({v, random.point(0, 1)});
  for (double v : values())
    m.opacity.points.push_back({v, random.below(5) ? random.in(0, 0.95) : double(random.below(2))});
  m.opacity.extinction = random.below(4) == 0;
  return m;
}

// The smallest distance to a control point.
double clearance(const Maps& m, double v) {
  double d = 1;
  for (const auto& p : m.color.points) d = std::min(d, std::abs(p.value - v));
  for (const auto& p : m.opacity.points) d = std::min(d, std::abs(p.value - v));
  return d;
}

Field anyField() {
  return makeField(gridOf({2, 2, 2}), [](int64_t, int64_t, int64_t, int) { return 0.5; });
}

template <class Real>
void expectDefinition(double rounding) {
  Random random(51);
  const Field f = anyField();
  double worst = 0;
  for (int i = 0; i < 400; i++) {
    const Maps m = wildMaps(random);
    const double perT = 50;
    Shown shown;
    shown.map = CompiledMap(m.color, &m.opacity, MapUnits{0, 1, 2, 2 / perT});
    shown.plan = evenPlan(f, 0);
    const View<Real> view(f, shown);
    for (int k = 0; k < 100; k++) {
      const double v = double(float(random.in(-0.5, 1.5)));
      if (clearance(m, v) < 1e-3) continue;
      const double x = evaluate(m.opacity, v);
      if (!m.opacity.extinction && x > 1 - 1e-4 && x < 1) continue;
      const auto p = mapPlace(view.map(), Real(v));
      const auto piece = mapPiece(view.map(), p.k);
      const double sigma = double(sigmaAt(piece, p.f));
      if (m.opacity.extinction)
        EXPECT_NEAR(sigma, 2 * x, rounding * 2) << v;
      else if (x == 1)
        EXPECT_GE(sigma, 1e10);
      else {
        const double expected = -std::log1p(-x) * perT;
        worst = std::max(worst, std::abs(sigma - expected) / (expected + rounding * perT));
        // steep parts move with the rounding of their nodes
        EXPECT_NEAR(sigma, expected, 2e-4 * expected + 10 * rounding * perT / (1 - x)) << v;
      }
      const auto c = colorAt(piece, p.f);
      const glm::dvec3 rgb = evaluate(m.color, v);
      for (int a = 0; a < 3; a++) EXPECT_NEAR(double(c[a]), rgb[a], 10 * rounding) << v;
    }
  }
  testing::Test::RecordProperty("worstRelative", std::to_string(worst));
}

TEST(Maps, KernelsEvaluateTheDefinition) { expectDefinition<float>(1e-4); }
TEST(Maps, KernelsEvaluateTheDefinitionInTheTwin) { expectDefinition<double>(1e-4); }

TEST(Maps, EvenMapsOf256PointsNeedNoSearch) {
  Random random(52);
  const Maps m{randomColors(random, 256), OpacityMap{true, {{0, 1}}}};
  Shown shown;
  shown.map = CompiledMap(m.color, &m.opacity, {});
  EXPECT_EQ(shown.map.uniform, 255);
  const Field f = anyField();
  shown.plan = evenPlan(f, 0);
  const View<float> view(f, shown);
  for (int k = 0; k < 20000; k++) {
    const float v = float(random.in(-0.2, 1.2));
    const auto c = colorOf(view.map(), v);
    const glm::dvec3 rgb = evaluate(m.color, v);
    for (int a = 0; a < 3; a++) EXPECT_NEAR(double(c[a]), rgb[a], 1e-4) << v;
  }
}

// An interval of a map holds what begins at its first node, for labels too.
TEST(Maps, AValueAtAStepIsAboveIt) {
  const Field f = anyField();
  for (double spacing : {1.0, 41.0, 0.1}) {
    Maps m{{}, {true, {}}};
    for (int label = 1; label <= 40; label++) {
      const double v = double(float(spacing * label));
      m.color.points.push_back({v, glm::dvec3(label / 41.0)});
      for (int side : {-1, 0}) m.opacity.points.push_back({v, double(label + side)});
    }
    Shown shown;
    shown.map = CompiledMap(m.color, &m.opacity, {});
    shown.plan = evenPlan(f, 0);
    const View<float> view(f, shown);
    for (int label = 1; label <= 40; label++) {
      const auto p = mapPlace(view.map(), float(spacing * label));
      EXPECT_FLOAT_EQ(sigmaAt(mapPiece(view.map(), p.k), p.f), float(label)) << spacing;
    }
  }
}

// What lies closer than normal numbers do is one node: an interval between would have no length to divide by.
TEST(Maps, NodesThatFloatHardlyTellApartLeaveNumbers) {
  const Field f = anyField();
  Shown shown;
  const OpacityMap opacity{true, {{0, 1}, {1e-40, 2}}};
  shown.map = CompiledMap(ColorMap{{{0, {0, 0, 0}}, {1e-40, {1, 1, 1}}}}, &opacity, {});
  shown.plan = evenPlan(f, 0);
  const View<float> view(f, shown);
  for (float v : {-1.f, 0.f, 5e-41f, 1e-40f, 1.f}) {
    const auto p = mapPlace(view.map(), v);
    EXPECT_TRUE(std::isfinite(sigmaAt(mapPiece(view.map(), p.k), p.f))) << v;
    EXPECT_TRUE(std::isfinite(colorOf(view.map(), v).x)) << v;
  }
}

// Behind a dense plateau the sums are large: what is faint there is the difference of two that are alike.
TEST(Maps, MeansOfFaintPartsBehindDenseOnesKeepTheirDigits) {
  Random random(54);
  const Field f = anyField();
  for (double plateau : {1000.0, 5000.0}) {
    for (int parts : {64, 256}) {
      Maps m{{{{0, {0.9, 0.9, 0.9}}, {1, {0.1, 0.1, 0.1}}}}, {true, {{0, plateau}, {0.5, plateau}}}};
      for (int i = 0; i <= parts / 2; i++)
        m.opacity.points.push_back({0.5 + double(i) / parts, random.in(0.002, 0.02)});
      Shown shown;
      shown.map = CompiledMap(m.color, &m.opacity, {});
      shown.plan = evenPlan(f, 0);
      const View<float> view(f, shown);
      for (int k = 0; k < 100; k++) {
        const double s0 = double(float(random.in(0.51, 0.9))), s1 = double(float(s0 + 2.5 / parts));
        double sigma = 0, source = 0;
        constexpr int kSteps = 4000;
        for (int n = 0; n < kSteps; n++) {
          const double v = s0 + (s1 - s0) * (n + 0.5) / kSteps;
          sigma += evaluate(m.opacity, v) / kSteps;
          source += evaluate(m.opacity, v) * evaluate(m.color, v).x / kSteps;
        }
        const auto mean = meanAlong(view.map(), float(s0), float(s1));
        EXPECT_NEAR(double(mean.sigma), sigma, 2e-3 * sigma) << plateau;
        EXPECT_NEAR(double(mean.sigma * mean.color.x), source, 2e-3 * sigma) << plateau;
      }
    }
  }
}

TEST(Maps, MeanAlongIsTheIntegralOverTheValues) {
  Random random(53);
  const Field f = anyField();
  for (int i = 0; i < sweep(150); i++) {
    const Maps m = wildMaps(random);
    if (!m.opacity.extinction &&
        std::any_of(m.opacity.points.begin(), m.opacity.points.end(), [](auto& p) { return p.opacity == 1; }))
      continue;
    Shown shown;
    shown.map = CompiledMap(m.color, &m.opacity, {});
    shown.plan = evenPlan(f, 0);
    const View<float> single(f, shown);
    const View<double> twin(f, shown);
    for (int k = 0; k < 20; k++) {
      const double s0 = double(float(random.in(-0.2, 1.2))),
                   s1 = double(float(random.below(2) ? random.in(-0.2, 1.2) : s0 + random.in(-0.02, 0.02)));
      double sigma = 0, source = 0;
      constexpr int kParts = 20000;
      for (int n = 0; n < kParts; n++) {
        const auto p = mapPlace(twin.map(), s0 + (s1 - s0) * (n + 0.5) / kParts);
        const auto piece = mapPiece(twin.map(), p.k);
        sigma += sigmaAt(piece, p.f) / kParts;
        source += sigmaAt(piece, p.f) * colorAt(piece, p.f).x / kParts;
      }
      const auto s = meanAlong(single.map(), float(s0), float(s1));
      const auto t = meanAlong(twin.map(), s0, s1);
      const double sigmaS = double(s.sigma), sourceS = double(s.sigma * s.color.x);
      const double sigmaT = t.sigma, sourceT = t.sigma * t.color.x;
      EXPECT_NEAR(sigmaT, sigma, 2e-3) << s0 << " " << s1;
      EXPECT_NEAR(sourceT, source, 2e-3) << s0 << " " << s1;
      EXPECT_NEAR(sigmaS, sigmaT, 1e-3 + 2e-6 / std::abs(s1 - s0)) << s0 << " " << s1;
      EXPECT_NEAR(sourceS, sourceT, 1e-3 + 2e-6 / std::abs(s1 - s0)) << s0 << " " << s1;
    }
  }
}

// Whatever units values are stored in.
TEST(Maps, StepsJustAboveAValueLeaveItBefore) {
  Random random(57);
  const Field f = anyField();
  const glm::dvec3 red(1, 0, 0), green(0, 1, 0), blue(0, 0, 1);
  for (int i = 0; i < 400; i++) {
    const MapUnits units{random.in(-9, 9), std::exp(random.in(-5, 5)), 1, 1};
    const double a = i % 4 ? random.in(-9, 9) : units.shift, b = a + units.scale * std::exp(random.in(-9, 3));
    Shown shown;
    const ColorMap map = steppedAbove({{a, red}, {b, green}, {b + units.scale, blue}});
    shown.map = CompiledMap(map, nullptr, units);
    shown.plan = evenPlan(f, 0);
    const View<float> view(f, shown);
    const auto at = [&](double v, int floatsAbove) {
      auto stored = float((v - units.shift) / units.scale);
      if (floatsAbove > 0)
        stored = stored == 0 ? std::numeric_limits<float>::min() : std::nextafter(stored, INFINITY);
      const auto c = colorOf(view.map(), stored);
      return glm::dvec3(c.x, c.y, c.z);
    };
    ASSERT_EQ(at(a, 0), red) << i;
    ASSERT_EQ(at(a, 1), green) << i;
    ASSERT_EQ(at(b, 0), green) << i;
    ASSERT_EQ(at(b, 1), blue) << i;
  }
}

}  // namespace
}  // namespace gxy::test
