// SPDX-License-Identifier: Apache-2.0
// Points where rays meet surfaces, from the filter RaySampler.
#include <gtest/gtest.h>

#include <cmath>

#include "core/analysis/ray_filter.h"
#include "tests/analysis/sampled.h"
#include "tests/support/cell_meshes.h"

namespace gxy::test {
namespace {

const WholeVolume& alongX() {
  static const WholeVolume volume = sampled(unitGrid(17), [](glm::dvec3 p) { return p.x; });
  return volume;
}
const WholeVolume& alongY() {
  static const WholeVolume volume = sampled(unitGrid(9), [](glm::dvec3 p) { return p.y; });
  return volume;
}

SampledPoints rayPoints(const std::string& properties, const Cut& cut = whole(unitCube())) {
  return evaluateOn<RaySampler>(cut, {{}, {{"x", {&alongX()}}, {"y", {&alongY()}}}}, properties);
}

TEST(RaySampler, TakesHitsWhereConditionsHold) {
  const std::string properties = R"({"operators":[{"dataset":"x","isovalues":[0.25,0.5,0.75],"hits":9,
    "conditions":[{"field":"y","range":[0.5,1]}]}],"lines":4000,"values":"y","seed":3})";
  const SampledPoints all = rayPoints(properties);
  EXPECT_GT(all.points.size(), 800u);
  EXPECT_EQ(all.told.at("rays"), 4000);
  for (const auto& [id, point] : all.points) {
    const auto [p, value] = point;
    EXPECT_NEAR(p.x, std::round(4 * p.x) / 4, 1e-6);
    EXPECT_GE(p.y, 0.5 - 1e-6);
    EXPECT_NEAR(value, p.y, 1e-6);
  }
  EXPECT_EQ(rayPoints(properties, kdCut(unitCube(), 11, 3, 4)), all);
}

TEST(RaySampler, RecordsSeveralFieldsByTheNamesOfItsInputs) {
  const std::string properties = R"({"operators":[{"dataset":"x","isovalues":[0.25,0.5],"hits":9,
    "conditions":[{"field":"y","range":[0.5,1]}]}],"lines":500,"values":["x","y"],"gradient":true})";
  const SampledPoints all = rayPoints(properties);
  EXPECT_EQ(all.names, (std::vector<std::string>{"x", "y", "gradient"}));
  EXPECT_GT(all.points.size(), 50u);
  for (const auto& [id, point] : all.points) {
    const glm::dvec3 p = point.first;
    EXPECT_NEAR(point.second, p.x, 1e-6);
    const std::vector<double> expected{p.y, 1, 0, 0};
    for (size_t c = 0; c < 4; c++) EXPECT_NEAR(all.fields.at(id).at(c), expected[c], 2e-5);
  }
  EXPECT_EQ(rayPoints(properties, kdCut(unitCube(), 11, 3, 4)), all);
}

TEST(RaySampler, RefusesAnInputThatIsCalledAsTheGradientsAre) {
  const Evaluation evaluation{{}, {{"gradient", {&alongX()}}}};
  const auto made = [&](const std::string& more) {
    return evaluateOn<RaySampler>(whole(unitCube()), evaluation,
                                  R"({"operators":[{"dataset":"gradient","isovalues":[0.5]}],"lines":100,
                                      "values":"gradient")" +
                                      more + "}");
  };
  EXPECT_EQ(made("").names, (std::vector<std::string>{"gradient"}));
  try {
    made(R"(,"gradient":true)");
    FAIL() << "expected an error";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("expected another name or no `gradient`"), std::string::npos)
        << e.what();
  }
}

TEST(RaySampler, SendsRaysOfACameraAndOfADocument) {
  const SampledPoints camera = rayPoints(R"({"operators":[{"dataset":"x","planes":[[0,0,1,0.5]]}],
    "camera":{"viewpoint":[0.5,0.5,3],"viewdirection":[0,0,-1],"viewup":[0,1,0],"aov":0,"height":2,"dimensions":[40,40]}})");
  EXPECT_EQ(camera.points.size(), 400u);  // a quarter of the pixels
  EXPECT_EQ(camera.told.at("rays"), 1600);
  EXPECT_NEAR(camera.points.at(0).first.x, 0.025, 1e-6);
  const SampledPoints two = rayPoints(
      R"({"operators":[{"dataset":"x","isovalues":[0.5]}],"rays":[[1e6,0.5,0.5,-2,0,0],[0,0.2,0.2,0,1,0]]})");
  ASSERT_EQ(two.points.size(), 1u);
  EXPECT_NEAR(two.points.at(0).first.x, 0.5, 1e-7);
}

TEST(RaySampler, MeetsSurfacesOfUnstructuredVolumes) {
  WholeMesh mesh;
  mesh.cells = cubeOfAllCells(
      4, [](glm::dvec3) { return glm::dvec3(0); }, [](glm::dvec3 p) { return p.x; });
  const auto evaluated = [&](const Cut& cut) {
    return evaluateOn<RaySampler>(
        cut, {{}, {{"y", {&alongY()}}}, {}, {{"m", &mesh}}},
        R"({"operators":[{"dataset":"m","isovalues":[0.3,0.6],"planes":[[0,0,1,0.45]],"hits":9}],"lines":2000,
            "values":"y","seed":3})");
  };
  const SampledPoints all = evaluated(whole(unitCube()));
  EXPECT_GT(all.points.size(), 1000u);
  size_t onPlane = 0;
  for (const auto& [id, point] : all.points) {
    const auto [p, value] = point;
    const double far = std::min({std::abs(p.x - 0.3), std::abs(p.x - 0.6), std::abs(p.z - 0.45)});
    ASSERT_LT(far, 2e-6);
    onPlane += std::abs(p.z - 0.45) < 2e-6;
    ASSERT_NEAR(value, p.y, 1e-6);
  }
  EXPECT_GT(onPlane, 200u);
  EXPECT_EQ(evaluated(kdCut(unitCube(), 11, 3, 4)), all);
  try {
    evaluateOn<RaySampler>(whole(unitCube()), {{}, {}, {}, {{"m", &mesh}}},
                           R"({"operators":[{"dataset":"m","isovalues":[0.3]}],"lines":20,"values":"m"})");
    FAIL() << "expected an error";
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "RaySampler: `values` is of \"m\", expected a volume on a uniform grid");
  }
}

TEST(RaySampler, RefusesWhatCannotBe) {
  const auto errorOf = [](const std::string& properties) {
    try {
      rayPoints(properties);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  const auto says = [&](const std::string& properties, const std::string& what) {
    EXPECT_NE(errorOf(properties).find(what), std::string::npos) << errorOf(properties);
  };
  says(R"({"operators":[],"lines":5})", "there are no `operators`");
  says(R"({"operators":[{"dataset":"x","isovalues":[1]}]})", "there are 0 sources of rays");
  says(R"({"operators":[{"dataset":"z","isovalues":[1]}],"lines":5})", "is of the input \"z\"");
  says(R"({"operators":[{"dataset":"x"}],"lines":5})", "has nothing to meet");
  says(R"({"operators":[{"dataset":"x","isovalues":[1],"hits":0}],"lines":5})", "hits");
  says(R"({"operators":[{"dataset":"x","isovalues":[1]}],"rays":[[0,0,0,0,0,0]]})",
       "a direction that is not 0");
}

}  // namespace
}  // namespace gxy::test
