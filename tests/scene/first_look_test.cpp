// SPDX-License-Identifier: Apache-2.0
// States for data of which nobody has said how they are shown.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/scene/colormaps.h"
#include "core/scene/first_look.h"
#include "core/scene/state_file.h"

namespace gxy {
namespace {

LookFacts volumeOf(std::vector<float> values) {
  LookFacts facts;
  facts.dataset = {"v", DatasetType::Volume, "v.vti", "", glm::dvec4(1)};
  const Box box{{0, 0, 0}, {1, 1, 1}};
  Range range;
  for (const float v : values) range.extend(double(v));
  facts.data = {box, box, {range}, 0};
  facts.values = std::move(values);
  completeSample(facts);
  return facts;
}

/// Half of the values below 0.1, one in a thousand up to 100.
std::vector<float> longTail() {
  std::vector<float> values;
  for (int i = 0; i < 100000; i++) values.push_back(float(0.1 * std::pow(2 * (1 - i / 100000.0), -1.12)));
  return values;
}

TEST(FirstLook, RareValuesOfALongTailAreSeenAndItsBulkIsNot) {
  const LookFacts facts = volumeOf(longTail());
  const Vis vis = firstLook(std::span(&facts, 1)).visualizations[0].operators[0];
  EXPECT_TRUE(vis.volumeRendering);
  EXPECT_TRUE(vis.rangeOfData);
  const auto opacity = [&](double fraction) {
    return evaluate(vis.opacitymap, quantile(facts.values, fraction));
  };
  EXPECT_LT(opacity(0.45), 0.01);
  EXPECT_GT(opacity(0.97), 2 * opacity(0.8));
  EXPECT_GT(opacity(0.998), opacity(0.97));
  const auto red = [&](double fraction) {
    return evaluate(vis.colormap, quantile(facts.values, fraction)).r;
  };
  EXPECT_GT(red(0.97) - red(0.6), 0.3);  // a linear map has one colour for both
}

TEST(FirstLook, NoiseIsTransparentAndWhatStandsOutOfItIsNot) {
  std::vector<float> values;
  for (int i = 0; i < 97000; i++)  // a hump about 100 that is 20 wide, half on half
    values.push_back(float(100 + 20 * std::atanh(1.98 * ((i + 0.5) / 97000 - 0.5))));
  for (int i = 0; i < 3000; i++) values.push_back(float(300 + i / 10));
  const LookFacts facts = volumeOf(values);
  const Vis vis = firstLook(std::span(&facts, 1)).visualizations[0].operators[0];
  for (const double noise : {60.0, 100.0, 125.0}) EXPECT_EQ(evaluate(vis.opacitymap, noise), 0) << noise;
  // A tenth of the volume's extent is 5 reference lengths: a vessel of this width is as good as opaque.
  EXPECT_LT(std::pow(1 - evaluate(vis.opacitymap, 450), 5), 0.1);
}

TEST(FirstLook, ColoursOfSurfacesAreBrighterThanTheBackground) {
  for (const auto& values : {longTail(), std::vector<float>{0, 1, 2, 3, 4}}) {
    LookFacts facts = volumeOf(values);
    facts.dataset.type = DatasetType::Particles;
    const State state = firstLook(std::span(&facts, 1));
    const Vis& vis = state.visualizations[0].operators[0];
    for (const auto& point : vis.colormap.points) {
      const glm::dvec3& c = point.rgb;
      EXPECT_GT(0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b, 1.5 * state.settings.background.g);
    }
  }
}

TEST(FirstLook, MapsEndWhereTheValuesDo) {
  for (const auto& values :
       {longTail(), std::vector<float>{-3, 1, 2, 4}, std::vector<float>{0, 0, 0, 0, 0, 0, 0, 7}}) {
    const LookFacts facts = volumeOf(values);
    const State state = firstLook(std::span(&facts, 1));
    const Vis& vis = state.visualizations[0].operators[0];
    EXPECT_EQ(vis.colormap.points.front().value, double(facts.values.front()));
    EXPECT_EQ(vis.colormap.points.back().value, double(facts.values.back()));
    EXPECT_EQ(vis.opacitymap.points.front().value, double(facts.values.front()));
    EXPECT_EQ(vis.opacitymap.points.back().value, double(facts.values.back()));
    EXPECT_EQ(readState(writeState(state), "saved").state, state);  // it can be said
    EXPECT_TRUE(readState(writeState(state), "saved").warnings.empty());
  }
}

TEST(FirstLook, SpreadValuesHaveARamp) {
  std::vector<float> values;
  for (int i = 0; i <= 1000; i++) values.push_back(float(i));
  const FirstMaps maps = firstMaps(values, 1);
  EXPECT_EQ(evaluate(maps.opacities, 0), 0);
  for (int k = 1; k <= 4; k++)
    EXPECT_GT(evaluate(maps.opacities, 250.0 * k), evaluate(maps.opacities, 250.0 * (k - 1)));
  EXPECT_EQ(firstIsovalue(values), 500);
}

TEST(FirstLook, OptionsShowSurfacesOrSlicesInsteadOfTheVolume) {
  const LookFacts facts = volumeOf({0, 1, 2, 3, 4});
  const auto look = [&](const LookOptions& options) {
    return firstLook(std::span(&facts, 1), options).visualizations[0].operators[0];
  };
  const Vis surfaces = look({{1.5, 2.5}, false, false}), automatic = look({{}, true, false}),
            slices = look({{}, false, true});
  EXPECT_EQ(surfaces.isovalues, (std::vector<double>{1.5, 2.5}));
  EXPECT_EQ(automatic.isovalues.size(), 1u);
  EXPECT_EQ(slices.slices.size(), 3u);
  EXPECT_EQ(slices.slices[1].offset, 0.5);
  for (const Vis& vis : {surfaces, automatic, slices}) EXPECT_FALSE(vis.volumeRendering);
}

TEST(FirstLook, AnImageIsItsSlice) {
  LookFacts facts = volumeOf({0, 1, 2, 3, 4});
  facts.thin = 1;
  const State state = firstLook(std::span(&facts, 1));
  const Vis& vis = state.visualizations[0].operators[0];
  EXPECT_FALSE(vis.volumeRendering);
  ASSERT_EQ(vis.slices.size(), 1u);
  EXPECT_EQ(vis.slices[0].normal, glm::dvec3(0, 1, 0));
  EXPECT_EQ(vis.slices[0].offset, 0.5);
  EXPECT_EQ(state.cameras[0].viewdirection, glm::dvec3(0, -1, 0));
}

TEST(FirstLook, GeometryIsSizedByItsPointsAndFlatDataAreSeenFromAbove) {
  LookFacts facts;
  facts.dataset = {"g", DatasetType::Particles, "g.vtp", "", glm::dvec4(1)};
  const Box box{{0, 0, 0}, {3, 2, 0}};
  facts.data = {box, box, {Range()}, 0.1};
  const State state = firstLook(std::span(&facts, 1));
  const Vis& vis = state.visualizations[0].operators[0];
  EXPECT_TRUE(vis.radiusOfData);
  EXPECT_FALSE(vis.rangeOfData);
  EXPECT_EQ(vis.colormap.points.size(), 1u);  // there is nothing to map
  EXPECT_TRUE(state.cameras[0].fit);
  EXPECT_EQ(state.cameras[0].viewdirection, glm::dvec3(0, 0, -1));
  EXPECT_EQ(state.visualizations[0].lighting.sources.size(), 1u);
  EXPECT_EQ(state.visualizations[0].lighting.sources[0].type, LightType::Camera);
  EXPECT_GE(state.settings.raysPerPixel, 4);
}

}  // namespace
}  // namespace gxy
