// SPDX-License-Identifier: Apache-2.0
// The functions of expressions, against the standard library in long double, whose results are far more accurate.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "core/analysis/field_graph.h"
#include "core/comm/random.h"
#include "tests/support/seeds.h"

// The functions as they are compiled for each instruction set.
#define FOR_EACH_SET(NAME)                                          \
  void NAME##_sse4(const double*, const double*, double*, int32_t); \
  void NAME##_avx2(const double*, const double*, double*, int32_t); \
  void NAME##_avx512skx(const double*, const double*, double*, int32_t);
#define FOR_EACH_SET_UNARY(NAME)                     \
  void NAME##_sse4(const double*, double*, int32_t); \
  void NAME##_avx2(const double*, double*, int32_t); \
  void NAME##_avx512skx(const double*, double*, int32_t);
extern "C" {
FOR_EACH_SET_UNARY(pointExp)
FOR_EACH_SET_UNARY(pointLog)
FOR_EACH_SET_UNARY(pointSin)
FOR_EACH_SET_UNARY(pointCos)
FOR_EACH_SET_UNARY(pointTan)
FOR_EACH_SET(pointPower)
FOR_EACH_SET(pointAtan2)
}

namespace gxy {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity(),
                 kNone = std::numeric_limits<double>::quiet_NaN();

using Row = std::vector<double>;

Row computed(PointOp op, const Row& a, const Row& b = {}) {
  Row to(a.size());
  const std::array<const double*, 2> operands{a.data(), b.data()};
  computePoints(op, operands, 0, to.data(), int(a.size()));
  return to;
}
double computed(PointOp op, double a, double b = 0) { return computed(op, Row{a}, Row{b})[0]; }

/// The distance between a result and the true value, in units of the last place of a double.
double ulps(double result, long double exact) {
  const auto rounded = double(exact);
  const double ulp = std::max(std::abs(std::nextafter(rounded, kInfinity) - rounded),
                              std::numeric_limits<double>::denorm_min());
  return double(std::abs((long double)result - exact) / (long double)ulp);
}

double uniform(Random& random, double lo, double hi) {
  return lo + (hi - lo) * double(random.next() >> 11) * 0x1p-53;
}
/// A number whose exponent is uniform.
double scattered(Random& random, double lo, double hi) { return std::exp2(uniform(random, lo, hi)); }
double withSign(Random& random, double x) { return random.oneIn(2) ? x : -x; }

template <class Draw, class Exact>
double worst(PointOp op, Draw draw, Exact exact) {
  Random random(7);
  Row a, b;
  for (int i = 0; i < test::sweep(50000); ++i) {
    const auto [x, y] = draw(random);
    a.push_back(x);
    b.push_back(y);
  }
  const Row results = computed(op, a, b);
  double most = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double error = ulps(results[i], exact((long double)a[i], (long double)b[i]));
    if (!(error <= most)) most = error == error ? error : kInfinity;
  }
  return most;
}

using Pair = std::pair<double, double>;

TEST(PointOperations, ExpAndLogAreWithinAnUlp) {
  const auto exp = [](long double x, long double) { return std::exp(x); };
  EXPECT_LE(worst(
                PointOp::Exp,
                [](Random& r) {
                  return Pair{uniform(r, -745, 709.7), 0};
                },
                exp),
            1);
  EXPECT_LE(worst(
                PointOp::Exp,
                [](Random& r) {
                  return Pair{withSign(r, scattered(r, -60, 3)), 0};
                },
                exp),
            1);
  const auto log = [](long double x, long double) { return std::log(x); };
  EXPECT_LE(worst(
                PointOp::Log,
                [](Random& r) {
                  return Pair{scattered(r, -1074, 1023.9), 0};
                },
                log),
            1);
  EXPECT_LE(worst(
                PointOp::Log,
                [](Random& r) {
                  return Pair{1 + withSign(r, scattered(r, -52, -2)), 0};
                },
                log),
            1);
}

