// SPDX-License-Identifier: Apache-2.0
// Statistics of unstructured volumes.
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/analysis/statistics_filter.h"
#include "tests/analysis/filter_setup.h"
#include "tests/support/cell_meshes.h"
#include "tests/support/meshes.h"

namespace gxy::test {
namespace {

using nlohmann::json;

const Box kStatisticsBox{{0, 0, 0}, {1, 1, 1}};

/// What Statistics tells of a mesh, the same on all ranks.
json numbersOf(const WholeMesh& whole, const Cut& cut, const std::string& properties) {
  std::vector<json> told(static_cast<size_t>(cut.ranks));
  ThreadRanks world(cut.ranks);
  const auto errors = world.run([&](Collectives& ranks) {
    const auto mesh = std::make_shared<Dataset>();
    mesh->partitioning = std::make_shared<const Partitioning>(cut.partitioning);
    mesh->mesh = test::cut(whole, cut.partitioning, cut.ranks)[size_t(ranks.rank())];
    FilterRun run(ranks, {{"field", {{"f", {}, 1, mesh}}}}, freeServices());
    told[size_t(ranks.rank())] = evaluate(*makeFilter<StatisticsFilter>(), run, properties).told;
  });
  for (const std::string& error : errors)
    if (!error.empty()) return error;
  for (const json& one : told) EXPECT_EQ(one, told[0]) << cut.name;
  return told[0];
}

glm::dvec3 stays(glm::dvec3) { return glm::dvec3(0); }

TEST(MeshStatistics, CountEachPointOnce) {
  WholeMesh whole;
  whole.cells = cubeOfTets(4, stays, [](glm::dvec3 p) { return 4 * p.x; });
  for (const Cut& cut : manyCuts(kStatisticsBox, 3)) {
    const json told = numbersOf(whole, cut, R"({"histogram": 5, "quantiles": [0.5, 1]})");
    EXPECT_EQ(told.at("count"), 125) << cut.name;
    EXPECT_EQ(told.at("no data"), 0);
    EXPECT_EQ(told.at("sum"), 250);
    EXPECT_EQ(told.at("mean"), 2);
    EXPECT_EQ(told.at("variance"), 2);
    EXPECT_EQ(told.at("least"), (json{{"value", 0}, {"position", {0, 0, 0}}}));
    EXPECT_EQ(told.at("largest"), (json{{"value", 4}, {"position", {1, 0, 0}}})) << "first along the curve";
    EXPECT_EQ(told.at("histogram").at("counts"), (json{25, 25, 25, 25, 25}));
    EXPECT_EQ(told.at("quantiles"), (json{2, 4}));
    EXPECT_EQ(told.at("values"), "points");
    EXPECT_FALSE(told.contains("integral"));
  }
}

TEST(MeshStatistics, CountEachCellOnceIfTheValuesAreThoseOfCells) {
  WholeMesh whole;
  whole.cells = withCellValues(cubeOfHexes(4, stays, [](glm::dvec3) { return 0; }),
                               [](glm::dvec3 p) { return std::floor(4 * p.x); });
  whole.cells.cellValues[size_t(CellType::Hexahedron)][63] = std::numeric_limits<float>::infinity();
  for (const Cut& cut : manyCuts(kStatisticsBox, 3)) {
    const json told = numbersOf(whole, cut, "{}");
    EXPECT_EQ(told.at("count"), 63) << cut.name;
    EXPECT_EQ(told.at("no data"), 1);
    EXPECT_EQ(told.at("sum"), 16 * (0 + 1 + 2 + 3) - 3);
    EXPECT_EQ(told.at("least"), (json{{"value", 0}, {"position", {0.125, 0.125, 0.125}}}));
    EXPECT_EQ(told.at("largest"), (json{{"value", 3}, {"position", {0.875, 0.125, 0.125}}}));
    EXPECT_EQ(told.at("values"), "cells");
  }
}

TEST(MeshStatistics, HaveTheSameBitsOnAnyPartitionsAndRanks) {
  const auto bend = [](glm::dvec3 p) { return 0.02 * glm::dvec3(p.y, p.z, p.x) * p * (1.0 - p); };
  const auto wild = [](glm::dvec3 p) {
    const double x = std::sin(1e4 * (p.x + 2 * p.y + 3 * p.z));
    return x > 0.9 ? double(NAN) : std::exp2(40 * x) * (x > 0.3 ? -1 : 1);
  };
  for (const int components : {1, 3})
    for (const bool ofCells : {false, true}) {
      WholeMesh whole;
      whole.cells = cubeOfAllCells(3, bend, wild);
      if (ofCells) whole.cells = withCellValues(std::move(whole.cells), wild);
      const auto repeat = [&](std::vector<float>& values) {
        std::vector<float> all;
        for (const float v : values)
          for (int c = 0; c < components; c++) all.push_back(v * float(c + 1));
        values = all;
      };
      whole.cells.components = components;
      repeat(whole.cells.values);
      for (auto& values : whole.cells.cellValues) repeat(values);
      for (const char* more : {"", R"(, "component": 0)"}) {
        const std::string keys =
            R"({"histogram": 7, "quantiles": [0.1, 0.5, 0.999])" + std::string(more) + "}";
        const json one = numbersOf(whole, test::whole(kStatisticsBox), keys);
        ASSERT_TRUE(one.is_object()) << one;
        EXPECT_GT(one.at("no data"), 0);
        for (const Cut& cut : manyCuts(kStatisticsBox, 3))
          EXPECT_EQ(numbersOf(whole, cut, keys), one) << cut.name;
      }
    }
}

TEST(MeshStatistics, OfPointsOfAGridAreAnError) {
  WholeMesh whole;
  whole.cells = cubeOfTets(2, stays, [](glm::dvec3 p) { return p.x; });
  for (const char* key : {R"({"array": "v"})", R"({"where": "f > 1"})"}) {
    const json error = numbersOf(whole, test::whole(kStatisticsBox), key);
    ASSERT_TRUE(error.is_string()) << error;
    EXPECT_NE(error.get<std::string>().find("\"f\" is an unstructured volume"), std::string::npos) << error;
  }
}

}  // namespace
}  // namespace gxy::test
