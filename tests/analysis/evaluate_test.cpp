// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/evaluate.h"

#include <gtest/gtest.h>
#include <immintrin.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <thread>

#include "core/comm/random.h"
#include "tests/analysis/fields.h"
#include "tests/data/random_partitioning.h"
#include "tests/support/seeds.h"

namespace gxy {
namespace {

using test::derived;
using test::FieldSpec;
using test::WholeField;

FieldSpec scalarField(const std::string& name, std::function<double(glm::dvec3)> value) {
  return {name, 1, [value](int, const Index3&, glm::dvec3 p) { return value(p); }};
}
FieldSpec vectorField(const std::string& name, std::function<glm::dvec3(glm::dvec3)> value) {
  return {name, 3, [value](int c, const Index3&, glm::dvec3 p) { return value(p)[c]; }};
}

/// Samples without any order, from -1 to 1.
FieldSpec noise(const std::string& name, int components, uint64_t seed) {
  return {name, components, [seed](int c, const Index3& p, glm::dvec3) {
            Random random(seed + uint64_t(c) * 7919 + uint64_t(p[0] + 1000 * (p[1] + 1000 * p[2])) * 104729);
            random.next();
            return double(random.next() >> 40) * 0x1p-23 - 1;
          }};
}

/// The largest distance between component c and a function, over all points.
double worst(const WholeField& field, int c, std::function<double(glm::dvec3)> exact) {
  double most = 0;
  test::forPoints({{0, 0, 0}, field.grid.points}, [&](const Index3& p) {
    const double error = std::abs(field.at(p, c) - exact(test::worldOf(field.grid, p)));
    if (!(error <= most)) most = error == error ? error : INFINITY;
  });
  return most;
}

void expectNoErrors(const WholeField& field) {
  for (const std::string& error : field.errors) EXPECT_EQ(error, "");
  EXPECT_EQ(field.wrongGhosts, 0);
}

constexpr double kUlp = 0x1p-23;

TEST(Derive, DerivativesOfLinearFieldsAreExactAtTheEndsToo) {
  // The samples of these fields are exact in float, so only the arithmetic rounds.
  for (const glm::dvec3 spacing : {glm::dvec3(0.5, 0.25, 2), glm::dvec3(1, 0x1p-13, 1)}) {
    const Grid grid{{-2, 1, 0}, spacing, {11, 9, 13}};
    const std::vector<FieldSpec> fields{
        scalarField("f", [](glm::dvec3 p) { return 3 * p.x - 2 * p.y + 0.5 * p.z; }),
        vectorField("r", [](glm::dvec3 p) { return p; }),
        vectorField("w", [](glm::dvec3 p) { return glm::dvec3(-p.y, p.x, 0); })};
    const double range = 60 * kUlp * 2;  // of f; the others' ranges are smaller
    const WholeField grad = derived("grad(f)", fields, grid);
    expectNoErrors(grad);
    EXPECT_LE(worst(grad, 0, [](glm::dvec3) { return 3; }), range);
    EXPECT_LE(worst(grad, 1, [](glm::dvec3) { return -2; }), range);
    EXPECT_LE(worst(grad, 2, [](glm::dvec3) { return 0.5; }), range);
    EXPECT_EQ(worst(derived("div(r)", fields, grid), 0, [](glm::dvec3) { return 3; }), 0);
    const WholeField curl = derived("curl(w)", fields, grid);
    for (int c = 0; c < 3; ++c) EXPECT_EQ(worst(curl, c, [c](glm::dvec3) { return c == 2 ? 2 : 0; }), 0);
    EXPECT_LE(worst(derived("laplacian(f)", fields, grid), 0, [](glm::dvec3) { return 0; }), 0);
  }
}

TEST(Derive, DifferencesOfQuadraticFieldsAreExactAtTheEndsToo) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {9, 8, 7}};
  const std::vector<FieldSpec> fields{
      scalarField("f", [](glm::dvec3 p) { return p.x * p.x - 3 * p.y * p.y + p.x * p.z; })};
  const WholeField grad = derived("grad(f)", fields, grid);
  EXPECT_EQ(worst(grad, 0, [](glm::dvec3 p) { return 2 * p.x + p.z; }), 0);
  EXPECT_EQ(worst(grad, 1, [](glm::dvec3 p) { return -6 * p.y; }), 0);
  EXPECT_EQ(worst(grad, 2, [](glm::dvec3 p) { return p.x; }), 0);
  EXPECT_EQ(worst(derived("laplacian(f)", fields, grid), 0, [](glm::dvec3) { return -4; }), 0);
  EXPECT_EQ(worst(derived("div(grad(f))", fields, grid), 0, [](glm::dvec3) { return -4; }), 0);
  // The second difference at an end has order 2: a cubic is exact, too.
  const std::vector<FieldSpec> cubic{scalarField("f", [](glm::dvec3 p) { return p.y * p.y * p.y; })};
  EXPECT_EQ(worst(derived("laplacian(f)", cubic, grid), 0, [](glm::dvec3 p) { return 6 * p.y; }), 0);
}