TEST(PointOperations, SinAndCosAreWithinAnUlpAndTanWithinThree) {
  const auto sin = [](long double x, long double) { return std::sin(x); };
  const auto cos = [](long double x, long double) { return std::cos(x); };
  const auto tan = [](long double x, long double) { return std::tan(x); };
  for (const auto& [lo, hi] : {Pair{-40, 2}, Pair{0, 12}, Pair{12, 30}}) {
    const auto draw = [lo = lo, hi = hi](Random& r) { return Pair{withSign(r, scattered(r, lo, hi)), 0}; };
    EXPECT_LE(worst(PointOp::Sin, draw, sin), 1) << lo;
    EXPECT_LE(worst(PointOp::Cos, draw, cos), 1) << lo;
    EXPECT_LE(worst(PointOp::Tan, draw, tan), 3) << lo;
  }
  // Beside multiples of pi / 2, where what is left is small. x87's own reduction has too few digits there for more of them.
  const auto beside = [](Random& r) { return Pair{double(1 + r.below(1000)) * 1.5707963267948966, 0}; };
  EXPECT_LE(worst(PointOp::Sin, beside, sin), 1);
  EXPECT_LE(worst(PointOp::Cos, beside, cos), 1);
  for (const PointOp op : {PointOp::Sin, PointOp::Cos, PointOp::Tan})
    EXPECT_TRUE(std::isnan(computed(op, 0x1p30)));
}

TEST(PointOperations, PowersAreWithinAnUlp) {
  const auto pow = [](long double x, long double y) { return std::pow(x, y); };
  EXPECT_LE(worst(
                PointOp::Power,
                [](Random& r) {
                  return Pair{scattered(r, -10, 10), uniform(r, -100, 100)};
                },
                pow),
            1);
  EXPECT_LE(worst(
                PointOp::Power,
                [](Random& r) {
                  return Pair{scattered(r, -300, 300), uniform(r, -3, 3)};
                },
                pow),
            1);
  EXPECT_LE(worst(
                PointOp::Power,
                [](Random& r) {
                  return Pair{1 + withSign(r, scattered(r, -40, -20)), scattered(r, 10, 28)};
                },
                pow),
            1);
  EXPECT_LE(worst(
                PointOp::Power,
                [](Random& r) {
                  return Pair{-scattered(r, -10, 10), std::floor(uniform(r, -30, 30))};
                },
                pow),
            1);
}

TEST(PointOperations, AnglesAreWithinTwoUlp) {
  const auto draw = [](Random& r) {
    return Pair{withSign(r, scattered(r, -20, 20)), withSign(r, scattered(r, -20, 20))};
  };
  EXPECT_LE(worst(PointOp::Atan2, draw, [](long double y, long double x) { return std::atan2(y, x); }), 2);
  const auto near = [](Random& r) {
    return Pair{withSign(r, uniform(r, 0.9, 1.1)), withSign(r, uniform(r, 0.9, 1.1))};
  };
  EXPECT_LE(worst(PointOp::Atan2, near, [](long double y, long double x) { return std::atan2(y, x); }), 2);
  EXPECT_EQ(computed(PointOp::Atan2, 0, 1), 0);
  EXPECT_EQ(computed(PointOp::Atan2, 0, -1), M_PI);
  EXPECT_EQ(computed(PointOp::Atan2, 1, 0), M_PI / 2);
  EXPECT_EQ(computed(PointOp::Atan2, -1, 0), -M_PI / 2);
  EXPECT_EQ(computed(PointOp::Atan2, 1, 1), M_PI / 4);
}

