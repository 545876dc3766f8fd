// SPDX-License-Identifier: Apache-2.0
// What the state file says beyond the earlier Galaxy's.
#include "core/scene/state_file.h"

#include <algorithm>

#include "tests/scene/scene_test_support.h"

namespace gxy {
namespace {

StateFile read(const std::string& text) { return readState(text, "s"); }

Vis readVis(const std::string& keys) {
  return read(
             R"({"Visualization": {"operators": [{"type": "Volume", "dataset": "d", "volume rendering": true, )" +
             keys + "}]}}")
      .state.visualizations.at(0)
      .operators.at(0);
}

TEST(StateFile, AnEmptyObjectIsTheDefaultState) {
  const StateFile file = read("{}");
  EXPECT_EQ(file.state, State{});
  EXPECT_TRUE(file.warnings.empty());
}

TEST(StateFile, RendererSettings) {
  const RenderSettings settings =
      read(
          R"({"Renderer": {"tolerance": 0.01, "step": 0.5, "rays per pixel": 4, "background": [1, 0.5, 0.25]}})")
          .state.settings;
  EXPECT_EQ(settings, (RenderSettings{0.01, 0.5, 4, {1, 0.5, 0.25, 1}}));
}

TEST(StateFile, SpecularLighting) {
  const State state =
      read(R"({"Visualization": {"Lighting": {"Ks": 0.3, "phong exponent": 50}, "operators": []}})").state;
  EXPECT_EQ(state.visualizations.at(0).lighting.Ks, 0.3);
  EXPECT_EQ(state.visualizations[0].lighting.shininess, 50);
}

TEST(StateFile, OperatorKeys) {
  const Vis vis = readVis(R"("extinctionmap": [[0, 0], [1, 250.5]], "reference length": 0.1, "opacity": 0.5,
    "clip planes": [[1, 2, 3, 4]], "two sided": false, "component": 2)");
  EXPECT_EQ(vis.opacitymap, (OpacityMap{true, {{0, 0}, {1, 250.5}}}));
  EXPECT_EQ(vis.referenceLength, 0.1);
  EXPECT_EQ(vis.opacity, 0.5);
  EXPECT_EQ(vis.clipPlanes, (std::vector<Plane>{{{1, 2, 3}, 4}}));
  EXPECT_FALSE(vis.twoSided);
  EXPECT_EQ(vis.component, 2);
  EXPECT_FALSE(readVis(R"("component": "magnitude")").component);
}

TEST(StateFile, CellsAreFlatOrSmooth) {
  EXPECT_EQ(readVis(R"("two sided": true)").cells, CellsShown::Flat);
  EXPECT_EQ(readVis(R"("cells": "flat")").cells, CellsShown::Flat);
  EXPECT_EQ(readVis(R"("cells": "smooth")").cells, CellsShown::Smooth);
  for (const char* wrong : {R"("cells": "Smooth")", R"("cells": "")"}) EXPECT_THROW(readVis(wrong), Error);
}

TEST(StateFile, GeometryMayShowAnotherArray) {
  const StateFile file = read(R"({"Datasets": {"name": "p", "type": "Particles", "filename": "a.vtp",
    "fields": ["velocity", "age"]}, "Visualization": {"operators": [
    {"type": "Particles", "dataset": "p", "array": "velocity", "component": 1}]}})");
  EXPECT_TRUE(file.warnings.empty());
  EXPECT_EQ(file.state.datasets.at(0).fields, (std::vector<std::string>{"velocity", "age"}));
  const Vis& vis = file.state.visualizations.at(0).operators.at(0);
  EXPECT_EQ(vis.array, "velocity");
  EXPECT_EQ(vis.component, 1);
  EXPECT_EQ(readState(writeState(file.state), "saved").state, file.state);
}

TEST(StateFile, KeysOfArraysWithoutEffectAreTold) {
  const auto warnings =
      read(R"({"Datasets": {"name": "v", "type": "Volume", "filename": "a.vti", "fields": "x"},
    "Visualization": {"operators": [{"type": "Volume", "dataset": "v", "array": "x"},
    {"type": "Triangles", "dataset": "t", "component": 0}]}})")
          .warnings;
  const auto told = [&](const std::string& text) {
    return std::count_if(warnings.begin(), warnings.end(),
                         [&](const std::string& w) { return w.find(text) != std::string::npos; });
  };
  EXPECT_EQ(told("`fields` has no effect on this type of dataset"), 1);
  EXPECT_EQ(told("`array` has no effect on this type of operator"), 1);
  EXPECT_EQ(told("has no effect without `array`"), 1);
}

TEST(StateFile, EachFieldOfADatasetIsThereOnce) {
  EXPECT_THROW(read(R"({"Datasets": {"type": "Particles", "filename": "a.vtp", "fields": ["x", "x"]}})"),
               Error);
  EXPECT_THROW(read(R"({"Datasets": {"type": "Particles", "filename": "a.vtp", "fields": [1]}})"), Error);
}

TEST(StateFile, DatasetArray) {
  const State state =
      read(R"({"Datasets": {"type": "Volume", "filename": "a.vti", "array": "speed"}})").state;
  EXPECT_EQ(state.datasets.at(0).array, "speed");
}

TEST(StateFile, MapsAreSortedStablyAndASinglePointIsAllowed) {
  const Vis vis = readVis(R"("opacitymap": [[1, 0.5], [0, 0.1], [1, 0.75]], "colormap": [[3, 0, 1, 0]])");
  EXPECT_EQ(vis.opacitymap, (OpacityMap{false, {{0, 0.1}, {1, 0.5}, {1, 0.75}}}));
  EXPECT_EQ(vis.colormap, (ColorMap{{{3, {0, 1, 0}}}}));
}

TEST(StateFile, OpacitiesAndColorsAreClamped) {
  const Vis vis = readVis(R"("opacitymap": [[0, -1], [1, 2]], "opacity": 7, "colormap": [[0, 2, 0.5, -1]])");
  EXPECT_EQ(vis.opacitymap, (OpacityMap{false, {{0, 0}, {1, 1}}}));
  EXPECT_EQ(vis.opacity, 1);
  EXPECT_EQ(vis.colormap, (ColorMap{{{0, {1, 0.5, 0}}}}));
}

TEST(StateFile, ViewdirectionWinsOverViewcenter) {
  const StateFile file =
      read(R"({"Camera": {"viewcenter": [1, 1, 1], "viewdirection": [0, 0, 1], "viewpoint": [0, 0, 0]}})");
  EXPECT_EQ(file.state.cameras.at(0).viewdirection, glm::dvec3(0, 0, 1));
  ASSERT_EQ(file.warnings.size(), 1u);
  EXPECT_EQ(file.warnings[0], "s:1:27: `viewcenter`: not used, as `viewdirection` is given");
}

}  // namespace
}  // namespace gxy