TEST(Derive, CurlOfABCFlowIsTheFlowTimesSinHOverH) {
  const int64_t n = 128;
  const double h = 2 * M_PI / double(n - 1);
  const Grid grid{{0, 0, 0}, {h, h, h}, {n, n, n}};
  std::vector<double> sines, cosines;
  for (int64_t i = 0; i < n; ++i) {
    sines.push_back(std::sin(h * double(i)));
    cosines.push_back(std::cos(h * double(i)));
  }
  const auto flow = [&](int c, const Index3& p) {
    return sines[size_t(p[size_t(c + 2) % 3])] + cosines[size_t(p[size_t(c + 1) % 3])];
  };
  const FieldSpec u{"u", 3, [&](int c, const Index3& p, glm::dvec3) { return flow(c, p); }};
  const WholeField curl = derived("curl(u)", std::vector{u}, grid);
  const double factor = std::sin(h) / h;
  EXPECT_NEAR(factor, 0.99959211, 5e-9);
  double most = 0, dot = 0, squares = 0;
  test::forPoints({{1, 1, 1}, {n - 2, n - 2, n - 2}}, [&](const Index3& p) {
    for (int c = 0; c < 3; ++c) {
      const double found = curl.at(p, c);
      most = std::max(most, std::abs(found - factor * flow(c, p)));
      dot += found * flow(c, p);
      squares += flow(c, p) * flow(c, p);
    }
  });
  EXPECT_LE(std::abs(dot / squares - factor), 1e-7);
  EXPECT_LE(most, 4e-6) << "the samples' rounding to float, over 2 h";
}

TEST(Derive, PointsWithoutDataHaveOneSidedDifferences) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {12, 4, 3}};
  // Along x: values are x^2 but for holes at 3 and 6, 8, 9, which leave runs of lengths 3, 2, 1, 2.
  const auto isHole = [](int64_t x) { return x == 3 || x == 6 || x == 8 || x == 9; };
  FieldSpec field{"f", 1, [&](int, const Index3& p, glm::dvec3) {
                    return isHole(p[0]) ? (p[0] == 6 ? INFINITY : NAN) : double(p[0] * p[0]);
                  }};
  const WholeField d = derived("grad(f).x", std::vector{field}, grid);
  expectNoErrors(d);
  const double expected[] = {0, 2, 4, NAN, 9, 9, NAN, 0, NAN, NAN, 21, 21};
  for (int64_t x = 0; x < 12; ++x) {
    const double found = d.at({x, 1, 1});
    EXPECT_TRUE(found == expected[x] || (std::isnan(found) && std::isnan(expected[x]))) << x << ": " << found;
  }
  EXPECT_EQ(d.noData, 4 * 12);
  EXPECT_EQ(d.noDataSamples, 4 * 12);
  const WholeField second = derived("laplacian(f)", std::vector{field}, grid);
  const double curves[] = {2, 2, 2, NAN, 0, 0, NAN, 0, NAN, NAN, 0, 0};
  for (int64_t x = 0; x < 12; ++x) {
    const double found = second.at({x, 1, 1});
    EXPECT_TRUE(found == curves[x] || (std::isnan(found) && std::isnan(curves[x]))) << x << ": " << found;
  }
}

