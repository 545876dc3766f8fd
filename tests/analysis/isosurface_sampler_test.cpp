// SPDX-License-Identifier: Apache-2.0
// Points on isosurfaces, from the filter IsosurfaceSampler.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "core/analysis/isosurface_filter.h"
#include "tests/analysis/sampled.h"
#include "tests/support/cell_meshes.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

constexpr double kArea = 4 * std::numbers::pi * 0.09;  // of the sphere with radius 0.3

WholeVolume sphereField(int64_t points) { return sampled(unitGrid(points), squaredDistance); }

SampledPoints isosurfacePoints(const WholeVolume& field, const Cut& cut, const std::string& properties,
                               const SamplingRanks::Run& run = {}) {
  return evaluateOn<IsosurfaceSampler>(cut, {run, {{"field", {&field}}}}, properties);
}

TEST(IsosurfaceSampler, TellsTheAreaOfASphere) {
  const WholeVolume field = sphereField(129);
  const auto count = sweep(100'000);
  const SampledPoints all = isosurfacePoints(field, whole(unitCube()),
                                             R"({"isovalue":0.09,"count":)" + std::to_string(count) + "}");
  const double area = all.told.at("area"), error = all.told.at("area error");
  EXPECT_NEAR(area, kArea, 3 * error);
  // A line has two hits or none: its variance is 4 p (1 - p), with p = area / surface of the cube.
  const double lines = all.told.at("lines"), p = kArea / 6;
  EXPECT_NEAR(error, 3 * std::sqrt(4 * p * (1 - p) / lines), 0.2 * error);
  EXPECT_EQ(all.told.at("particles"), count);
  EXPECT_FALSE(all.told.contains("found"));
  ASSERT_EQ(all.points.size(), size_t(count));
  EXPECT_EQ(all.points.rbegin()->first, uint64_t(count - 1));
}

TEST(IsosurfaceSampler, MakesTheSamePointsOnAnyRanksPartitionsThreadsAndPackets) {
  const WholeVolume field = sphereField(21),
                    values = sampled(unitGrid(7), [](glm::dvec3 p) { return p.x * p.y + p.z; });
  const std::string properties = R"({"isovalue":0.09,"count":3000,"seed":5})";
  const auto evaluated = [&](const Cut& cut, const SamplingRanks::Run& run) {
    return evaluateOn<IsosurfaceSampler>(cut, {run, {{"field", {&field}}, {"values", {&values}}}},
                                         properties);
  };
  const SampledPoints expected = evaluated(whole(unitCube()), {});
  ASSERT_EQ(expected.points.size(), 3000u);
  const Box box = unitCube();
  std::vector<Cut> cuts = {lattice(box, {7, 1, 1}, 2), lattice(box, {4, 4, 4}, 3),
                           lattice(box, {4, 4, 4}, 1), kdCut(box, 13, 4, 1),
                           kdCut(box, 29, 5, 2),       lattice(box, {2, 1, 1}, 5)};
  int packet = 16;
  for (const Cut& cut : cuts) {
    SamplingRanks::Run run;
    run.seed = uint64_t(packet);
    run.workers = 1 + packet % 3;
    run.options.packetRays = packet;
    packet = packet * 5 / 2;
    EXPECT_EQ(evaluated(cut, run), expected) << cut.name;
  }
}

/// A volume with three components.
WholeVolume ofThree(const Grid& grid, const std::function<glm::dvec3(glm::dvec3)>& field) {
  std::array<WholeVolume, 3> parts;
  for (int c = 0; c < 3; c++) parts[size_t(c)] = sampled(grid, [&](glm::dvec3 p) { return field(p)[c]; });
  WholeVolume whole = parts[0];
  whole.components = 3;
  const size_t n = whole.samples.size() / sizeof(float);
  whole.samples.resize(3 * n * sizeof(float));
  for (size_t i = 0; i < n; i++)
    for (size_t c = 0; c < 3; c++)
      std::memcpy(&whole.samples[(3 * i + c) * sizeof(float)], &parts[c].samples[i * sizeof(float)],
                  sizeof(float));
  return whole;
}

TEST(IsosurfaceSampler, RecordsSeveralFieldsAndTheGradientOnAnyRanks) {
  const WholeVolume field = sampled(unitGrid(17), [](glm::dvec3 p) { return p.x + 2 * p.y - p.z; });
  const WholeVolume vectors = ofThree(unitGrid(9), [](glm::dvec3 p) { return glm::dvec3(p.y, -p.x, 3); });
  const WholeVolume height = sampled(unitGrid(5), [](glm::dvec3 p) { return 5 * p.z; });
  const auto evaluated = [&](const Cut& cut) {
    return evaluateOn<IsosurfaceSampler>(cut, {{}, {{"field", {&field}}, {"values", {&vectors, &height}}}},
                                         R"({"isovalue":1,"count":500,"gradient":true})");
  };
  const SampledPoints all = evaluated(whole(unitCube()));
  ASSERT_EQ(all.points.size(), 500u);
  EXPECT_EQ(all.names, (std::vector<std::string>{"mag(values)", "values", "values 2", "gradient"}));
  EXPECT_EQ(all.told.at("fields").size(), 4u);
  EXPECT_EQ(all.told.at("fields").at(1).at("components"), 3);
  EXPECT_GE(all.told.at("fields").at(2).at("range").at(0), 0);
  for (const auto& [id, point] : all.points) {
    const glm::dvec3 p = point.first;
    const std::vector<double> expected{p.y, -p.x, 3, 5 * p.z, 1, 2, -1};
    ASSERT_EQ(all.fields.at(id).size(), expected.size());
    for (size_t c = 0; c < expected.size(); c++) ASSERT_NEAR(all.fields.at(id)[c], expected[c], 2e-5) << c;
    ASSERT_NEAR(point.second, std::sqrt(p.x * p.x + p.y * p.y + 9), 3e-3);
  }
  for (const Cut& cut : {lattice(unitCube(), {4, 4, 4}, 3), kdCut(unitCube(), 13, 4, 2)})
    EXPECT_EQ(evaluated(cut), all) << cut.name;
}

/// Cells of all types, whose values are squared distances from the middle.
WholeMesh sphereMesh(uint32_t n) {
  WholeMesh whole;
  whole.cells = cubeOfAllCells(
      n, [](glm::dvec3) { return glm::dvec3(0); }, [](glm::dvec3 p) { return glm::dot(p - 0.5, p - 0.5); });
  return whole;
}

TEST(IsosurfaceSampler, TakesUnstructuredVolumesOnAnyRanksAndPartitions) {
  const WholeMesh mesh = sphereMesh(20);
  const auto evaluated = [&](const Cut& cut) {
    return evaluateOn<IsosurfaceSampler>(cut, {{}, {}, {}, {{"field", &mesh}}},
                                         R"({"isovalue":0.09,"count":2000,"seed":3})");
  };
  const SampledPoints all = evaluated(whole(unitCube()));
  ASSERT_EQ(all.points.size(), 2000u);
  for (const auto& [id, point] : all.points) {
    const glm::dvec3 from = point.first - 0.5;
    ASSERT_NEAR(glm::dot(from, from), 0.09, 2e-3) << "the value is linear in cells of 1/20";
  }
  EXPECT_NEAR(double(all.told.at("area")), kArea, 3 * double(all.told.at("area error")) + 0.01 * kArea);
  for (const Cut& cut : {lattice(unitCube(), {4, 4, 4}, 3), kdCut(unitCube(), 13, 4, 2)})
    EXPECT_EQ(evaluated(cut), all) << cut.name;
}

TEST(IsosurfaceSampler, RefusesGradientsOfUnstructuredVolumes) {
  const WholeMesh mesh = sphereMesh(2);
  try {
    evaluateOn<IsosurfaceSampler>(whole(unitCube()), {{}, {}, {}, {{"field", &mesh}}},
                                  R"({"isovalue":0.09,"gradient":true})");
    FAIL() << "expected an error";
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(),
                 "IsosurfaceSampler: `gradient` is of \"field\", an unstructured volume, expected one on a "
                 "uniform grid");
  }
}

