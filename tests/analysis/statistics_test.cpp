// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <mutex>
#include <numeric>
#include <random>

#include "core/analysis/fixed_sum.h"
#include "core/comm/random.h"
#include "core/data/bricks.h"
#include "tests/analysis/fields.h"
#include "tests/data/random_partitioning.h"
#include "tests/support/seeds.h"

namespace gxy {
namespace {

using test::FieldSpec;

uint64_t bitsOf(double x) { return std::bit_cast<uint64_t>(x); }

/// Whether two results have the same bits.
void expectSameNumbers(const Statistics& a, const Statistics& b, const std::string& what) {
  const auto bits = [](const Statistics& s) {
    std::vector<uint64_t> all{uint64_t(s.count), uint64_t(s.noData), uint64_t(s.least.index),
                              uint64_t(s.largest.index)};
    for (const double x :
         {s.least.value, s.largest.value, s.sum, s.mean, s.variance, s.integral, s.length, s.binRange.min,
          s.binRange.max, s.least.position.x, s.least.position.y, s.largest.position.x, s.largest.position.z})
      all.push_back(bitsOf(x));
    for (const double q : s.quantiles) all.push_back(bitsOf(q));
    for (const int64_t n : s.histogram) all.push_back(uint64_t(n));
    return all;
  };
  EXPECT_EQ(bits(a), bits(b)) << what;
}

/// Numbers of a field on as many ranks, which agree about them.
Statistics numbersOf(const FieldSpec& field, const Grid& grid, const Partitioning& cut, int ranks,
                     const StatisticsOptions& options, const std::string& where = "") {
  std::vector<Statistics> found(static_cast<size_t>(ranks));
  test::ThreadRanks threads(ranks);
  const auto errors = threads.run([&](Collectives& all) {
    const auto inputs = test::inputsOf(std::vector{field}, grid, cut, all);
    std::shared_ptr<const Volume> mask;
    if (!where.empty()) mask = conditionOf(Expression(where), inputs, all);
    found[size_t(all.rank())] = fieldStatistics(*inputs[0].volume, cut, all, options, mask.get());
  });
  EXPECT_EQ(errors, std::vector<std::string>(size_t(ranks)));
  for (const Statistics& other : found) expectSameNumbers(found[0], other, "ranks");
  return found[0];
}

Statistics numbersOf(const FieldSpec& field, const Grid& grid, const StatisticsOptions& options,
                     const std::string& where = "") {
  return numbersOf(field, grid, Partitioning::single(grid.box()), 1, options, where);
}

StatisticsOptions everything() {
  StatisticsOptions options;
  options.bins = 37;
  options.quantiles = {0, 0.1, 0.25, 0.5, 0.9, 0.999, 1};
  return options;
}

/// Values of very different sizes, some equal, some missing.
FieldSpec wild(uint64_t seed, int components = 1) {
  return {"f", components, [seed](int c, const Index3& p, glm::dvec3) {
            Random random(seed + uint64_t(c) * 7919 + uint64_t(p[0] + 1000 * (p[1] + 1000 * p[2])) * 104729);
            random.next();
            if (random.oneIn(11)) return random.oneIn(2) ? double(NAN) : double(-INFINITY);
            const double size = std::exp2(double(random.below(120)) - 60) * double(random.next() >> 40);
            return random.oneIn(3) ? double(random.below(5)) : random.oneIn(2) ? size : -size;
          }};
}

TEST(Statistics, ALinearFieldHasItsClosedForms) {
  const Grid grid{{10, 20, 30}, {0.5, 1, 2}, {11, 5, 3}};
  StatisticsOptions options;
  options.bins = 11;
  options.quantiles = {0, 0.5, 0.05, 1};
  const Statistics s =
      numbersOf({"f", 1, [](int, const Index3& p, glm::dvec3) { return double(p[0]); }}, grid, options);
  EXPECT_EQ(s.count, 165);
  EXPECT_EQ(s.noData, 0);
  EXPECT_EQ(s.least.value, 0);
  EXPECT_EQ(s.least.index, 0);
  EXPECT_EQ(s.least.position, glm::dvec3(10, 20, 30));
  EXPECT_EQ(s.largest.value, 10);
  EXPECT_EQ(s.largest.index, 10) << "the lowest index of equal values";
  EXPECT_EQ(s.largest.position, glm::dvec3(15, 20, 30));
  EXPECT_EQ(s.sum, 825);
  EXPECT_EQ(s.mean, 5);
  EXPECT_EQ(s.variance, 10);
  EXPECT_EQ(s.integral, 5 * (5.0 * 4 * 4)) << "mean times the box's volume";
  EXPECT_EQ(s.histogram, std::vector<int64_t>(11, 15));
  EXPECT_EQ(s.quantiles, (std::vector<double>{0, 5, 0, 10}));
}

TEST(Statistics, TheRimOfCellsDoesNotCount) {
  Grid grid{{-0.5, -0.5, -0.5}, {1, 2, 3}, {6, 5, 4}};
  grid.rim = true;
  const Statistics s =
      numbersOf({"f", 1, [](int, const Index3& p, glm::dvec3) { return double(p[0]); }}, grid, {});
  EXPECT_EQ(s.count, 4 * 3 * 2);
  EXPECT_EQ(s.mean, 2.5);
  EXPECT_EQ(s.integral, 2.5 * 24 * 6);
  EXPECT_EQ(s.least.index, 1 + 6 * (1 + 5 * 1));
}

TEST(Statistics, ConstantsAndEmptyFieldsHaveNumbers) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {4, 3, 2}};
  const Statistics same =
      numbersOf({"f", 1, [](int, const Index3&, glm::dvec3) { return -0.1; }}, grid, everything());
  EXPECT_EQ(same.mean, double(-0.1f));
  EXPECT_EQ(same.variance, 0);
  EXPECT_EQ(same.histogram[0], 24);
  EXPECT_EQ(same.quantiles, std::vector<double>(7, double(-0.1f)));
  const Statistics none =
      numbersOf({"f", 1, [](int, const Index3&, glm::dvec3) { return double(NAN); }}, grid, everything());
  EXPECT_EQ(none.count, 0);
  EXPECT_EQ(none.noData, 24);
  EXPECT_EQ(none.least.index, -1);
  EXPECT_TRUE(std::isnan(none.mean) && std::isnan(none.variance) && std::isnan(none.quantiles[3]));
  EXPECT_EQ(none.histogram, std::vector<int64_t>(37));
  const Statistics zero = numbersOf(
      {"f", 1, [](int, const Index3& p, glm::dvec3) { return p[0] == 1 ? 0.0 : -0.0; }}, grid, everything());
  EXPECT_EQ(zero.least.index, 0) << "0 and -0 are equal";
  EXPECT_EQ(bitsOf(zero.largest.value), bitsOf(0.0));
}