TEST(Derive, TinyGridsHaveDerivatives) {
  const std::vector<FieldSpec> fields{scalarField("f", [](glm::dvec3 p) { return 2 * p.x + 3 * p.y - p.z; })};
  for (const Index3& points : {Index3{2, 2, 2}, Index3{2, 2, 9}, Index3{17, 2, 2}, Index3{3, 2, 4}}) {
    const Grid grid{{1, 2, 3}, {0.5, 2, 1}, points};
    const WholeField grad = derived("grad(f)", fields, grid);
    expectNoErrors(grad);
    EXPECT_EQ(worst(grad, 0, [](glm::dvec3) { return 2; }), 0);
    EXPECT_EQ(worst(grad, 1, [](glm::dvec3) { return 3; }), 0);
    EXPECT_EQ(worst(grad, 2, [](glm::dvec3) { return -1; }), 0);
  }
}

TEST(Derive, DataOfCellsAreDifferencedAtTheirCentres) {
  Grid grid{{-0.5, -0.5, -0.5}, {1, 1, 1}, {9, 8, 3}};
  grid.rim = true;
  const std::vector<FieldSpec> fields{scalarField("f", [](glm::dvec3 p) { return 2 * p.x + 3 * p.y * p.y; })};
  const WholeField grad = derived("grad(f)", fields, grid);
  expectNoErrors(grad);
  EXPECT_EQ(worst(grad, 0, [](glm::dvec3) { return 2; }), 0) << "the rim too";
  EXPECT_EQ(worst(grad, 2, [](glm::dvec3) { return 0; }), 0) << "there is one layer";
  test::forPoints({{0, 0, 0}, grid.points}, [&](const Index3& p) {
    EXPECT_EQ(grad.at(p, 1), 6 * test::worldOf(grid, test::inside(grid, p)).y);
  });
  const WholeField where = derived("x + 10 * y + 100 * z", fields, grid);
  test::forPoints({{0, 0, 0}, grid.points}, [&](const Index3& p) {
    const glm::dvec3 centre = test::worldOf(grid, test::inside(grid, p));
    EXPECT_EQ(where.at(p), double(float(centre.x + 10 * centre.y + 100 * centre.z)));
  });
}

TEST(Derive, PointwiseFunctionsAreThoseOfTheLibrary) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {19, 7, 5}};
  const std::vector<FieldSpec> fields{noise("s", 1, 1), noise("v", 3, 2)};
  const WholeField found = derived("sqrt(s * s + 1) * sin(s) + mag(v)", fields, grid);
  expectNoErrors(found);
  test::forPoints({{0, 0, 0}, grid.points}, [&](const Index3& p) {
    const auto sample = [&](size_t f, int c) { return double(float(fields[f].value(c, p, {}))); };
    const double s = sample(0, 0), a = sample(1, 0), b = sample(1, 1), c = sample(1, 2);
    EXPECT_FLOAT_EQ(float(found.at(p)),
                    float(std::sqrt(s * s + 1) * std::sin(s) + std::sqrt(a * a + b * b + c * c)));
  });
  const WholeField other = derived(
      "if(v.x > 0 and not s < -0.5, [clamp(s, 0, 0.5), max(s, v.y, v.z), floor(8 * s)], 2 * v - [1, s, v.x ^ "
      "2])",
      fields, grid);
  test::forPoints({{0, 0, 0}, grid.points}, [&](const Index3& p) {
    const auto sample = [&](size_t f, int c) { return double(float(fields[f].value(c, p, {}))); };
    const double s = sample(0, 0), a = sample(1, 0), b = sample(1, 1), c = sample(1, 2);
    const bool holds = a > 0 && !(s < -0.5);
    const double expected[] = {holds ? std::clamp(s, 0.0, 0.5) : 2 * a - 1,
                               holds ? std::max({s, b, c}) : 2 * b - s,
                               holds ? std::floor(8 * s) : 2 * c - a * a};
    for (int i = 0; i < 3; ++i) EXPECT_EQ(other.at(p, i), double(float(expected[i]))) << i;
  });
}

