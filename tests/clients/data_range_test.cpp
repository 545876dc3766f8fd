// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/data_range.h"

#include <gtest/gtest.h>

#include "core/scene/colormaps.h"
#include "tools/gxyviewer/selection.h"

namespace gxy::test {
namespace {

using Range = std::array<double, 2>;

Vis greyUpTo(double last) {
  Vis vis;
  vis.dataset = "balls";
  vis.colormap.points = {{0, glm::dvec3(0)}, {last, glm::dvec3(1)}};
  vis.opacitymap.points = {{0, 1}};
  return vis;
}

TEST(DataRange, IsNarrowedAboutItsMiddleAndMovedByPartsOfItsWidth) {
  Vis vis = greyUpTo(1);
  vis.dataRange = {10, 20};
  EXPECT_TRUE(changeDataRange(vis, 0.5, 0));
  EXPECT_EQ(vis.dataRange, (Range{12.5, 17.5}));
  changeDataRange(vis, 2, 0);
  EXPECT_EQ(vis.dataRange, (Range{10, 20}));
  changeDataRange(vis, 1, -0.25);
  EXPECT_EQ(vis.dataRange, (Range{7.5, 17.5}));
}

TEST(DataRange, WhereNoneIsSaidTheMapsOfAllValuesStayAsTheyWere) {
  Vis vis = greyUpTo(4);
  vis.opacitymap.points = {{1, 0.25}, {2, 0.5}, {9, 0.75}};
  const Vis before = vis;
  EXPECT_EQ(dataRangeOf(vis), (Range{0, 9}));
  EXPECT_TRUE(changeDataRange(vis, 1, 0));
  EXPECT_EQ(vis.dataRange, (Range{0, 9}));
  for (double value = -1; value <= 10; value += 0.5) {
    EXPECT_EQ(evaluate(effectiveColorMap(vis), value), evaluate(before.colormap, value)) << value;
    EXPECT_EQ(evaluate(effectiveOpacityMap(vis), value), evaluate(before.opacitymap, value)) << value;
  }
  changeDataRange(vis, 2, 0);  // -4.5 to 13.5: what was at v is at 4.5 + 2 (v - 4.5)
  EXPECT_NEAR(evaluate(effectiveColorMap(vis), -0.5)[0], 0.5, 1e-12);
  EXPECT_NEAR(evaluate(effectiveOpacityMap(vis), -0.5), 0.5, 1e-12);
}

TEST(DataRange, ThereIsNoneWhereNoMapVaries) {
  Vis vis;
  vis.colormap.points = {{3, glm::dvec3(1)}};
  vis.opacitymap.points = {{0, 1}};
  EXPECT_FALSE(changeDataRange(vis, 0.5, 0));
  EXPECT_FALSE(vis.dataRange);
}

TEST(Selection, ChangesTheRangeOfTheOperatorInFocusAndTakesItBack) {
  State state;
  state.cameras.resize(1);
  state.visualizations.resize(2);
  state.visualizations[0].operators = {greyUpTo(1), greyUpTo(8)};
  Selection selection(state);
  EXPECT_EQ(selection.operatorText(), "operator 1 of 2, Volume balls: data range 0 to 1");
  selection.nextOperator(-1);
  selection.changeRange(0.5, 0);
  EXPECT_EQ(selection.operatorText(), "operator 2 of 2, Volume balls: data range 2 to 6");
  EXPECT_EQ(selection.shown().visualizations[0].operators[0], state.visualizations[0].operators[0]);
  EXPECT_EQ(selection.shown().visualizations[0].operators[1].dataRange, (Range{2, 6}));
  selection.resetRange();
  EXPECT_EQ(selection.with(state.cameras[0]), state);
  selection.nextVisualization(1);
  EXPECT_EQ(selection.operatorText(), "there is no operator");
  selection.changeRange(0.5, 0);
  selection.resetRange();
  selection.nextOperator(1);
}

}  // namespace
}  // namespace gxy::test
