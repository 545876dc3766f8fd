// SPDX-License-Identifier: Apache-2.0
#include "gxybench/chart.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "gxy/comm/error.h"
#include "rows.h"

namespace gxy::bench::test {
namespace {

std::string written(const Chart& chart) {
  const TemporaryFolder folder;
  writeChart(folder / "chart.svg", chart);
  std::ifstream in(folder / "chart.svg");
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

size_t countOf(const std::string& text, const std::string& part) {
  size_t n = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) n++;
  return n;
}

TEST(Chart, ShowsAMarkerForEveryPointAndOneInTheLegend) {
  Chart chart{"title", "x", "y", {{"round", {0.1, 1, 10}, {1e-1, 1e-2, 1e-3}}, {"square", {0.2}, {0.5}}}};
  const std::string svg = written(chart);
  EXPECT_EQ(svg.rfind("<svg", 0), 0u);
  EXPECT_NE(svg.find("</svg>"), std::string::npos);
  EXPECT_EQ(countOf(svg, "href=\"#Circle\""), 4u);
  EXPECT_EQ(countOf(svg, "href=\"#Square\""), 2u);
}

TEST(Chart, PointsThatHaveNoLogarithmAreLeftOut) {
  const Chart chart{"title", "x", "y", {{"round", {0, 1, 2, 3, NAN}, {1, 0, 1e-3, INFINITY, 1}}}};
  EXPECT_EQ(countOf(written(chart), "href=\"#Circle\""), 2u);
  EXPECT_EQ(countOf(written({"nothing", "x", "y", {{"none", {}, {}}}}), "href=\"#Circle\""), 0u);
}

TEST(Chart, AFolderThatIsNotThereIsAnError) {
  EXPECT_THROW(writeChart("/no/such/folder/chart.svg", {"title", "x", "y", {}}), Error);
}

}  // namespace
}  // namespace gxy::bench::test