TEST(Derive, LogicalResultsAreBytesAndNoDataIsCounted) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {5, 4, 3}};
  const std::vector<FieldSpec> fields{
      {"f", 1, [](int, const Index3& p, glm::dvec3) { return p[0] == 2 ? NAN : double(p[0]); }}};
  const WholeField found = derived("f > 1", fields, grid);
  expectNoErrors(found);
  EXPECT_EQ(found.stored, ScalarType::UInt8);
  const double expected[] = {0, 0, 0, 1, 1};
  for (int64_t x = 0; x < 5; ++x) EXPECT_EQ(found.at({x, 1, 1}), expected[x]);
  EXPECT_EQ(found.noData, 12);
  EXPECT_EQ(derived("nodata(f)", fields, grid).at({2, 1, 1}), 1);
  EXPECT_EQ(derived("nodata(f)", fields, grid).noData, 0);
  EXPECT_EQ(derived("if(nodata(f), -1, f)", fields, grid).at({2, 1, 1}), -1);
}

TEST(Derive, WhatDoesNotExistIsNoDataAndCounted) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {5, 4, 3}};
  const std::vector<FieldSpec> fields{scalarField("f", [](glm::dvec3 p) { return p.x - 2; })};
  for (const auto& [text, count] : {std::pair{"1 / f", 12},
                                    {"sqrt(f)", 24},
                                    {"log(f)", 36},
                                    {"f * 1e300", 48},
                                    {"norm([f, 0, 0])", 12},
                                    {"if(f > 0, f, nodata)", 36},
                                    {"f + 1 / 0", 60}}) {
    const WholeField found = derived(text, fields, grid);
    expectNoErrors(found);
    EXPECT_EQ(found.noData, count) << text;
    EXPECT_EQ(found.noDataSamples, count) << text;
  }
}

TEST(Derive, TypesOfSamplesAndWideValuesAreRead) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {9, 5, 4}};
  for (const ScalarType type : {ScalarType::Int8, ScalarType::UInt8, ScalarType::Int16, ScalarType::UInt16,
                                ScalarType::Float32, ScalarType::Float64, ScalarType::Int32}) {
    FieldSpec field = scalarField("f", [](glm::dvec3 p) { return p.x + 2 * p.y; });
    field.type = type;
    const WholeField found = derived("grad(f) + f * [1, 1, 1]", std::vector{field}, grid);
    EXPECT_EQ(worst(found, 1, [](glm::dvec3 p) { return 2 + p.x + 2 * p.y; }), 0) << nameOf(type);
  }
  FieldSpec field = scalarField("f", [](glm::dvec3 p) { return 101325 + 0.01 * p.x; });
  field.type = ScalarType::Float64;
  EXPECT_LE(worst(derived("grad(f).x", std::vector{field}, grid), 0, [](glm::dvec3) { return 0.01; }), 1e-8)
      << "the shift keeps the signal of wide values";
}

const char* const kMany =
    "[dot(cross(curl(u), grad(f * f)), norm(u)), laplacian(mag(u)) + q(u) + lambda2(u), "
    "div(grad(laplacian(f))) + div(f * curl(curl(u + [y, z, x]))) + max(f, mean(f)) * quantile(mag(u), 0.3)]";

