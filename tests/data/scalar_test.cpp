// SPDX-License-Identifier: Apache-2.0
#include "core/data/scalar.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>

#include "core/comm/error.h"
#include "tests/data/bytes.h"

namespace gxy {
namespace {

template <typename T>
std::vector<float> stored(const std::vector<T>& values, ScalarType type, const Encoding& encoding) {
  const Samples samples = convert(bytes(values), type, encoding);
  std::vector<float> f(samples.size() / sizeof(float));
  std::memcpy(f.data(), samples.data(), samples.size());
  return f;
}

TEST(Convert, KeepsASmallSignalOnALargeOffset) {
  std::mt19937 random(1);
  std::uniform_real_distribution<> noise(-0.01, 0.01);
  std::vector<double> values(1000);
  Range range;
  for (double& v : values) range.extend(v = 101325.0 + noise(random));
  const Encoding e = encodingOf(ScalarType::Float64, 1, range);
  const std::vector<float> f = stored(values, ScalarType::Float64, e);
  for (size_t i = 0; i < values.size(); ++i) {
    // Half an ulp of float at 0.01, and a few of double at 101325.
    EXPECT_NEAR(e.shift + e.scale * double(f[i]), values[i], 0.01 * 0x1p-24 + 1e-10);
  }
}

TEST(Convert, OrdinaryDoublesAreRoundedOnceAndLeftUnshifted) {
  const Encoding e = encodingOf(ScalarType::Float64, 1, {-3, 255});
  EXPECT_EQ(e, (Encoding{ScalarType::Float32, 0, 1}));
  EXPECT_EQ(stored(std::vector<double>{0.1, -3, 1e-9, 255}, ScalarType::Float64, e),
            (std::vector<float>{0.1f, -3, 1e-9f, 255}));
}

TEST(Convert, ExtremeDoublesStayFiniteAndAccurate) {
  for (double scale : {1e-300, 1e300, 1.7e308}) {
    const std::vector<double> values{-scale, scale, scale / 2};
    const Encoding e = encodingOf(ScalarType::Float64, 1, {-scale, scale});
    const std::vector<float> f = stored(values, ScalarType::Float64, e);
    for (size_t i = 0; i < values.size(); ++i) {
      ASSERT_TRUE(std::isfinite(f[i]));
      EXPECT_NEAR(e.shift + e.scale * double(f[i]), values[i], scale * 0x1p-23);
    }
  }
}

TEST(Convert, LargeIntegersWithASmallSpanAreExact) {
  const int64_t base = 9'000'000'000'000'000'000;
  const std::vector<int64_t> values{base, base + 1, base + 1000, base + 12345};
  const Encoding e = encodingOf(ScalarType::Int64, 1, {double(base), double(base + 12345)});
  const std::vector<float> f = stored(values, ScalarType::Int64, e);
  for (size_t i = 1; i < values.size(); ++i) {
    EXPECT_EQ(e.scale * double(f[i]) - e.scale * double(f[0]), double(values[i] - base));
  }
  const uint64_t top = std::numeric_limits<uint64_t>::max();
  const Encoding u = encodingOf(ScalarType::UInt64, 1, {double(top - 2048), double(top)});
  const std::vector<float> g = stored(std::vector<uint64_t>{top, top - 2048}, ScalarType::UInt64, u);
  EXPECT_EQ(double(g[0] - g[1]) * u.scale, 2048);
  const std::vector<int32_t> whole{-16777215, 16777215, 3};
  EXPECT_EQ(stored(whole, ScalarType::Int32, encodingOf(ScalarType::Int32, 1, {-16777215, 16777215})),
            (std::vector<float>{-16777215, 16777215, 3}));
}

TEST(Convert, NoDataStaysNoData) {
  const Encoding e = encodingOf(ScalarType::Float64, 1, {5e9, 5e9});
  const std::vector<float> f =
      stored(std::vector<double>{NAN, INFINITY, -INFINITY, 5e9}, ScalarType::Float64, e);
  EXPECT_TRUE(std::isnan(f[0]));
  EXPECT_EQ(f[1], INFINITY);
  EXPECT_EQ(f[2], -INFINITY);
  EXPECT_EQ(e.shift + e.scale * double(f[3]), 5e9);
}

TEST(Convert, NarrowTypesAreKept) {
  const std::vector<uint16_t> values{1, 65535, 7};
  const Encoding e = encodingOf(ScalarType::UInt16, 1, {1, 65535});
  EXPECT_EQ(e, (Encoding{ScalarType::UInt16, 0, 1}));
  const Samples kept = convert(bytes(values), ScalarType::UInt16, e);
  EXPECT_EQ(std::memcmp(kept.data(), values.data(), 6), 0);
  EXPECT_THROW(convert(bytes(values), ScalarType::UInt16, {ScalarType::Float32, 0, 1}), Error);
  EXPECT_THROW(convert(bytes(values).first(5), ScalarType::UInt16, e), Error);
}

TEST(Convert, FloatsOfAnySizeKeepEveryBit) {
  EXPECT_EQ(encodingOf(ScalarType::Float32, 1, {101324, 101325}), Encoding{ScalarType::Float32});
  for (float size : {1e-44f, 1e-40f, 1e-30f, 1e-10f, 1e10f, 3e38f}) {
    const std::vector<float> values{-size, size, size / 3, 0};
    const Encoding e = encodingOf(ScalarType::Float32, 1, {-double(size), double(size)});
    EXPECT_EQ(e.scale == 1, size == 1e-10f || size == 1e10f);
    const std::vector<float> f = stored(values, ScalarType::Float32, e);
    for (size_t i = 0; i < values.size(); ++i) {
      EXPECT_EQ(e.shift + e.scale * double(f[i]), double(values[i]));
      EXPECT_TRUE(f[i] == 0 || std::isnormal(f[i]));
    }
  }
}

TEST(Convert, VectorsAreNeverShifted) {
  EXPECT_EQ(encodingOf(ScalarType::Float64, 3, {101324, 101325}).shift, 0);
  EXPECT_NE(encodingOf(ScalarType::Float64, 1, {101324, 101325}).shift, 0);
}

/// How often the encoding of a step differs from that of the step before.
int changes(int steps, const std::function<Range(double)>& rangeAt) {
  int changed = 0;
  Encoding last = encodingOf(ScalarType::Float64, 1, rangeAt(0));
  for (int step = 1; step < steps; ++step) {
    const Encoding e = encodingOf(ScalarType::Float64, 1, rangeAt(double(step) / steps));
    changed += e != last;
    last = e;
  }
  return changed;
}

TEST(Convert, ASlowDriftKeepsTheEncoding) {
  // By one width of the range at most three multiples of the power are passed, and one power by twice the width.
  std::mt19937 random(2);
  std::uniform_real_distribution<> unit(0, 1), sign(-1, 1);
  for (int draw = 0; draw < 100; ++draw) {
    const double half = std::exp2(14 * unit(random) - 10), drift = 2 * half * sign(random),
                 growth = std::exp2(sign(random));
    const auto rangeAt = [&](double time) {
      const double middle = 101325 + drift * time, wide = half * std::pow(growth, time);
      return Range{middle - wide, middle + wide};
    };
    EXPECT_LE(changes(1000, rangeAt), 4) << half << " " << drift << " " << growth;
  }
}

TEST(Convert, ADriftOfExtremeValuesKeepsTheEncoding) {
  for (double size : {1e-300, 1e300})
    EXPECT_LE(changes(1000,
                      [&](double time) {
                        return Range{(1000 + time) * size, (1002 + 1.5 * time) * size};
                      }),
              4)
        << size;
}

/// Asserts that each value in `values` is stored with at most one bit of 24 lost to the steady shift: half a unit in the
/// last place of float at the range's width. `slack` covers the rounding of what the test computes in double.
template <typename T>
void expectOneBit(const std::vector<T>& values, ScalarType type, double slack) {
  Range range;
  for (T v : values) range.extend(double(v));
  const Encoding e = encodingOf(type, 1, range);
  ASSERT_TRUE(std::isfinite(e.shift) && std::isnormal(e.scale)) << e.shift << " " << e.scale;
  const double half = range.max / 2 - range.min / 2;
  if (e.shift != 0) {
    EXPECT_GE(e.shift, range.min);
    EXPECT_LE(e.shift, range.max);
  }
  const std::vector<float> f = stored(values, type, e);
  for (size_t i = 0; i < values.size(); ++i) {
    ASSERT_TRUE(std::isfinite(f[i]) && (f[i] == 0 || std::isnormal(f[i]))) << f[i];
    const long double off = (long double)e.shift + (long double)e.scale * f[i] - (long double)values[i];
    EXPECT_LE(std::abs(double(off)), half * 0x1p-23 + slack) << double(values[i]);
  }
}

TEST(Convert, TheSteadyShiftCostsAtMostOneBit) {
  std::mt19937 random(3);
  std::uniform_real_distribution<> unit(0, 1);
  for (int draw = 0; draw < 2000; ++draw) {
    const double middle = std::exp2(2000 * unit(random) - 1000) * (draw % 2 ? 1 : -1);
    const double half = std::abs(middle) * std::exp2(-3 - 40 * unit(random));
    std::vector<double> values{middle - half, middle + half, middle};
    for (int i = 0; i < 10; ++i) values.push_back(middle + half * (2 * unit(random) - 1));
    expectOneBit(values, ScalarType::Float64, std::abs(middle) * 0x1p-52);
  }
}

TEST(Convert, ExtremeOffsetsNeitherOverflowNorDivideByZero) {
  const double least = std::numeric_limits<double>::denorm_min(), most = std::numeric_limits<double>::max();
  const auto f64 = [](std::vector<double> values) { expectOneBit(values, ScalarType::Float64, 0); };
  f64({0});
  f64({least});
  f64({-least});
  f64({least, 2 * least, 3 * least});
  f64({1000 * least, 1001 * least});
  f64({0x1p-1022, 0x1p-1022 + least, 0x1p-1022 + 7 * least});
  f64({most});
  f64({-most});
  f64({most * 0.6, most * 0.8, most});
  f64({std::nextafter(most, 0), most});
  f64({-most, -most * 0.7});
  f64({5e9});
  const int64_t low = std::numeric_limits<int64_t>::min(), high = std::numeric_limits<int64_t>::max();
  // The range of 64-bit integers is in double, so it may be off by 512 at their largest.
  const auto i64 = [](std::vector<int64_t> values) {
    expectOneBit(values, ScalarType::Int64, 1024 * 0x1p-24);
  };
  i64({low});
  i64({low, low + 1024});
  i64({low, low / 4 * 3});
  i64({high - 1023, high - 2047});
  i64({high / 4 * 3, high - 1023});
  expectOneBit(
      std::vector<int32_t>{std::numeric_limits<int32_t>::max() - 100, std::numeric_limits<int32_t>::max()},
      ScalarType::Int32, 0);
  expectOneBit(std::vector<uint32_t>{4000000000u, 4294967295u}, ScalarType::UInt32, 0);
}

TEST(Convert, WholeNumbersNear16MillionOfAnOffsetStayExact) {
  const int32_t base = 1'000'000'000;
  const std::vector<int32_t> values{base, base + 1, base + 16777215, base + 8388607};
  const Encoding e = encodingOf(ScalarType::Int32, 1, {double(base), double(base + 16777215)});
  const std::vector<float> f = stored(values, ScalarType::Int32, e);
  for (size_t i = 0; i < values.size(); ++i) EXPECT_EQ(e.shift + e.scale * double(f[i]), double(values[i]));
}

TEST(Convert, AnEncodingSufficesIfItCostsNoMoreThanTwoBits) {
  const auto fits = [](const Encoding& known, const Range& range, int components = 1) {
    return suffices(known, ScalarType::Float64, components, range);
  };
  const Encoding own = encodingOf(ScalarType::Float64, 1, {101305, 101345});
  EXPECT_TRUE(fits(own, {101305, 101345}));
  EXPECT_TRUE(fits(own, {101325, 101385})) << "a drift";
  EXPECT_FALSE(fits(own, {101305 + 200, 101345 + 200}));
  EXPECT_FALSE(fits({}, {101305, 101345})) << "no shift";
  EXPECT_TRUE(fits({}, {-1.8e19, 1.8e19})) << "float has room";
  EXPECT_FALSE(fits({}, {1, 1e20}));
  EXPECT_FALSE(fits({}, {0, 1e-30})) << "these would be denormal soon";
  EXPECT_TRUE(fits({}, {0, 0}));
  EXPECT_TRUE(fits(own, {})) << "no data at all";
  EXPECT_TRUE(fits({}, {-3, 5}, 3));
  EXPECT_FALSE(fits(own, {101305, 101345}, 3)) << "vectors have no shift";
  EXPECT_FALSE(fits({}, {3e7, 5e7})) << "whole numbers would not stay exact";
  EXPECT_FALSE(suffices(own, ScalarType::Int32, 1, {101305, 101345}));
  EXPECT_FALSE(suffices(own, ScalarType::Float32, 1, {101305, 101345}));
}

TEST(SwapBytes, ReversesEachValue) {
  std::vector<uint32_t> values{0x01020304u, 0xa0b0c0d0u};
  swapBytes(std::as_writable_bytes(std::span(values)), 4);
  EXPECT_EQ(values, (std::vector<uint32_t>{0x04030201u, 0xd0c0b0a0u}));
  EXPECT_THROW(swapBytes(std::as_writable_bytes(std::span(values)), 3), Error);
}

}  // namespace
}  // namespace gxy