TEST(Statistics, OnlyPointsWhereTheConditionHoldsCount) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {11, 5, 3}};
  const FieldSpec field{
      "f", 1, [](int, const Index3& p, glm::dvec3) { return p[0] == 4 ? double(NAN) : double(p[0]); }};
  const Statistics s = numbersOf(field, grid, everything(), "x >= 3 and x < 8");
  EXPECT_EQ(s.count, 4 * 15);
  EXPECT_EQ(s.noData, 15);
  EXPECT_EQ(s.least.value, 3);
  EXPECT_EQ(s.largest.index, 7);
  EXPECT_EQ(s.mean, 21 / 4.0);
  EXPECT_EQ(s.quantiles[3], 5.5);
  const Statistics inner = numbersOf(field, grid, {}, "f > 5");
  EXPECT_EQ(inner.count, 75);
  EXPECT_EQ(inner.noData, 0) << "a condition without data does not hold";
}

TEST(Statistics, NumbersAreThoseOfAFullSort) {
  for (int seed = 0; seed < test::seeds(20); ++seed) {
    const Grid grid{{0, 0, 0}, {1, 1, 1}, {7 + seed, 9, 8}};
    const FieldSpec field = wild(uint64_t(seed));
    std::vector<float> values;
    std::vector<double> weights;
    int64_t noData = 0;
    test::forPoints({{0, 0, 0}, grid.points}, [&](const Index3& p) {
      const auto v = float(field.value(0, p, {}));
      if (!std::isfinite(v)) return void(++noData);
      double weight = 1;
      for (size_t a = 0; a < 3; ++a) weight *= p[a] == 0 || p[a] == grid.points[a] - 1 ? 0.5 : 1;
      values.push_back(v);
      weights.push_back(weight);
    });
    const Statistics s = numbersOf(field, grid, everything());
    EXPECT_EQ(s.count, int64_t(values.size()));
    EXPECT_EQ(s.noData, noData);
    long double sum = 0, integral = 0, squares = 0, size = 0;
    for (size_t i = 0; i < values.size(); ++i)
      sum += values[i], integral += weights[i] * values[i], size += std::abs(values[i]);
    const long double mean = sum / (long double)values.size();
    for (const float v : values) squares += (v - mean) * (v - mean);
    EXPECT_NEAR(s.sum, double(sum), double(size) * 1e-15);
    EXPECT_NEAR(s.mean, double(mean), double(size) * 1e-15);
    EXPECT_NEAR(s.integral, double(integral), double(size) * 1e-15);
    EXPECT_NEAR(s.variance, double(squares / (long double)values.size()), s.variance * 1e-13);
    std::sort(values.begin(), values.end());
    EXPECT_EQ(s.least.value, values.front());
    EXPECT_EQ(s.largest.value, values.back());
    const StatisticsOptions options = everything();
    for (size_t q = 0; q < options.quantiles.size(); ++q) {
      const double at = options.quantiles[q] * double(values.size() - 1);
      const auto lower = size_t(at);
      const double a = values[lower], b = values[std::min(lower + 1, values.size() - 1)];
      EXPECT_EQ(s.quantiles[q], at > double(lower) ? a + (at - double(lower)) * (b - a) : a) << q;
    }
    EXPECT_EQ(std::accumulate(s.histogram.begin(), s.histogram.end(), int64_t(0)), s.count);
  }
}