void expectSame(const WholeField& one, const WholeField& other, const std::string& what) {
  expectNoErrors(other);
  ASSERT_EQ(one.values.size(), other.values.size()) << what;
  EXPECT_EQ(std::memcmp(one.values.data(), other.values.data(), one.values.size() * sizeof(float)), 0)
      << what;
  EXPECT_EQ(one.ranges, other.ranges) << what;
  EXPECT_EQ(one.noData, other.noData) << what;
  EXPECT_EQ(one.noDataSamples, other.noDataSamples) << what;
  EXPECT_EQ(one.stored, other.stored) << what;
  EXPECT_EQ(one.scale, other.scale) << what;
}

/// Some fields, with holes.
std::vector<FieldSpec> holedFields(uint64_t seed, bool holes) {
  std::vector<FieldSpec> fields{noise("f", 1, seed), noise("u", 3, seed + 1)};
  for (FieldSpec& field : fields) {
    const auto whole = field.value;
    field.value = [whole, holes, seed](int c, const Index3& p, glm::dvec3 world) {
      Random random(seed + 99 + uint64_t(p[0] + 1000 * (p[1] + 1000 * p[2])) * 15485863);
      random.next();
      return holes && random.oneIn(9) ? (random.oneIn(3) ? INFINITY : NAN) : whole(c, p, world);
    };
  }
  return fields;
}

TEST(Derive, BitsDoNotDependOnPartitionsOrRanks) {
  for (int seed = 0; seed < test::seeds(6); ++seed) {
    Grid grid{{0.5, -3, 1e6}, {0.1, 0.2, 0.3}, {15, 18, 14}};
    if (seed % 3 == 1) grid = {{0, 0, 0}, {1, 1e4, 1}, {5, 9, 33}};
    grid.rim = seed % 3 == 2;
    const auto fields = holedFields(uint64_t(seed), seed % 2 == 1);
    const WholeField one = derived(kMany, fields, grid);
    expectNoErrors(one);
    const int ranks = 1 + seed % 5;
    std::mt19937 random{unsigned(seed)};
    for (const int parts : {7, 64}) {
      expectSame(one, derived(kMany, fields, grid, decomposed(grid, parts, ranks), ranks),
                 std::to_string(parts) + " blocks");
      expectSame(
          one,
          derived(kMany, fields, grid, test::randomPartitioning(random, grid.box(), parts, ranks), ranks),
          std::to_string(parts) + " k-d boxes");
    }
    if (HasFailure()) FAIL() << "seed " << seed;
  }
}

TEST(Derive, PartitionsMayBeOneCellOrThinner) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {17, 4, 3}};
  const auto fields = holedFields(5, true);
  const WholeField one = derived(kMany, fields, grid);
  for (const int parts : {16, 48}) {
    const Partitioning slabs = Partitioning::lattice(
        {evenFaces(0, 16, parts, 0), std::vector<double>{0, 3}, std::vector<double>{0, 2}}, 5);
    expectSame(one, derived(kMany, fields, grid, slabs, 5), std::to_string(parts) + " slabs");
  }
  Grid rim = grid;
  rim.rim = true;
  const WholeField cells = derived(kMany, fields, rim);
  const Box box = rim.box();
  const Partitioning thin =
      Partitioning::lattice({evenFaces(box.lo.x, box.hi.x, 31, 0), std::vector<double>{box.lo.y, box.hi.y},
                             std::vector<double>{box.lo.z, box.hi.z}},
                            3);
  expectSame(cells, derived(kMany, fields, rim, thin, 3), "a rim in thin slabs");
}

TEST(Derive, DomainsMayEndInsideTheOutermostCellsOrBeyondThem) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {9, 8, 7}};
  const auto fields = holedFields(7, true);
  std::mt19937 random{3};
  for (const Box& domain : {Box{{0.5, 0.5, 0.5}, {7.5, 6.5, 5.5}}, Box{{-2, -3, 0}, {8, 9, 7.5}}})
    for (const char* text : {"curl(u)", "laplacian(f)", "f > u.x", "jacobian(u)"}) {
      const Partitioning cut = test::randomPartitioning(random, domain, 6, 3);
      expectSame(derived(text, fields, grid), derived(text, fields, grid, cut, 3), text);
    }
}