TEST(PointOperations, ResultsThatDoNotExistAreNoData) {
  const std::vector<std::pair<PointOp, Pair>> cases{
      {PointOp::Divide, {1, 0}},   {PointOp::Divide, {0, 0}},     {PointOp::Sqrt, {-1e-300, 0}},
      {PointOp::Log, {0, 0}},      {PointOp::Log, {-1, 0}},       {PointOp::Power, {0, -1}},
      {PointOp::Power, {-2, 0.5}}, {PointOp::Sin, {kInfinity, 0}}};
  for (const auto& [op, operands] : cases)
    EXPECT_TRUE(std::isnan(computed(op, operands.first, operands.second))) << int(op);
  for (const PointOp op : {PointOp::Add, PointOp::Subtract, PointOp::Multiply, PointOp::Divide, PointOp::Min,
                           PointOp::Max, PointOp::Less, PointOp::LessEqual, PointOp::Equal, PointOp::NotEqual,
                           PointOp::Power, PointOp::Atan2}) {
    EXPECT_TRUE(std::isnan(computed(op, kNone, 1))) << int(op);
    EXPECT_TRUE(std::isnan(computed(op, 1, kNone))) << int(op);
  }
  for (const PointOp op : {PointOp::Negate, PointOp::Abs, PointOp::Floor, PointOp::Sqrt, PointOp::Not,
                           PointOp::Exp, PointOp::Log, PointOp::Sin, PointOp::Cos, PointOp::Tan})
    EXPECT_TRUE(std::isnan(computed(op, kNone))) << int(op);
}

TEST(PointOperations, PowersHaveTheirLimits) {
  EXPECT_EQ(computed(PointOp::Power, 0, 2), 0);
  EXPECT_EQ(computed(PointOp::Power, 0, 0), 1);
  EXPECT_EQ(computed(PointOp::Power, 7, 0), 1);
  EXPECT_EQ(computed(PointOp::Power, 1, 1e300), 1);
  EXPECT_EQ(computed(PointOp::Power, 2, 1e300), kInfinity);
  EXPECT_EQ(computed(PointOp::Power, 2, -1e300), 0);
  EXPECT_EQ(computed(PointOp::Power, -2, 3), -8);
  EXPECT_EQ(computed(PointOp::Power, -2, 4), 16);
  EXPECT_EQ(computed(PointOp::Exp, 1000), kInfinity);
  EXPECT_EQ(computed(PointOp::Exp, -1000), 0);
  EXPECT_EQ(computed(PointOp::Exp, 0), 1);
  EXPECT_EQ(computed(PointOp::Log, 1), 0);
}

TEST(PointOperations, LogicIsKleenes) {
  const Row a{0, 0, 0, 1, 1, 1, kNone, kNone, kNone}, b{0, 1, kNone, 0, 1, kNone, 0, 1, kNone};
  const Row both{0, 0, 0, 0, 1, kNone, 0, kNone, kNone}, any{0, 1, kNone, 1, 1, 1, kNone, 1, kNone};
  const Row isAnd = computed(PointOp::And, a, b), isOr = computed(PointOp::Or, a, b);
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_TRUE(isAnd[i] == both[i] || (std::isnan(isAnd[i]) && std::isnan(both[i]))) << i;
    EXPECT_TRUE(isOr[i] == any[i] || (std::isnan(isOr[i]) && std::isnan(any[i]))) << i;
  }
}

TEST(PointOperations, TheBitsOfFunctionsStay) {
  // A change of these bits changes files that others have made: they are the same with every instruction set and compiler.
  Random random(11);
  Row a, b;
  for (int i = 0; i < 4096; ++i) {
    a.push_back(scattered(random, -8, 8));
    b.push_back(uniform(random, -8, 8));
  }
  uint64_t hash = 0;
  for (const PointOp op :
       {PointOp::Exp, PointOp::Log, PointOp::Sin, PointOp::Cos, PointOp::Tan, PointOp::Power, PointOp::Atan2})
    for (const double x : computed(op, a, b)) hash = (hash ^ std::bit_cast<uint64_t>(x)) * 0x100000001b3ull;
  EXPECT_EQ(hash, 3394276336316710024u);
}