TEST(IsosurfaceSampler, RefusesMoreComponentsThanASamplingHas) {
  const WholeVolume field = sphereField(9);
  const WholeVolume vectors = ofThree(unitGrid(5), [](glm::dvec3 p) { return p; });
  try {
    evaluateOn<IsosurfaceSampler>(
        whole(unitCube()),
        {{}, {{"field", {&field}}, {"values", std::vector<const WholeVolume*>(6, &vectors)}}},
        R"({"isovalue":0.09})");
    FAIL() << "expected an error";
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(),
                 "IsosurfaceSampler: 19 components of fields are to be recorded, expected at most 16");
  }
}

TEST(IsosurfaceSampler, MakesTheSamePointsWithOneCredit) {
  const WholeVolume field = sphereField(9);
  const std::string properties = R"({"isovalue":0.09,"count":500})";
  SamplingRanks::Run run;
  run.options.raysInFlight = 1;
  EXPECT_EQ(isosurfacePoints(field, lattice(unitCube(), {2, 2, 2}, 3), properties, run),
            isosurfacePoints(field, whole(unitCube()), properties));
}

TEST(IsosurfaceSampler, RepeatsASeedAndTakesOtherPointsForAnother) {
  const WholeVolume field = sphereField(9);
  const SampledPoints one =
      isosurfacePoints(field, whole(unitCube()), R"({"isovalue":0.09,"count":100,"seed":1})");
  EXPECT_EQ(isosurfacePoints(field, whole(unitCube()), R"({"isovalue":0.09,"count":100,"seed":1})"), one);
  const SampledPoints other =
      isosurfacePoints(field, whole(unitCube()), R"({"isovalue":0.09,"count":100,"seed":2})");
  for (const auto& [id, point] : one.points) EXPECT_NE(other.points.at(id), point);
}