TEST(Derive, RanksMayOwnNothing) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {9, 8, 7}};
  const auto fields = holedFields(4, false);
  expectSame(derived(kMany, fields, grid), derived(kMany, fields, grid, decomposed(grid, 2, 2), 5),
             "3 of 5 ranks");
}

TEST(Derive, BitsDoNotDependOnTiles) {
  // More than one tile along each axis, and rows that are cut.
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {1031, 37, 3}}, deep{{0, 0, 0}, {1, 1, 1}, {5, 3, 150}};
  const auto fields = holedFields(6, true);
  for (const Grid& g : {grid, deep}) {
    const char* text = "curl(u) + grad(laplacian(f) * x)";
    expectSame(derived(text, fields, g), derived(text, fields, g, decomposed(g, 11, 2), 2), "11 blocks");
  }
}

TEST(Derive, ScalesOf1e30AndOffsetsOf1e6KeepTheirSignal) {
  const std::vector<FieldSpec> unit{scalarField("f", [](glm::dvec3 p) { return p.x; })};
  for (const double scale : {1e-30, 1e30}) {
    const Grid grid{{0, 0, 0}, glm::dvec3(scale), {6, 5, 4}};
    EXPECT_LE(worst(derived("grad(f).x", unit, grid), 0, [](glm::dvec3) { return 1; }), 4 * kUlp) << scale;
    // The values themselves are as small or as large as the spacing.
    EXPECT_LE(worst(derived("grad(x * 2).x", unit, grid), 0, [](glm::dvec3) { return 2; }), 0) << scale;
    const std::vector<FieldSpec> scaled{scalarField("f", [scale](glm::dvec3 p) { return p.x * scale; })};
    const Grid plain{{0, 0, 0}, {1, 1, 1}, {6, 5, 4}};
    EXPECT_LE(worst(derived("grad(f).x", scaled, plain), 0, [scale](glm::dvec3) { return scale; }),
              4 * kUlp * scale)
        << scale;
  }
  const Grid far{{1e6, -1e6, 1e6}, {1, 1, 1}, {6, 5, 4}};
  const std::vector<FieldSpec> wave{scalarField("f", [](glm::dvec3 p) { return p.x - 1e6; })};
  EXPECT_EQ(worst(derived("grad(f).x + x", wave, far), 0, [](glm::dvec3 p) { return 1 + p.x; }), 0);
}

TEST(Derive, BitsDoNotDependOnTheModeOfTheProcessor) {
  // Some samples and some results are denormal as float, and some values as double.
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {19, 17, 9}};
  const std::vector<FieldSpec> fields{{"f", 1, [](int, const Index3& p, glm::dvec3) {
                                         return std::exp2(double(-130 - p[0]) + double(p[1]));
                                       }}};
  SingleRank ranks;
  const auto inputs = test::inputsOf(fields, grid, Partitioning::single(grid.box()), ranks);
  const Expression text(
      "[f * 0.5, exp(-700 - f - x) / exp(-720 - x), grad(f).x] + (sum(f) + quantile(f, 0.3)) * [1, 0, 0]");
  const DerivedField plain = derive(text, inputs, ranks);
  DerivedField flushed;
  // oneTBB gives its tasks the mode that a thread has when it first calls it.
  std::thread([&] {
    _mm_setcsr(_mm_getcsr() |
               0x8040);  // results are flushed to zero, and denormal operands are taken as zero
    flushed = derive(text, inputs, ranks);
  }).join();
  EXPECT_EQ(plain.volume->blocks.at(0).samples, flushed.volume->blocks.at(0).samples);
  EXPECT_EQ(plain.volume->ranges, flushed.volume->ranges);
  EXPECT_GT(plain.volume->ranges[1].max, 4e8) << "e^20: what is denormal is not lost";
}

