// SPDX-License-Identifier: Apache-2.0
#include "core/scene/state_pictures.h"

#include <gtest/gtest.h>

#include "core/scene/resolve.h"
#include "core/scene/state_file.h"

namespace gxy {
namespace {

TEST(PictureName, HasTheNumberAndWhatIsShownFromWhere) {
  Visualization volume, slice;
  Camera front;
  EXPECT_EQ(pictureName("image", 0, volume, front), "image_00000");
  volume.annotation = "volume";
  slice.annotation = "-slice";  // with a separator of its own
  EXPECT_EQ(pictureName("out/a", 0, volume, front), "out/a_00000_volume");
  front.annotation = "front";
  EXPECT_EQ(pictureName("image", 2, volume, front), "image_00002_volume_front");
  EXPECT_EQ(pictureName("image", 123456, slice, front), "image_123456-slice_front");
}

State stateWithViews() {
  return readState(R"({
    "Visualizations": [
      {"operators": []},
      {"name": "near", "camera": {"viewpoint": [0, 0, 1], "viewcenter": [0, 0, 0]}, "size": [40, 30], "operators": []},
      {"name": "wide", "size": [90, 10], "follow": false, "show": "as it comes", "operators": []}],
    "Cameras": [{"viewpoint": [1, 0, 0], "viewcenter": [0, 0, 0]}, {"viewpoint": [2, 0, 0], "viewcenter": [0, 0, 0]}]
  })",
                   "state.json")
      .state;
}

TEST(StatePictures, ViewsAreRenderedFromTheirOwnCameraOnce) {
  std::vector<std::tuple<size_t, glm::dvec3, glm::ivec2>> found;
  for (const StatePicture& p : picturesOf(stateWithViews()))
    found.emplace_back(p.visualization, p.camera.viewpoint, p.camera.dimensions);
  const std::vector<std::tuple<size_t, glm::dvec3, glm::ivec2>> expected{{0, {1, 0, 0}, {512, 512}},
                                                                         {1, {0, 0, 1}, {40, 30}},
                                                                         {2, {1, 0, 0}, {90, 10}},
                                                                         {0, {2, 0, 0}, {512, 512}},
                                                                         {2, {2, 0, 0}, {90, 10}}};
  EXPECT_EQ(found, expected);
}

TEST(StatePictures, WithoutCamerasTheDataAreFitted) {
  State state = stateWithViews();
  state.cameras.clear();
  const auto pictures = picturesOf(state);
  ASSERT_EQ(pictures.size(), 3u);
  EXPECT_EQ(pictures[0].camera, defaultCamera());
  EXPECT_EQ(pictures[1].camera.viewpoint, glm::dvec3(0, 0, 1));
}

TEST(StatePictures, TheOnlyViewsCameraBecomesTheStates) {
  State state = stateWithViews();
  state.visualizations = {state.visualizations[1]};
  const std::vector<StatePicture> before = picturesOf(state);
  useOwnCamera(state);
  ASSERT_EQ(state.cameras.size(), 1u);
  EXPECT_EQ(state.cameras[0], before.at(0).camera);
  EXPECT_FALSE(state.visualizations[0].view.camera);
  EXPECT_EQ(picturesOf(state).size(), 1u);
}

TEST(StatePictures, ViewsAreSavedAsTheyWereRead) {
  const State state = stateWithViews();
  EXPECT_EQ(state.visualizations[2].view.name, "wide");
  EXPECT_FALSE(state.visualizations[2].view.follow);
  EXPECT_TRUE(state.visualizations[2].view.asItComes);
  const StateFile again = readState(writeState(state), "saved.json");
  EXPECT_EQ(again.state, state);
  EXPECT_TRUE(again.warnings.empty());
}

TEST(StatePictures, WhatNoViewCanBeIsToldWithItsPlace) {
  const auto errorOf = [](const std::string& view) {
    try {
      readState("{\"Visualizations\": [" + view + "]}", "s.json");
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_EQ(errorOf(R"({"size": [0, 9], "operators": []})"),
            "s.json:1:31: `size[0]`: expected an integer 1 to 65536, found 0");
  EXPECT_EQ(errorOf(R"({"show": "later", "operators": []})"),
            "s.json:1:30: `show`: expected \"together\" or \"as it comes\", found \"later\"");
  EXPECT_EQ(errorOf(R"({"name": "a", "operators": []}, {"name": "a", "operators": []})"),
            "s.json:1:53: two visualizations named \"a\"; expected each name once");
  EXPECT_NE(
      errorOf(R"({"camera": {"viewpoint": [1, 2, 3]}, "operators": []})").find("a camera without direction"),
      std::string::npos);
}

TEST(StatePictures, WhatThePageKeepsGivesNoWarning) {
  const auto read = [](const std::string& text) { return readState(text, "s.json"); };
  EXPECT_TRUE(read(R"({"GUI": {"positions": {"a": [1, 2]}}, "version": 1})").warnings.empty());
  EXPECT_THROW(read(R"({"version": 2})"), Error);
}

}  // namespace
}  // namespace gxy