TEST(IsosurfaceSampler, TakesThePrefixOfAllHits) {
  const WholeVolume field = sphereField(9);
  const SampledPoints few = isosurfacePoints(field, whole(unitCube()), R"({"isovalue":0.09,"count":77})");
  const SampledPoints many = isosurfacePoints(field, whole(unitCube()), R"({"isovalue":0.09,"count":5000})");
  ASSERT_EQ(few.points.size(), 77u);
  for (const auto& [id, point] : few.points) EXPECT_EQ(many.points.at(id), point);
}

TEST(IsosurfaceSampler, AnEmptyIsosurfaceHasNoPoints) {
  const SampledPoints none =
      isosurfacePoints(sphereField(9), lattice(unitCube(), {2, 2, 2}, 3), R"({"isovalue":7,"count":100})");
  EXPECT_TRUE(none.points.empty());
  EXPECT_EQ(none.told.at("area"), 0);
  EXPECT_EQ(none.told.at("found"), 0);
  EXPECT_EQ(none.told.at("count"), 100);
}

TEST(IsosurfaceSampler, SaysHowManyItHasFoundOfASmallSurface) {
  // An octahedron with an area of 4.3e-5: of 1e6 lines 14 meet it.
  Grid grid = unitGrid(5);
  const WholeVolume field = sampled(grid, [](glm::dvec3 p) { return p == glm::dvec3(0.5) ? 1 : 0; });
  const SampledPoints some = isosurfacePoints(field, whole(unitCube()), R"({"isovalue":0.99,"count":200})");
  EXPECT_GT(some.points.size(), 2u);
  EXPECT_LT(some.points.size(), 60u);
  EXPECT_EQ(some.told.at("found"), some.points.size());
  EXPECT_GE(some.told.at("lines"), 1'200'000);
  for (const auto& [id, point] : some.points) EXPECT_LT(squaredDistance(point.first), 6.3e-6);
}