TEST(Derive, QueriesAreNumbersOfTheWholeField) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {5, 4, 3}};
  const std::vector<FieldSpec> fields{scalarField("f", [](glm::dvec3 p) { return p.x + 10 * p.y; })};
  for (const auto& [text, value] : {std::pair{"max(f)", 34.0},
                                    {"min(f)", 0},
                                    {"mean(f)", 17},
                                    {"sum(f)", 1020},
                                    {"quantile(f, 0.5)", 17},
                                    {"max(f + max(f) * 2)", 102},
                                    {"max(grad(f).y)", 10},
                                    {"quantile(f, 1 / 2 + min(f)) + 1", 18},
                                    {"max(f, 5) - f + min(f)", 0}}) {
    const WholeField found = derived("f * 0 + " + std::string(text), fields, grid, decomposed(grid, 3, 2), 2);
    expectNoErrors(found);
    EXPECT_EQ(found.at({4, 3, 2}), value) << text;
  }
  test::ThreadRanks two(2);
  const auto errors = two.run([&](Collectives& ranks) {
    const auto inputs = test::inputsOf(fields, grid, decomposed(grid, 3, 2), ranks);
    EXPECT_EQ(numberOf(Expression("max(f) > 30 and min(f) == 0"), inputs, ranks), 1);
    EXPECT_EQ(numberOf(Expression("mean(f) * 2"), inputs, ranks), 34);
    EXPECT_TRUE(std::isnan(numberOf(Expression("max(log(-1 - f))"), inputs, ranks)));
  });
  EXPECT_EQ(errors, std::vector<std::string>(2));
}

TEST(Derive, TimeIsThatOfTheInputs) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {3, 3, 3}};
  const std::vector<FieldSpec> fields{scalarField("f", [](glm::dvec3 p) { return p.x; })};
  DeriveOptions options;
  options.time = 2.5;
  EXPECT_EQ(derived("f * time", fields, grid, options).at({2, 0, 0}), 5);
  EXPECT_EQ(derived("f * time", fields, grid).errors[0],
            "expression, line 1, column 5: the time of the inputs is not known");
}

/// What went wrong on each rank when two fields were given with different grids or partitionings.
std::vector<std::string> errorsOf(const std::string& text, const Grid& one, const Grid& other,
                                  const Partitioning& cut, const Partitioning& otherCut) {
  test::ThreadRanks two(2);
  const FieldSpec f = scalarField("f", [](glm::dvec3 p) { return p.x; }),
                  g = scalarField("g", [](glm::dvec3 p) { return p.y; });
  return two.run([&](Collectives& ranks) {
    auto inputs = test::inputsOf(std::vector{f}, one, cut, ranks);
    inputs.push_back(test::inputsOf(std::vector{g}, other, otherCut, ranks)[0]);
    derive(Expression(text), inputs, ranks);
  });
}

TEST(Derive, WrongInputsAreErrorsOnAllRanks) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {9, 8, 7}}, finer{{0, 0, 0}, {0.5, 0.5, 0.5}, {17, 15, 13}};
  const Partitioning cut = decomposed(grid, 4, 2), otherCut = decomposed(grid, 3, 2);
  const auto expect = [&](const std::vector<std::string>& errors, const std::string& message) {
    EXPECT_EQ(errors[0], "rank 0: " + message);
    EXPECT_EQ(errors[1], "rank 0: " + message);
  };
  EXPECT_EQ(errorsOf("f + g", grid, grid, cut, cut), std::vector<std::string>(2));
  expect(errorsOf("f + g", grid, finer, cut, cut),
         "expression: `f` and `g` have different grids, expected one grid; Resample puts a field on "
         "another's grid");
  expect(errorsOf("f + g", grid, grid, cut, otherCut),
         "expression: `f` and `g` are cut into different partitions, expected the same ones; import `g` like "
         "`f`");
  expect(errorsOf("f + h", grid, grid, cut, cut),
         "expression, line 1, column 5: unknown name `h`, expected one of the inputs `f`, `g`");
  expect(errorsOf("max(f)", grid, grid, cut, cut),
         "expression: the result is a number, which is the same at all points, expected a field");
  expect(errorsOf("quantile(f, 1.5) + g", grid, grid, cut, cut),
         "expression, line 1, column 1: quantile() at 1.500000, expected a number from 0 to 1");
  SingleRank single;
  try {
    derive(Expression("x"), {}, single);
    FAIL();
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "expression: there are no inputs, expected at least one field");
  }
}