TEST(Statistics, BitsDoNotDependOnPartitionsOrRanks) {
  for (int seed = 0; seed < test::seeds(6); ++seed) {
    Grid grid{{0.5, -3, 1e6}, {0.1, 0.2, 0.3}, {15, 18, 14}};
    grid.rim = seed % 3 == 2;
    const int components = seed % 2 ? 3 : 1;
    StatisticsOptions options = everything();
    options.component = components == 3 ? seed % 4 : 0;
    const FieldSpec field = wild(uint64_t(seed), components);
    const std::string where = seed % 4 == 3 ? "f.x < 2 * f.y" : "";
    const Statistics one = numbersOf(field, grid, options, where);
    const int ranks = 1 + seed % 5;
    std::mt19937 random{unsigned(seed)};
    for (const int parts : {7, 64}) {
      expectSameNumbers(one, numbersOf(field, grid, decomposed(grid, parts, ranks), ranks, options, where),
                        "blocks");
      expectSameNumbers(one,
                        numbersOf(field, grid, test::randomPartitioning(random, grid.box(), parts, ranks),
                                  ranks, options, where),
                        "k-d boxes");
    }
    if (HasFailure()) FAIL() << "seed " << seed;
  }
}

TEST(Statistics, TheSumOfManyFloatsHasTheSameBitsInAnyOrder) {
  const int64_t n = test::sweep(1 << 24);
  std::vector<float> values;
  Random random(9);
  for (int64_t i = 0; i < n; ++i) {
    const auto bits = uint32_t(random.next());
    const auto exponent = uint32_t(127 - 40 + (bits >> 9) % 80);
    values.push_back(std::bit_cast<float>((bits & 0x807fffffu) | exponent << 23));
  }
  const double largest = std::exp2(41);
  FixedSum forward(largest), backward(largest), cut(largest);
  for (int64_t i = 0; i < n; ++i) forward.add(double(values[size_t(i)]));
  for (int64_t i = n; i-- > 0;) backward.add(double(values[size_t(i)]));
  for (int64_t part = 0; part < 1000; ++part) {
    FixedSum sum(largest);
    for (int64_t i = part; i < n; i += 1000) sum.add(double(values[size_t(i)]));
    cut.add(sum);
  }
  EXPECT_EQ(bitsOf(forward.over(1)), bitsOf(backward.over(1)));
  EXPECT_EQ(bitsOf(forward.over(1)), bitsOf(cut.over(1)));
  long double exact = 0, size = 0;
  for (const float v : values) exact += v, size += std::abs(v);
  EXPECT_NEAR(forward.over(1), double(exact), double(size) * 1e-16);
}