TEST(IsosurfaceSampler, FindsASurfaceThatPassesThroughEveryCell) {
  const WholeVolume field = sampled(unitGrid(17), [](glm::dvec3 p) {
    const glm::ivec3 i = p * 16.0 + 0.5;
    return (i.x + i.y + i.z) % 2 ? 1 : -1;
  });
  const std::string properties = R"({"isovalue":0,"count":20000})";
  const SampledPoints all = isosurfacePoints(field, whole(unitCube()), properties);
  EXPECT_EQ(all.points.size(), 20'000u);
  EXPECT_EQ(isosurfacePoints(field, lattice(unitCube(), {3, 2, 2}, 4), properties), all);
  // It is the planes through the middles of the cells: 16 of area 1 along each axis.
  EXPECT_NEAR(all.told.at("area"), 48.0, 3 * double(all.told.at("area error")));
}

TEST(IsosurfaceSampler, EndsWhereTheIsovalueIsTheLeastValue) {
  const WholeVolume valley = sampled(unitGrid(9), [](glm::dvec3 p) { return std::abs(p.x - 0.5); });
  const WholeVolume constant = sampled(unitGrid(9), [](glm::dvec3) { return 2; });
  const Cut cut = lattice(unitCube(), {2, 2, 1}, 3);
  for (const auto& [field, isovalue] : {std::pair(&valley, "0"), std::pair(&constant, "2")}) {
    const std::string properties = R"({"count":300,"isovalue":)" + std::string(isovalue) + "}";
    EXPECT_EQ(isosurfacePoints(*field, cut, properties),
              isosurfacePoints(*field, whole(unitCube()), properties))
        << isovalue;
  }
}

TEST(IsosurfaceSampler, LeavesOutWhereThereAreNoData) {
  const auto hole = [](glm::dvec3 p) { return p.x > 0.5 && p.y > 0.5 && p.z > 0.5; };
  const WholeVolume field = sampled(unitGrid(41), [&](glm::dvec3 p) {
    return hole(p) ? std::numeric_limits<double>::quiet_NaN() : squaredDistance(p);
  });
  const SampledPoints all =
      isosurfacePoints(field, lattice(unitCube(), {3, 2, 2}, 3), R"({"isovalue":0.09,"count":20000})");
  for (const auto& [id, point] : all.points) EXPECT_FALSE(hole(point.first));
  const double area = all.told.at("area"), error = all.told.at("area error");
  EXPECT_NEAR(area, kArea * 7 / 8, 3 * error + 0.01 * kArea);
}

TEST(IsosurfaceSampler, ACancelledOneEndsWithTheSameErrorOnAllRanks) {
  const WholeVolume field = sphereField(33);
  std::atomic<int> checks = 0;
  Evaluation evaluation{{}, {{"field", {&field}}}};
  evaluation.check = [&](int rank) {
    if (rank == 1 && ++checks > 20) throw Error("it was cancelled");
  };
  SampledPoints nothing;
  const auto errors = evaluateOn<IsosurfaceSampler>(lattice(unitCube(), {2, 2, 2}, 3), evaluation,
                                                    R"({"isovalue":0.09,"count":100000000})", nothing);
  for (const std::string& error : errors) EXPECT_EQ(error, "rank 1: it was cancelled");
}

TEST(IsosurfaceSampler, ARankWithoutRoomFailsAllWithItsError) {
  const WholeVolume field = sphereField(17);
  for (const char* full : {"samples", "geometry", "scene"}) {
    Evaluation evaluation{{}, {{"field", {&field}}}};
    evaluation.memory = [&](int rank, const std::string& purpose) -> LedgerEntry {
      if (rank == 2 && purpose == full) throw Error("no room for " + purpose);
      return {};
    };
    SampledPoints nothing;
    for (const std::string& error : evaluateOn<IsosurfaceSampler>(
             lattice(unitCube(), {2, 2, 2}, 3), evaluation, R"({"isovalue":0.09,"count":1000})", nothing))
      EXPECT_EQ(error, "rank 2: no room for " + std::string(full));
  }
}

TEST(IsosurfaceSampler, RefusesWhatCannotBe) {
  const WholeVolume field = sphereField(9);
  const auto errorOf = [&](const std::string& properties) {
    SampledPoints nothing;
    try {
      return evaluateOn<IsosurfaceSampler>(whole(unitCube()), {{}, {{"field", {&field}}}}, properties,
                                           nothing)
          .at(0);
    } catch (const Error& e) {
      return std::string(e.what());
    }
  };
  EXPECT_NE(errorOf(R"({"isovalue":0.09,"component":2})").find("has 1 (counted from 0)"), std::string::npos);
  EXPECT_NE(errorOf(R"({"isovalue":0.09,"count":0})").find("count"), std::string::npos);
  EXPECT_NE(errorOf("{}").find("isovalue"), std::string::npos);
}

}  // namespace
}  // namespace gxy::test