TEST(Derive, ACancelOrARefusalOnOneRankEndsAll) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {40, 30, 20}};
  const auto fields = holedFields(4, false);
  for (const int after : {0, 1, 5, 20, 60, 150}) {
    test::ThreadRanks three(3);
    const auto errors = three.run([&](Collectives& threadRank) {
      const auto inputs = test::inputsOf(fields, grid, decomposed(grid, 6, 3), threadRank);
      test::CancelledRanks ranks(threadRank, threadRank.rank() == 1 ? after : 1 << 30);
      derive(Expression(kMany), inputs, ranks);
    });
    EXPECT_EQ(errors, std::vector<std::string>(3, "rank 1: cancelled")) << after;
  }
  for (const int64_t limit : {0, 100000, 1000000, 1500000}) {
    test::ThreadRanks three(3);
    const auto errors = three.run([&](Collectives& ranks) {
      const auto inputs = test::inputsOf(fields, grid, decomposed(grid, 6, 3), ranks);
      DeriveOptions options;
      int64_t used = 0;
      options.memory = [&used, limit, rank = ranks.rank()](int64_t bytes) {
        if (rank == 2 && used + bytes > limit) throw Error("no more memory");
        used += bytes;
      };
      derive(Expression(kMany), inputs, ranks, options);
    });
    EXPECT_EQ(errors, std::vector<std::string>(3, "rank 2: no more memory")) << limit;
  }
}

TEST(Derive, MemoryThatIsNeededMeanwhileIsGivenBack) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {24, 16, 16}};
  const auto fields = holedFields(4, false);
  SingleRank ranks;
  const auto inputs = test::inputsOf(fields, grid, Partitioning::single(grid.box()), ranks);
  int64_t used = 0, most = 0;
  DeriveOptions options;
  options.memory = [&](int64_t bytes) {
    used += bytes;
    most = std::max(most, used);
  };
  const DerivedField found = derive(Expression(kMany), inputs, ranks, options);
  EXPECT_EQ(used, int64_t(found.volume->blocks.at(0).samples.size()));
  EXPECT_GT(most, used);
}

TEST(Derive, LongAndDeepExpressionsAreComputed) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {6, 5, 4}};
  const std::vector<FieldSpec> fields{scalarField("f", [](glm::dvec3 p) { return p.x; })};
  std::string sum = "f", deep = "f", steep = "f * f";
  for (int i = 1; i < 32000; ++i) sum += "+f";
  for (int i = 0; i < 63; ++i) deep = "(1 + " + deep + ")";
  for (int i = 0; i < 20; ++i) steep = "laplacian(f + " + steep + ")";
  EXPECT_EQ(derived(sum, fields, grid).at({2, 1, 1}), 64000);
  EXPECT_EQ(derived(deep, fields, grid).at({2, 1, 1}), 65);
  const WholeField nested = derived(steep, fields, grid, decomposed(grid, 5, 2), 2);
  expectNoErrors(nested);
  EXPECT_EQ(worst(nested, 0, [](glm::dvec3) { return 0; }), 0);
  std::string wide = "0";
  for (int i = 0; i < 1100; ++i) wide = "f * " + std::to_string(i) + " + " + wide;
  EXPECT_EQ(derived(wide, fields, grid).errors[0], "");
}

}  // namespace
}  // namespace gxy
