// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/selection.h"

#include <gtest/gtest.h>

namespace gxy::test {
namespace {

State stateOf(std::vector<std::string> visualizations, std::vector<std::string> cameras) {
  State state;
  state.datasets.resize(2);
  state.settings.raysPerPixel = 3;
  for (std::string& name : visualizations) state.visualizations.emplace_back().annotation = std::move(name);
  for (std::string& name : cameras) state.cameras.emplace_back().annotation = std::move(name);
  return state;
}

TEST(Selection, ShowsOneVisualizationFromOneCameraAndGoesRound) {
  Selection selection(stateOf({"a", "b", "c"}, {"d", "e"}));
  const auto names = [&] {
    const State shown = selection.shown();
    EXPECT_EQ(shown.visualizations.size(), 1u);
    EXPECT_EQ(shown.cameras.size(), 1u);
    EXPECT_EQ(shown.datasets.size(), 2u);
    EXPECT_EQ(shown.settings.raysPerPixel, 3);
    return shown.visualizations.at(0).annotation + shown.cameras.at(0).annotation;
  };
  EXPECT_EQ(names(), "ad");
  selection.nextVisualization(1);
  EXPECT_EQ(names(), "bd");
  selection.nextCamera(1);
  EXPECT_EQ(names(), "be");
  selection.nextVisualization(-1);
  selection.nextVisualization(-1);
  EXPECT_EQ(names(), "ce");
  selection.nextVisualization(1);
  selection.nextCamera(-1);
  EXPECT_EQ(names(), "ad");
}

TEST(Selection, KeepsTheWholeStateWithTheCameraInTheShownOnesPlace) {
  State state = stateOf({"a", "b"}, {"c", "d", "e"});
  Selection selection(state);
  selection.nextVisualization(1);
  selection.nextCamera(1);
  Camera now = selection.camera();
  now.viewpoint = {1, 2, 3};
  state.cameras[1] = now;
  EXPECT_EQ(selection.with(now), state);
}

TEST(Selection, AnotherStateIsShownAtTheSamePlaceAsFarAsItHasIt) {
  Selection selection(stateOf({"a", "b", "c"}, {"d", "e"}));
  selection.nextVisualization(1);
  selection.nextCamera(1);
  selection.replace(stateOf({"A", "B", "C"}, {"D", "E"}));
  EXPECT_EQ(selection.shown().visualizations[0].annotation, "B");
  EXPECT_EQ(selection.camera().annotation, "E");
  selection.replace(stateOf({"1"}, {"2"}));
  EXPECT_EQ(selection.shown().visualizations[0].annotation, "1");
  EXPECT_EQ(selection.camera().annotation, "2");
}

TEST(Selection, AViewIsSeenFromItsOwnCamera) {
  State state = stateOf({"a", "view"}, {"d", "e"});
  state.visualizations[1].view.camera.emplace().annotation = "own";
  state.visualizations[1].view.size = glm::ivec2(40, 30);
  Selection selection(state);
  EXPECT_EQ(selection.camera().annotation, "d");
  selection.nextVisualization(1);
  EXPECT_EQ(selection.camera().annotation, "own");
  EXPECT_EQ(selection.camera().dimensions, glm::ivec2(40, 30));
  EXPECT_EQ(selection.text(), "visualization 2 of 2, view");
  EXPECT_EQ(selection.shown().cameras.at(0), selection.camera());
  EXPECT_EQ(selection.shown().visualizations.at(0).view, ViewSettings());
  Camera moved = selection.camera();
  moved.aov = 12;
  const State saved = selection.with(moved);
  EXPECT_EQ(saved.visualizations[1].view.camera, moved);
  EXPECT_EQ(saved.cameras, state.cameras);
  selection.nextVisualization(1);
  EXPECT_EQ(selection.camera().annotation, "d");
}

TEST(Selection, SaysWhichOfSeveralIsShown) {
  EXPECT_EQ(Selection(stateOf({""}, {"only"})).text(), "");
  EXPECT_EQ(Selection(stateOf({"", ""}, {""})).text(), "visualization 1 of 2");
  Selection selection(stateOf({"", "streams"}, {"", "", ""}));
  selection.nextVisualization(1);
  selection.nextCamera(-1);
  EXPECT_EQ(selection.text(), "visualization 2 of 2, streams, camera 3 of 3");
}

}  // namespace
}  // namespace gxy::test