TEST(Statistics, SumsKeepWhatIsSmall) {
  // 80 bits below the largest value: nothing is lost here that a double would keep, and more.
  FixedSum sum(1e6);
  sum.add(1e6);
  for (int i = 0; i < 1000; ++i) sum.add(0x1p-50);
  sum.add(-1e6);
  EXPECT_EQ(sum.over(1), 1000 * 0x1p-50);
  FixedSum tiny(1e-300);
  tiny.add(1e-300, 8);
  tiny.add(-5e-324);
  EXPECT_EQ(tiny.over(8), 1e-300 - 5e-324 / 8);
  FixedSum nothing(0);
  nothing.add(0);
  EXPECT_EQ(nothing.over(1), 0);
}

TEST(Statistics, VeryLargeAndVerySmallValuesHaveAVariance) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {4, 3, 2}};
  for (const double size : {1e-150, 1e-30, 1e30, 1e150}) {
    FieldSpec field{"f", 1, [size](int, const Index3& p, glm::dvec3) { return double(p[0]) * size; }};
    field.type = ScalarType::Float64;
    const Statistics s = numbersOf(field, grid, {});
    EXPECT_NEAR(s.mean / size, 1.5, 1e-6);
    EXPECT_NEAR(s.variance / size / size, 1.25, 1e-6) << size;
  }
}

TEST(Statistics, MagnitudesAreOfAllComponents) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {4, 3, 2}};
  StatisticsOptions options;
  options.component = 3;
  const FieldSpec field{"u", 3, [](int c, const Index3& p, glm::dvec3) {
                          return c == 0 ? 3.0 * double(p[0]) : c == 1 ? 4.0 * double(p[0]) : 0;
                        }};
  const Statistics s = numbersOf(field, grid, options);
  EXPECT_EQ(s.largest.value, 15);
  EXPECT_EQ(s.mean, 7.5);
}

TEST(Statistics, BinsMayHaveARangeOfTheirOwn) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {11, 3, 2}};
  StatisticsOptions options;
  options.bins = 4;
  options.binRange = Range{2, 6};
  const Statistics s =
      numbersOf({"f", 1, [](int, const Index3& p, glm::dvec3) { return double(p[0]); }}, grid, options);
  EXPECT_EQ(s.histogram, (std::vector<int64_t>{6, 6, 6, 12})) << "the last bin has its upper end";
}

std::string errorOf(const StatisticsOptions& options, int components = 1) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {4, 3, 2}};
  const FieldSpec field{"f", components, [](int, const Index3&, glm::dvec3) { return 1.0; }};
  SingleRank ranks;
  const Partitioning cut = Partitioning::single(grid.box());
  const auto volume = test::volumeOf(field, grid, cut, ranks);
  try {
    fieldStatistics(*volume, cut, ranks, options);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Statistics, WrongOptionsAreErrors) {
  const auto with = [](auto set) {
    StatisticsOptions options;
    set(options);
    return options;
  };
  EXPECT_EQ(errorOf({}), "");
  EXPECT_EQ(errorOf(with([](auto& o) { o.component = 1; })),
            "statistics: component 1 of a field of 1, expected 0 to 0");
  EXPECT_EQ(errorOf(with([](auto& o) { o.component = 3; }), 3), "");
  EXPECT_EQ(errorOf(with([](auto& o) { o.component = 4; }), 3),
            "statistics: component 4 of a field of 3, expected 0 to 3");
  EXPECT_EQ(errorOf(with([](auto& o) { o.bins = 65537; })), "statistics: 65537 bins, expected 0 to 65536");
  EXPECT_EQ(errorOf(with([](auto& o) {
              o.binRange = Range{1, 1};
            })),
            "statistics: bins from 1.000000 to 1.000000, expected a lower and a higher number");
  EXPECT_EQ(errorOf(with([](auto& o) {
              o.quantiles = {0.5, -0.1};
            })),
            "statistics: quantile at -0.100000, expected a number from 0 to 1");
}

/// A line of points whose values are their numbers, as segments.
GeometryBlock line(const std::vector<glm::dvec3>& points, uint64_t firstId) {
  GeometryBlock block;
  block.points = points;
  for (uint32_t i = 0; i < points.size(); ++i) block.values.push_back(float(i));
  for (uint32_t i = 0; i + 1 < points.size(); ++i) {
    block.segments.push_back({i, i + 1});
    block.neighbours.push_back({i > 0 ? i - 1 : i, i + 2 < points.size() ? i + 2 : i + 1});
    block.ids.push_back(firstId + i);
  }
  return block;
}

