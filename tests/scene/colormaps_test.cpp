// SPDX-License-Identifier: Apache-2.0
#include "core/scene/colormaps.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/scene/color_distance.h"
#include "tests/scene/scene_test_support.h"

namespace gxy {
namespace {

TEST(Evaluate, IsLinearBetweenPointsAndConstantOutside) {
  const OpacityMap map{false, {{-1, 0.2}, {1, 0.6}, {3, 0}}};
  EXPECT_DOUBLE_EQ(evaluate(map, -1e300), 0.2);
  EXPECT_DOUBLE_EQ(evaluate(map, -1), 0.2);
  EXPECT_DOUBLE_EQ(evaluate(map, 0), 0.4);
  EXPECT_DOUBLE_EQ(evaluate(map, 1), 0.6);
  EXPECT_DOUBLE_EQ(evaluate(map, 2), 0.3);
  EXPECT_DOUBLE_EQ(evaluate(map, 1e300), 0);
}

TEST(Evaluate, EqualValuesAreAStepThatHoldsFromThere) {
  const OpacityMap map{false, {{0, 0.1}, {1, 0.3}, {1, 0.5}, {1, 0.7}, {2, 0.9}}};
  EXPECT_NEAR(evaluate(map, std::nextafter(1.0, 0.0)), 0.3, 1e-15);
  EXPECT_EQ(evaluate(map, 1), 0.7);
  EXPECT_NEAR(evaluate(map, 1.5), 0.8, 1e-15);
}

TEST(Evaluate, StepsAtTheEndsHoldOutside) {
  const OpacityMap map{false, {{0, 0}, {0, 0.5}, {1, 0.5}, {1, 1}}};
  EXPECT_EQ(evaluate(map, -1), 0);
  EXPECT_EQ(evaluate(map, 0), 0.5);
  EXPECT_EQ(evaluate(map, 1), 1);
}

TEST(Evaluate, OnePointIsAConstant) {
  const ColorMap map{{{5, {0.1, 0.2, 0.3}}}};
  for (const double v : {-1e9, 5.0, 1e9}) EXPECT_EQ(evaluate(map, v), glm::dvec3(0.1, 0.2, 0.3));
}

TEST(Evaluate, ASpikeOfZeroWidthNeighboursIsNotMissed) {
  const OpacityMap map{false, {{0, 0}, {0.5, 0}, {0.5 + 1e-9, 1}, {0.5 + 2e-9, 0}, {1, 0}}};
  EXPECT_EQ(evaluate(map, 0.5 + 1e-9), 1);
}

TEST(Evaluate, ValuesNearTheEndsOfDoubleStayFinite) {
  const double big = std::numeric_limits<double>::max();
  const OpacityMap map{false, {{-big, 0}, {big, 1}}};
  EXPECT_DOUBLE_EQ(evaluate(map, 0), 0.5);
  EXPECT_DOUBLE_EQ(evaluate(map, big / 2), 0.75);
}

TEST(Rescaled, EndsLandOnTheRangeAndTheRestFollowsLinearly) {
  const OpacityMap map{false, {{2, 0.1}, {3, 0.2}, {3, 0.3}, {6, 0.4}}};
  const OpacityMap moved = rescaled(map, {-10, 10});
  const double expected[] = {-10, -5, -5, 10};
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_DOUBLE_EQ(moved.points[i].value, expected[i]);
    EXPECT_EQ(moved.points[i].opacity, map.points[i].opacity);
  }
}

TEST(Rescaled, AMapWithoutWidthMovesToTheLowerEnd) {
  EXPECT_EQ(rescaled(ColorMap{{{7, {1, 0, 0}}}}, {2, 3}).points[0].value, 2);
}

TEST(Rescaled, AVisIsMappedOverItsDataRange) {
  Vis vis;
  EXPECT_EQ(effectiveColorMap(vis), vis.colormap);
  vis.dataRange = {100, 300};
  EXPECT_NEAR(evaluate(effectiveColorMap(vis), 200).r, 0.7, 1e-15);  // halfway from 0.4 to 1
  EXPECT_EQ(evaluate(effectiveOpacityMap(vis), 200), 1);
}

struct Sample {
  int index;  // of 255
  glm::dvec3 rgb;
};

void expectSamples(const char* name, std::initializer_list<Sample> samples) {
  const auto map = shippedColorMap(name);
  ASSERT_TRUE(map) << name;
  for (const Sample& s : samples)
    EXPECT_LE(distance(evaluate(*map, s.index / 255.0), s.rgb), kLevel) << name << s.index;
}

// The values of the published tables at some of their 256 entries.
TEST(ShippedColorMaps, TabulatedMapsMatchTheirPublication) {
  expectSamples("Viridis", {{0, {0.267004, 0.004874, 0.329415}},
                            {51, {0.253935, 0.265254, 0.529983}},
                            {102, {0.163625, 0.471133, 0.558148}},
                            {153, {0.134692, 0.658636, 0.517649}},
                            {204, {0.477504, 0.821444, 0.318195}},
                            {255, {0.993248, 0.906157, 0.143936}}});
  expectSamples("Inferno", {{0, {0.001462, 0.000466, 0.013866}},
                            {51, {0.258234, 0.038571, 0.406485}},
                            {102, {0.578304, 0.148039, 0.404411}},
                            {153, {0.865006, 0.316822, 0.226055}},
                            {204, {0.987622, 0.64532, 0.039886}},
                            {255, {0.988362, 0.998364, 0.644924}}});
  expectSamples("Turbo", {{0, {0.18995, 0.07176, 0.23217}},
                          {51, {0.24427, 0.60937, 0.99697}},
                          {102, {0.27597, 0.97092, 0.51653}},
                          {153, {0.88331, 0.86553, 0.21719}},
                          {204, {0.94084, 0.35566, 0.07031}},
                          {255, {0.4796, 0.01583, 0.01055}}});
}

// Against VTK 9.1's vtkColorTransferFunction, diverging, between the same two ends.
TEST(ShippedColorMaps, CoolToWarmMatchesVtk) {
  const glm::dvec3 vtk[] = {
      {0.2313725, 0.2980392, 0.7529412}, {0.3517351, 0.4685058, 0.8903756}, {0.4843234, 0.6220251, 0.9752454},
      {0.6223182, 0.7464703, 0.9994497}, {0.7538315, 0.8305216, 0.9613121}, {0.8653952, 0.8654102, 0.8653956},
      {0.9480764, 0.7952048, 0.7171698}, {0.9697719, 0.6774358, 0.5597093}, {0.9328818, 0.5197679, 0.4060501},
      {0.8422518, 0.3266194, 0.2666131}, {0.70588, 0.0158127, 0.1490207}};
  const ColorMap map = *shippedColorMap("Cool to Warm");
  for (int i = 0; i <= 10; ++i) EXPECT_LE(distance(evaluate(map, i / 10.0), vtk[i]), kLevel / 2) << i;
}

TEST(ShippedColorMaps, CoolToWarmFollowsItsContinuousDefinition) {
  const ColorMap map = *shippedColorMap("Cool to Warm");
  const glm::dvec3 cool{59.0 / 255, 76.0 / 255, 192.0 / 255}, warm{180.0 / 255, 4.0 / 255, 38.0 / 255};
  for (int i = 0; i <= 1000; ++i) {
    const glm::dvec3 exact = interpolate(cool, warm, i / 1000.0, ColorSpace::Diverging, false);
    EXPECT_LE(distance(evaluate(map, i / 1000.0), exact), kLevel / 4) << i;
  }
}

TEST(ShippedColorMaps, AllAreFoundByNameAndCoverZeroToOneInOrder) {
  EXPECT_EQ(shippedColorMaps().size(), 5u);
  for (const std::string_view name : shippedColorMaps()) {
    const auto map = shippedColorMap(name);
    ASSERT_TRUE(map) << name;
    EXPECT_EQ(map->points.front().value, 0);
    EXPECT_EQ(map->points.back().value, 1);
    EXPECT_TRUE(std::is_sorted(map->points.begin(), map->points.end(),
                               [](const ColorPoint& a, const ColorPoint& b) { return a.value < b.value; }));
    for (const ColorPoint& p : map->points) {
      for (int c = 0; c < 3; ++c) EXPECT_TRUE(p.rgb[c] >= 0 && p.rgb[c] <= 1);
    }
  }
  EXPECT_EQ(shippedColorMap("COOLTOWARM"), shippedColorMap("Cool to Warm"));
  EXPECT_EQ(evaluate(*shippedColorMap("Gray"), 0.25), glm::dvec3(0.25));
  EXPECT_FALSE(shippedColorMap("Jet"));
}

}  // namespace
}  // namespace gxy
