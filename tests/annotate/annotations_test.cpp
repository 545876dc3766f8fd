// SPDX-License-Identifier: Apache-2.0
#include "core/annotate/annotations.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/scene/colormaps.h"

namespace gxy {
namespace {

using Numbers = std::vector<double>;
using Words = std::vector<std::string>;

/// A cube of side 2 about the origin, seen by a camera of 400 x 300 pixels; one operator with values from 0 to 1.
struct Seen {
  Visualization visualization;
  ShownSoFar shown{{Range{0, 1}}, Box{glm::dvec3(-1), glm::dvec3(1)}};
  Camera camera;
  RenderSettings settings;

  Seen() {
    camera.viewpoint = {0, 0, 10};
    camera.viewdirection = {0, 0, -1};
    camera.dimensions = {400, 300};
    visualization.operators.resize(1);
    visualization.operators[0].dataset = "ball";
    visualization.operators[0].volumeRendering = true;
  }
  Overlay overlay(const Annotations& what) const {
    return overlayOf(what, {visualization, shown, camera, settings, 7});
  }
};

Annotations only(bool Annotations::*member) {
  Annotations what;
  what.*member = true;
  return what;
}

Words wordsOf(const Overlay& overlay) {
  Words words;
  for (const Overlay::Text& text : overlay.texts) words.push_back(text.text);
  return words;
}

TEST(Annotations, NothingIsDrawnUnasked) { EXPECT_TRUE(Seen().overlay({}).empty()); }

TEST(Annotations, TextNamesTheStep) {
  Annotations what;
  what.text = "step {step} of {step}0";
  const Overlay overlay = Seen().overlay(what);
  EXPECT_EQ(wordsOf(overlay), Words{"step 7 of 70"});
  EXPECT_EQ(overlay.texts[0].anchor, glm::dvec2(0, 1));
  EXPECT_TRUE(overlay.lines.empty() && overlay.bars.empty());
}

TEST(Annotations, TextNamesTheTimeOrWhereItIsNotKnownTheStep) {
  const Seen seen;
  Annotations what;
  what.text = "t = {time}, {time}";
  EXPECT_EQ(wordsOf(seen.overlay(what)), Words{"t = 7, 7"});
  const auto at = [&](double time) {
    return wordsOf(overlayOf(what, {seen.visualization, seen.shown, seen.camera, seen.settings, 7, time}));
  };
  EXPECT_EQ(at(0.25), Words{"t = 0.25, 0.25"});
  EXPECT_EQ(at(12345678.5), Words{"t = 12345678.5, 12345678.5"});
  EXPECT_EQ(at(-1e-7), Words{"t = -1e-07, -1e-07"});
}

TEST(Annotations, TextOfAnyLengthIsTaken) {
  Annotations what;
  for (int i = 0; i < 1 << 20; i++) what.text += "{step}";
  EXPECT_LT(Seen().overlay(what).texts.at(0).text.size(), 2000u);
}

TEST(Annotations, AreDarkOnABrightBackground) {
  Seen seen;
  Annotations what = only(&Annotations::outline);
  EXPECT_FALSE(seen.overlay(what).onBright);
  seen.settings.background = {0.9, 0.9, 1, 1};
  EXPECT_TRUE(seen.overlay(what).onBright);
  EXPECT_LT(seen.overlay(what).lines.at(0).color.r, 0.5);
  seen.settings.backgroundTop = glm::dvec4{0, 0, 0, 1};
  EXPECT_FALSE(seen.overlay(what).onBright) << "half of the gradient is dark";
  seen.settings.backgroundTop = glm::dvec4{0.3, 0.3, 0.3, 1};
  EXPECT_TRUE(seen.overlay(what).onBright);
  seen.settings.backgroundTop.reset();
  seen.settings.background.a = 0.3;  // mostly black
  EXPECT_FALSE(seen.overlay(what).onBright);
}

TEST(Annotations, NumbersOfALegendHaveRoom) {
  Seen seen;
  for (int i = 0; i < 3; i++) {
    seen.visualization.operators.push_back(seen.visualization.operators[0]);
    seen.visualization.operators.back().dataset += std::to_string(i);
    seen.shown.ranges.push_back({0, 1});
  }
  const Overlay overlay = seen.overlay(only(&Annotations::legend));
  ASSERT_EQ(overlay.bars.size(), 4u);
  for (size_t i = 1; i < overlay.texts.size(); i++)
    EXPECT_GE(std::abs(overlay.texts[i].at.y - overlay.texts[i - 1].at.y), overlay.texts[i].height) << i;
}

TEST(Annotations, RoundNumbersLieInTheInterval) {
  EXPECT_EQ(roundNumbers(0, 1), (Numbers{0, 0.25, 0.5, 0.75, 1}));
  EXPECT_EQ(roundNumbers(-30, 70), (Numbers{-25, 0, 25, 50}));
  EXPECT_EQ(roundNumbers(0.5, 6.5), (Numbers{2, 4, 6}));
  EXPECT_EQ(roundNumbers(3, 3), Numbers());
  EXPECT_EQ(roundNumbers(1, 0), Numbers());
  EXPECT_EQ(roundNumbers(-1.7e308, 1.7e308), Numbers());
}

TEST(Annotations, NumbersHaveTheDigitsThatASpanNeeds) {
  EXPECT_EQ(numberTexts({0, 0.25, 0.5}, 0.5), (Words{"0", "0.25", "0.5"}));
  EXPECT_EQ(numberTexts({-0.0, 1e-7}, 1e-7), (Words{"0", "1e-07"}));
  EXPECT_EQ(numberTexts({1000.25, 1000.5}, 0.25), (Words{"1000.25", "1000.5"}));
  EXPECT_EQ(numberTexts({-0.999998, 0.999998}, 2), (Words{"-1", "1"}));
  EXPECT_EQ(numberTexts({289.13, 476.979}, 188), (Words{"289", "477"}));
  EXPECT_EQ(numberTexts({5e-324, 1e-310}, 1e-310).size(), 2u);  // denormal
  EXPECT_EQ(numberTexts({-1.797e308, 1.797e308}, 1.7e308).size(), 2u);
}

TEST(Annotations, OfTheBoxEdgesInFrontAreDrawn) {
  Seen seen;
  seen.camera.aov = 0;
  seen.camera.height = 4;  // 75 pixels to a unit
  const Overlay along = seen.overlay(only(&Annotations::outline));
  ASSERT_EQ(along.lines.size(), 4u);  // of the one face that is seen
  for (const Overlay::Line& line : along.lines)
    for (const glm::dvec2& end : {line.from, line.to}) {
      EXPECT_NEAR(std::abs(end.x - 200), 75, 1e-9);
      EXPECT_NEAR(std::abs(end.y - 150), 75, 1e-9);
    }
  seen.camera.aov = 30;
  seen.camera.viewpoint = {6, 7, 8};
  seen.camera.viewdirection = {-6, -7, -8};
  EXPECT_EQ(seen.overlay(only(&Annotations::outline)).lines.size(), 9u);  // of three faces
  seen.camera.viewpoint = {0.5, 0, 0};                                    // in the box
  EXPECT_TRUE(seen.overlay(only(&Annotations::outline)).empty());
  seen.shown.box = {};
  EXPECT_TRUE(seen.overlay(only(&Annotations::outline)).empty());
}

TEST(Annotations, EdgesEndBeforeTheViewer) {
  Seen seen;
  seen.shown.box = {glm::dvec3(-1, -1, -100), glm::dvec3(1, 1, 100)};
  seen.camera.viewpoint = {3, 0, 0};
  for (const Overlay::Line& line : seen.overlay(only(&Annotations::outline)).lines)
    for (const glm::dvec2& end : {line.from, line.to}) {
      EXPECT_TRUE(std::isfinite(end.x) && std::isfinite(end.y));
      EXPECT_LT(end.x, 200);  // all of it is to the left
    }
}

TEST(Annotations, ABoxAtTheEndsOfTheNumbersIsDrawnInTime) {
  Seen seen;
  seen.shown.box = {glm::dvec3(-1.7e308), glm::dvec3(1.7e308)};
  for (const glm::dvec3& from : {glm::dvec3(1.75e308, 1e308, 0), glm::dvec3(0, 0, 10)}) {
    seen.camera.viewpoint = from;
    seen.camera.viewdirection = {-1, -0.5, -0.2};
    Image picture{400, 300, LargeVector<float>(400 * 300 * 4)};
    draw(seen.overlay(only(&Annotations::outline)), picture);
  }
}

TEST(Annotations, TheBoxHasItsExtents) {
  Seen seen;
  seen.shown.box = {glm::dvec3(-1, -0.5, 0), glm::dvec3(1.25, 0.5, 0.75)};
  seen.camera.viewpoint = {3, 2, 4};
  seen.camera.viewdirection = -seen.camera.viewpoint;
  const Words words = wordsOf(seen.overlay(only(&Annotations::outline)));
  EXPECT_EQ(words, (Words{"-1", "x", "1.25", "-0.5", "y", "0.5", "0", "z", "0.75"}));
}

TEST(Annotations, AxesPointWhereTheyDo) {
  Seen seen;
  const Overlay overlay = seen.overlay(only(&Annotations::axes));
  ASSERT_EQ(overlay.lines.size(), 3u);
  const auto way = [&](const char* name) {
    const auto at = std::ranges::find(overlay.texts, name, &Overlay::Text::text);
    const Overlay::Line& line = overlay.lines[size_t(at - overlay.texts.begin())];
    return line.to - line.from;
  };
  EXPECT_GT(way("x").x, 10);
  EXPECT_NEAR(way("x").y, 0, 1e-9);
  EXPECT_NEAR(way("y").x, 0, 1e-9);
  EXPECT_GT(way("y").y, 10);
  EXPECT_EQ(overlay.texts[2].text, "z");  // the nearest last
  seen.camera.viewpoint = {0, 0, -10};
  seen.camera.viewdirection = {0, 0, 1};
  EXPECT_EQ(wordsOf(seen.overlay(only(&Annotations::axes)))[0], "z");
}

TEST(Annotations, LegendsAreOfMapsOverValues) {
  Seen seen;
  Vis& vis = seen.visualization.operators[0];
  vis.colormap = {{{0, {1, 0, 0}}, {1, {0, 0, 1}}}};
  vis.rangeOfData = true;
  seen.shown.ranges = {{2, 4}};
  const Overlay one = seen.overlay(only(&Annotations::legend));
  ASSERT_EQ(one.bars.size(), 1u);
  const std::vector<glm::dvec3>& colors = one.bars[0].colors;
  EXPECT_GT(colors.size(), 50u);
  EXPECT_GT(colors.front().r, 0.98);
  EXPECT_GT(colors.back().b, 0.98);
  EXPECT_EQ(wordsOf(one), (Words{"ball", "2", "2.5", "3", "3.5", "4"}));
  EXPECT_NEAR(one.texts[1].at.y, one.bars[0].lo.y, 1e-9);
  EXPECT_NEAR(one.texts[5].at.y, one.bars[0].hi.y, 1e-9);

  seen.visualization.operators.push_back(vis);  // the same again, as an isosurface
  seen.visualization.operators[1].volumeRendering = false;
  seen.visualization.operators[1].isovalues = {3};
  seen.shown.ranges.push_back({2, 4});
  EXPECT_EQ(seen.overlay(only(&Annotations::legend)).bars.size(), 1u);
  seen.visualization.operators[1].colormap = *shippedColorMap("Viridis");
  const Overlay two = seen.overlay(only(&Annotations::legend));
  ASSERT_EQ(two.bars.size(), 2u);
  EXPECT_GT(two.bars[0].lo.y, two.bars[1].hi.y);
  seen.shown.ranges = {{}, {}};  // without values
  EXPECT_TRUE(seen.overlay(only(&Annotations::legend)).empty());
}

TEST(Annotations, OneColourHasNoLegend) {
  Seen seen;
  seen.visualization.operators[0].colormap = {{{5, {1, 0, 0}}, {6, {1, 0, 0}}}};
  EXPECT_TRUE(seen.overlay(only(&Annotations::legend)).empty());
}

TEST(Annotations, AStepHasItsNumber) {
  Seen seen;
  seen.visualization.operators[0].colormap = {{{5, {1, 0, 0}}, {5, {0, 1, 0}}}};
  EXPECT_EQ(wordsOf(seen.overlay(only(&Annotations::legend))), (Words{"ball", "5"}));
}

TEST(Annotations, WhatDoesNotFitIsLeftOut) {
  Seen seen;
  seen.camera.dimensions = {60, 60};
  Annotations all;
  all.legend = all.axes = all.outline = true;
  const Overlay overlay = seen.overlay(all);
  EXPECT_TRUE(overlay.bars.empty());
  EXPECT_TRUE(overlay.texts.empty());
}

}  // namespace
}  // namespace gxy
