// SPDX-License-Identifier: Apache-2.0
#include "tools/gxybench/chart.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <regex>
#include <sstream>
#include <vector>

#include "core/comm/error.h"
#include "tests/bench/rows.h"

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

/// Where markers are, in the order of the document.
std::vector<std::array<double, 2>> circlesOf(const std::string& svg) {
  const std::regex use(R"re(<use x="([^"]*)" y="([^"]*)"[^>]*#Circle)re");
  std::vector<std::array<double, 2>> found;
  for (std::sregex_iterator m(svg.begin(), svg.end(), use), end; m != end; ++m)
    found.push_back({std::stod((*m)[1]), std::stod((*m)[2])});
  return found;
}

TEST(Chart, AxesAreLogarithmic) {
  const auto circles = circlesOf(written({"title", "x", "y", {{"round", {1, 10, 100}, {1e-1, 1e-3, 1e-5}}}}));
  ASSERT_EQ(circles.size(), 4u);
  // three of the four, the other being the legend's, are evenly spaced
  int even = 0;
  for (size_t legend = 0; legend < 4; legend++) {
    std::vector<std::array<double, 2>> c = circles;
    c.erase(c.begin() + std::ptrdiff_t(legend));
    bool here = true;
    for (size_t axis = 0; axis < 2; axis++)
      here = here && std::abs(c[0][axis] - c[1][axis]) > 20 &&
             std::abs(c[0][axis] - 2 * c[1][axis] + c[2][axis]) < 0.1;
    even += here;
  }
  EXPECT_EQ(even, 1);
}

TEST(Chart, ALineIsDashedAndInTheLegend) {
  Chart chart{"title", "x", "y", {{"round", {0.1, 1, 10}, {1e-1, 1e-2, 1e-3}}}};
  const size_t without = countOf(written(chart), "stroke-dasharray");
  chart.line = 1 / 512.0;
  chart.lineName = "tolerance";
  EXPECT_EQ(countOf(written(chart), "stroke-dasharray"), without + 2);
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