TEST(Statistics, PathLinesHaveLengthsAndEachPointOnce) {
  const GeometryBlock block = line({{0, 0, 0}, {3, 4, 0}, {3, 4, 2}, {3, 4, 2.5}}, 100);
  SingleRank ranks;
  const Statistics s = geometryStatistics(block, GeometryKind::PathLines, ranks, everything());
  EXPECT_EQ(s.count, 4);
  EXPECT_EQ(s.mean, 1.5);
  EXPECT_EQ(s.length, 7.5);
  EXPECT_EQ(s.integral, 5 * 0.5 + 2 * 1.5 + 0.5 * 2.5);
  EXPECT_EQ(s.largest.index, 102);
  EXPECT_EQ(s.largest.position, glm::dvec3(3, 4, 2.5));
  EXPECT_EQ(s.least.index, 100);
}

TEST(Statistics, GeometryOnRanksHasTheSameBitsHoweverItIsSpread) {
  Random random(3);
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 20000; ++i)
    points.emplace_back(double(random.below(1000)) / 7, double(random.below(1000)) / 3,
                        double(random.below(1000)) / 11);
  GeometryBlock whole = line(points, 5), particles;
  for (float& value : whole.values) value = random.oneIn(50) ? NAN : float(random.below(1000)) / 7 - 50;
  particles.points = whole.points;
  particles.values = whole.values;
  for (uint64_t i = 0; i < points.size(); ++i) particles.ids.push_back(i);
  for (const auto& [block, kind] :
       {std::pair{whole, GeometryKind::PathLines}, {particles, GeometryKind::Particles}}) {
    SingleRank single;
    const Statistics one = geometryStatistics(block, kind, single, everything());
    EXPECT_EQ(one.count + one.noData, 20000);
    test::ThreadRanks three(3);
    const GeometryBlock& all = block;
    const GeometryKind of = kind;
    const auto errors = three.run([&](Collectives& ranks) {
      std::vector<uint32_t> mine;
      for (uint32_t p = 0; p < all.ids.size(); ++p)
        if (p / 7 % 3 == uint32_t(ranks.rank()) && ranks.rank() < 2) mine.push_back(p);
      for (uint32_t p = 0; p < all.ids.size() && ranks.rank() == 2; ++p)
        if (p / 7 % 3 == 2) mine.push_back(p);
      const Statistics s = geometryStatistics(subset(all, of, mine), of, ranks, everything());
      expectSameNumbers(one, s, "three ranks");
    });
    EXPECT_EQ(errors, std::vector<std::string>(3));
  }
}

TEST(Statistics, GeometryWithoutValuesHasNoDataAndTrianglesAreAnError) {
  GeometryBlock block = line({{0, 0, 0}, {1, 0, 0}}, 1);
  block.values.clear();
  SingleRank ranks;
  const Statistics s = geometryStatistics(block, GeometryKind::PathLines, ranks);
  EXPECT_EQ(s.count, 0);
  EXPECT_EQ(s.noData, 2);
  EXPECT_EQ(s.length, 1);
  EXPECT_THROW(geometryStatistics({}, GeometryKind::Triangles, ranks), Error);
  EXPECT_EQ(geometryStatistics({}, GeometryKind::Particles, ranks).count, 0);
}

TEST(Statistics, ACancelOnOneRankEndsAll) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {30, 20, 20}};
  const Partitioning cut = decomposed(grid, 4, 2);
  for (const int after : {0, 3, 7, 12, 15}) {
    test::ThreadRanks two(2);
    const auto errors = two.run([&](Collectives& threadRank) {
      const auto volume = test::volumeOf(wild(1), grid, cut, threadRank);
      test::CancelledRanks ranks(threadRank, threadRank.rank() == 1 ? after : 1 << 30);
      fieldStatistics(*volume, cut, ranks, everything());
    });
    EXPECT_EQ(errors, std::vector<std::string>(2, "rank 1: cancelled")) << after;
  }
}

}  // namespace
}  // namespace gxy