TEST(PointOperations, AllInstructionSetsOfThisProcessorGiveTheSameBits) {
  const bool there[] = {true, bool(__builtin_cpu_supports("avx2")), bool(__builtin_cpu_supports("avx512f"))};
  Random random(5);
  Row a, b;
  for (int i = 0; i < 20011; ++i) {
    a.push_back(withSign(random, scattered(random, i % 2 ? -8 : -1074, i % 2 ? 8 : 1023)));
    b.push_back(withSign(random, scattered(random, -30, 30)));
  }
  for (const double x : {0.0, -0.0, kInfinity, -kInfinity, kNone, 5e-324, 1.0, 0x1p30})
    a.push_back(x), b.push_back(-x);
  const auto expectSame = [&](auto... kernels) {
    std::vector<std::vector<uint64_t>> bits;
    size_t set = 0;
    for (const auto& kernel : {std::function<void(double*)>(kernels)...}) {
      if (!there[set++]) continue;
      Row to(a.size());
      kernel(to.data());
      for (double& x : to) x = x == x ? x : kNone;
      bits.emplace_back();
      for (const double x : to) bits.back().push_back(std::bit_cast<uint64_t>(x));
    }
    for (const auto& others : bits) EXPECT_EQ(others, bits[0]);
  };
  const auto n = int32_t(a.size());
  const auto unary = [&](auto kernel) { return [=, &a](double* to) { kernel(a.data(), to, n); }; };
  const auto binary = [&](auto kernel) {
    return [=, &a, &b](double* to) { kernel(a.data(), b.data(), to, n); };
  };
#define EXPECT_SAME(KIND, NAME) expectSame(KIND(NAME##_sse4), KIND(NAME##_avx2), KIND(NAME##_avx512skx))
  EXPECT_SAME(unary, pointExp);
  EXPECT_SAME(unary, pointLog);
  EXPECT_SAME(unary, pointSin);
  EXPECT_SAME(unary, pointCos);
  EXPECT_SAME(unary, pointTan);
  EXPECT_SAME(binary, pointPower);
  EXPECT_SAME(binary, pointAtan2);
}

/// The determinant of M - x, M = (J J + (J J)^T) / 2, relative to the size of M.
double characteristic(const std::array<double, 9>& j, double x) {
  double m[3][3] = {}, size = 0;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < 3; ++k)
        m[r][c] +=
            0.5 * (j[size_t(3 * r + k)] * j[size_t(3 * k + c)] + j[size_t(3 * c + k)] * j[size_t(3 * k + r)]);
      size = std::max(size, std::abs(m[r][c]));
    }
  for (int r = 0; r < 3; ++r) m[r][r] -= x;
  const double determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                             m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                             m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  return determinant / (size * size * size);
}

TEST(PointOperations, Lambda2IsTheMiddleEigenvalue) {
  Random random(3);
  for (int i = 0; i < test::sweep(2000); ++i) {
    std::array<double, 9> j;
    const double scale = scattered(random, -200, 200);
    for (double& x : j) x = random.oneIn(5) ? 0 : scale * uniform(random, -1, 1);
    std::array<const double*, 9> rows;
    for (size_t c = 0; c < 9; ++c) rows[c] = &j[c];
    double x = 0;
    computePoints(PointOp::Lambda2, rows, 0, &x, 1);
    if (std::ranges::all_of(j, [](double v) { return v == 0; })) continue;
    for (double& element : j) element /= scale;
    EXPECT_LE(std::abs(characteristic(j, x / (scale * scale))), 1e-14) << i;
  }
  // A diagonal jacobian has the squares of its elements as eigenvalues.
  const std::array<double, 9> diagonal{3, 0, 0, 0, 1, 0, 0, 0, -2};
  std::array<const double*, 9> rows;
  for (size_t c = 0; c < 9; ++c) rows[c] = &diagonal[c];
  double x = 0, q = 0;
  computePoints(PointOp::Lambda2, rows, 0, &x, 1);
  computePoints(PointOp::Q, rows, 0, &q, 1);
  EXPECT_EQ(x, 4);
  EXPECT_EQ(q, -7);
}

}  // namespace
}  // namespace gxy
