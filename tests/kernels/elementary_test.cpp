// SPDX-License-Identifier: Apache-2.0
// The float functions against long double, the twin against long double.
#include <gtest/gtest.h>

#include "tests/kernels/random.h"

namespace gxy {
namespace {

using test::Random;
using test::ulps;

struct Function {
  const char* name;
  float (*single)(float);
  double (*twin)(double);
  long double (*truth)(long double);
  double lo, hi;    // the stated range
  double smallest;  // arguments nearer to 0 are not drawn
  double ulps;      // the stated error
};

const Function functions[] = {
    {"exp1", single::exp1, twin::exp1, [](long double x) { return std::exp(x); }, -87, 88, 1e-30, 1},
    {"oneMinusExp", single::oneMinusExp, twin::oneMinusExp, [](long double x) { return -std::expm1(-x); },
     -88, 1e6, 1e-37, 2},
    {"log1", single::log1, twin::log1, [](long double x) { return std::log(x); }, 1.2e-38, 3.4e38, 1.2e-38,
     1},
    {"minusLogOneMinus", single::minusLogOneMinus, twin::minusLogOneMinus,
     [](long double x) { return -std::log1p(-x); }, -1e30, 0.99999994, 1e-37, 2},
    {"sin1", single::sin1, twin::sin1, [](long double x) { return std::sin(x); }, -64, 64, 1e-37, 2},
    {"cos1", single::cos1, twin::cos1, [](long double x) { return std::cos(x); }, -64, 64, 1e-37, 2},
};

// Half of the arguments uniform over the range, half log-uniform in magnitude, and a quarter of the latter near 1.
float argument(Random& random, const Function& f) {
  for (;;) {
    double x = 0;
    int kind = random.below(8);
    if (kind < 4) {
      x = random.in(f.lo, f.hi);
    } else if (kind == 4) {
      x = 1 + random.in(-0.5, 0.5);
    } else {
      x = random.scale(f.smallest, std::max(std::fabs(f.lo), std::fabs(f.hi))) *
          (random.below(2) == 0 ? 1 : -1);
    }
    float rounded = float(x);
    if (rounded >= f.lo && rounded <= f.hi && std::fabs(rounded) >= f.smallest) return rounded;
  }
}

TEST(Elementary, FloatErrorIsWithinTheStatedUlps) {
  for (const Function& f : functions) {
    Random random(1);
    double worst = 0;
    float at = 0;
    for (int i = 0; i < 1'000'000; ++i) {
      float x = argument(random, f);
      double error = ulps(f.single(x), f.truth(x));
      if (error > worst) {
        worst = error;
        at = x;
      }
    }
    EXPECT_LE(worst, f.ulps) << f.name << " at " << at;
  }
}

TEST(Elementary, TwinIsAccurateToDoubleRounding) {
  for (const Function& f : functions) {
    Random random(2);
    for (int i = 0; i < 20'000; ++i) {
      float x = argument(random, f);
      long double truth = f.truth(x);
      ASSERT_LE(std::fabs(f.twin(x) - truth), 1e-15L * std::fabs(truth)) << f.name << " at " << x;
    }
  }
}

TEST(Elementary, ExpIsExactAtZeroAndSaturatesOutsideItsRange) {
  EXPECT_EQ(single::exp1(0.0f), 1.0f);
  EXPECT_EQ(single::exp1(-0.0f), 1.0f);
  EXPECT_EQ(single::exp1(-87.00001f), 0.0f);
  EXPECT_GT(single::exp1(-87.0f), 1.2e-38f);
  EXPECT_EQ(single::exp1(-INFINITY), 0.0f);
  EXPECT_EQ(single::exp1(INFINITY), single::exp1(88.0f));
  EXPECT_NEAR(single::exp1(88.0f), 1.6516363e38, 1e32);
  EXPECT_EQ(single::exp1(NAN), 0.0f);
}

TEST(Elementary, OpacityAndOpticalDepthAreInverse) {
  Random random(3);
  for (int i = 0; i < 100'000; ++i) {
    // Where 1 - a has few digits left the depth determines a better than the reverse.
    auto a = float(random.scale(1e-30, 0.9));
    ASSERT_NEAR(single::oneMinusExp(single::minusLogOneMinus(a)), a, 5e-7 * a);
  }
  EXPECT_EQ(single::oneMinusExp(0.0f), 0.0f);
  EXPECT_EQ(single::minusLogOneMinus(0.0f), 0.0f);
  EXPECT_EQ(single::minusLogOneMinus(1.0f), single::opaqueDepth());
  EXPECT_EQ(single::exp1(-single::opaqueDepth()), 0.0f);
  EXPECT_EQ(single::oneMinusExp(single::opaqueDepth()), 1.0f);
}

TEST(Elementary, ExpAndOneMinusExpNeverDecreaseByMoreThanTheirError) {
  float before = 0;
  for (int i = 0; i <= 1'000'000; ++i) {
    float now = single::oneMinusExp(float(i) * 20e-6f);
    ASSERT_GE(now, before - 2 * 0x1p-24f * before);
    ASSERT_LE(now, 1.0f);
    before = now;
  }
}

TEST(Elementary, DenormalsCountAsZero) {
  const float denormals[] = {1e-45f, 1e-40f, 1.1754942e-38f, -1e-45f, -1e-40f};
  for (float x : denormals) {
    EXPECT_EQ(single::flushSmall(x), 0.0f);
    EXPECT_EQ(single::exp1(x), 1.0f);
    EXPECT_EQ(single::oneMinusExp(x), 0.0f);
    EXPECT_EQ(single::minusLogOneMinus(x), 0.0f);
    EXPECT_EQ(single::sin1(x), 0.0f);
    EXPECT_EQ(single::cos1(x), 1.0f);
    EXPECT_EQ(single::log1(x), single::log1(0.0f));
  }
  EXPECT_NEAR(single::log1(0.0f), -87.336545, 1e-5);
}

TEST(Elementary, PowIsWithinItsStatedError) {
  Random random(4);
  for (int i = 0; i < 200'000; ++i) {
    auto x = float(random.unit());
    auto y = float(random.scale(0.1, 1000));
    double truth = std::pow(double(x), double(y));
    if (truth < 1e-30) continue;
    ASSERT_NEAR(single::pow1(x, y), truth, truth * (2 + std::fabs(y * std::log(x))) * 0x1p-23)
        << x << "^" << y;
  }
  EXPECT_EQ(single::pow1(1.0f, 77.0f), 1.0f);
  EXPECT_EQ(single::pow1(0.0f, 0.0f), 1.0f);
  EXPECT_EQ(single::pow1(0.0f, 2.0f), 0.0f);
}

TEST(Elementary, SineAndCosineKeepTheUnitCircle) {
  for (int i = -6400; i <= 6400; ++i) {
    float s, c;
    single::sincos1(float(i) * 0.01f, s, c);
    ASSERT_NEAR(s * s + c * c, 1.0f, 4e-7f);
  }
}

}  // namespace
}  // namespace gxy
