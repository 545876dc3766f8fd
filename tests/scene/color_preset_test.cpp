// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/scene/colormaps.h"
#include "tests/scene/color_distance.h"
#include "tests/scene/scene_test_support.h"

namespace gxy {
namespace {

ColorPreset parse(const std::string& text) { return parseColorPreset(parseJson(text, "p.json"), "p.json"); }
std::string errorFor(const std::string& text) {
  return errorOf([&] { parse(text); });
}

std::string twoColors(const std::string& more) {
  return R"([{"Name": "x", "RGBPoints": [-4, 0.9, 0.2, 0.1, 4, 0.1, 0.3, 0.8])" + more + "}]";
}

TEST(ColorPreset, RgbPointsAreTakenAsTheyAre) {
  const ColorPreset preset =
      parse(R"({"ColorSpace": "RGB", "RGBPoints": [-1, 0, 0, 1, 0.5, 1, 1, 1, 2, 1, 0, 0]})");
  EXPECT_EQ(preset.colors, (ColorMap{{{-1, {0, 0, 1}}, {0.5, {1, 1, 1}}, {2, {1, 0, 0}}}}));
  EXPECT_FALSE(preset.opacities);
}

TEST(ColorPreset, NanColorIsTheColourOfNaN) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const ColorMap map = parse(twoColors(R"(, "NanColor": [0, 0.5, 2])")).colors;
  EXPECT_EQ(evaluate(map, nan), glm::dvec3(0, 0.5, 1));
  EXPECT_EQ(evaluate(rescaled(map, {0, 1}), nan), glm::dvec3(0, 0.5, 1));
  EXPECT_EQ(evaluate(parse(twoColors("")).colors, nan), glm::dvec3(0.9, 0.2, 0.1));
  EXPECT_NE(
      errorFor(twoColors(R"(, "NanColor": [0, 1])")).find("`NanColor`: expected numbers in groups of 3"),
      std::string::npos);
  EXPECT_NE(errorFor(twoColors(R"(, "NanColor": [0, 1, 0, 1, 0, 1])")).find("`NanColor`: expected three"),
            std::string::npos);
}

TEST(ColorPreset, PointsGiveOpacityInGroupsOfFour) {
  const ColorPreset preset =
      parse(R"([{"RGBPoints": [0, 0, 0, 0], "Points": [0, 0.25, 0.5, 0, 1, 0.75, 0.5, 0]}])");
  ASSERT_TRUE(preset.opacities);
  EXPECT_EQ(*preset.opacities, (OpacityMap{false, {{0, 0.25}, {1, 0.75}}}));
}

// Expected colours: VTK 9.1's vtkColorTransferFunction at 1/4, 1/2 and 3/4 between the same colours.
void expectVtk(const std::string& more, const glm::dvec3 (&vtk)[3]) {
  const ColorMap map = parse(twoColors(more)).colors;
  for (int i = 0; i < 3; ++i) EXPECT_LE(distance(evaluate(map, -2 + 2 * i), vtk[i]), kLevel / 2) << more << i;
}

TEST(ColorPreset, OtherColorSpacesMatchVtk) {
  expectVtk(R"(, "ColorSpace": "Lab")", {{0.8003381, 0.2295543, 0.2953568},
                                         {0.6795818, 0.2540815, 0.4618902},
                                         {0.5107749, 0.2768755, 0.6287763}});
  expectVtk(R"(, "ColorSpace": "Diverging")",
            {{1.0, 0.6238339, 0.5267175}, {0.9999828, 1.0, 0.9999832}, {0.4603385, 0.690301, 1.0}});
  expectVtk(R"(, "ColorSpace": "HSV")",
            {{0.8577067, 0.875, 0.1002604}, {0.1605872, 0.85, 0.1003472}, {0.1002604, 0.825, 0.6923468}});
  const glm::dvec3 wrapped[3] = {
      {0.875, 0.1002604, 0.4703369}, {0.78976, 0.1003472, 0.85}, {0.329977, 0.1002604, 0.825}};
  expectVtk(R"(, "ColorSpace": "HSV", "HSVWrap": 1)", wrapped);
  expectVtk(R"(, "ColorSpace": "WrappedHSV")", wrapped);
}

TEST(ColorPreset, ResamplingStaysWithinAQuarterLevelEverywhere) {
  const glm::dvec3 from{0.9, 0.2, 0.1}, to{0.1, 0.3, 0.8};
  for (const auto& [name, space] :
       {std::pair{"Lab", ColorSpace::Lab}, std::pair{"Diverging", ColorSpace::Diverging},
        std::pair{"HSV", ColorSpace::HSV}}) {
    const ColorMap map = parse(twoColors(std::string(R"(, "ColorSpace": ")") + name + "\"")).colors;
    for (int i = 0; i <= 4000; ++i) {
      const glm::dvec3 exact = interpolate(from, to, i / 4000.0, space, false);
      ASSERT_LE(distance(evaluate(map, -4 + i / 500.0), exact), kLevel / 4) << name << " " << i;
    }
  }
}

const glm::dvec3 kRed{1, 0, 0}, kGreen{0, 1, 0}, kBlue{0, 0, 1};

void expectColors(const ColorMap& map, const std::vector<std::pair<double, glm::dvec3>>& colors) {
  for (const auto& [value, color] : colors) EXPECT_EQ(evaluate(map, value), color) << value;
}

TEST(ColorPreset, LabHasSeveralNames) {
  for (const char* name : {"LAB", "CIELAB", "CIELab"})
    EXPECT_EQ(parse(twoColors(std::string(R"(, "ColorSpace": ")") + name + "\"")).colors,
              parse(twoColors(R"(, "ColorSpace": "Lab")")).colors);
}

// As VTK's vtkColorTransferFunction.
TEST(ColorPreset, StepHasTheUpperPointsColourFromJustAboveTheLowerOnesValueOn) {
  const ColorMap map =
      parse(R"([{"ColorSpace": "Step", "RGBPoints": [0, 1, 0, 0, 0.5, 0, 1, 0, 1, 0, 0, 1]}])").colors;
  expectColors(map, {{-1, kRed},
                     {0, kRed},
                     {1e-300, kGreen},
                     {0.25, kGreen},
                     {0.5, kGreen},
                     {justAbove(0.5), kBlue},
                     {1, kBlue},
                     {9, kBlue}});
  const ColorMap wide = rescaled(map, {10, 20});
  expectColors(
      wide,
      {{9, kRed}, {10, kRed}, {justAbove(10), kGreen}, {15, kGreen}, {justAbove(15), kBlue}, {20, kBlue}});
  for (const ColorMap& any : {wide, rescaled(map, {3, 3}), rescaled(map, {-1e300, 1e300})})
    EXPECT_TRUE(std::is_sorted(any.points.begin(), any.points.end(),
                               [](auto& a, auto& b) { return a.value < b.value; }));
}

TEST(ColorPreset, IndexedColorsAreCategoriesWithoutMixing) {
  const std::string colors = R"("IndexedColors": [1, 0, 0, 0, 1, 0, 0, 0, 1])";
  const std::vector<std::pair<double, glm::dvec3>> expected{{-1, kRed},     {0, kRed},   {0.25, kRed},
                                                            {0.75, kGreen}, {1, kGreen}, {1.4, kGreen},
                                                            {1.6, kBlue},   {2, kBlue},  {7, kBlue}};
  expectColors(parse("[{" + colors + R"(, "Annotations": ["0", "a", "1", "b", "2", "c"]}])").colors,
               expected);
  expectColors(parse("[{" + colors + "}]").colors, expected);
  // values in any order, more of them than colours, one of them twice
  expectColors(
      parse("[{" + colors + R"(, "Annotations": ["5", "", "-3", "", 10, "", "2e1", "", "10", ""]}])").colors,
      {{5, kRed}, {-3, kGreen}, {10, kBlue}, {20, kRed}, {12, kBlue}});
  // they are used where there is nothing else, or where the preset says so
  const std::string both = R"("RGBPoints": [0, 0, 0, 0, 2, 1, 1, 1], )" + colors;
  EXPECT_EQ(evaluate(parse("{" + both + "}").colors, 1), glm::dvec3(0.5));
  for (const char* key : {"IndexedLookup", "InterpretValuesAsCategories"})
    expectColors(parse("{" + both + ", \"" + key + "\": true}").colors, expected);
}

TEST(ColorPreset, ErrorsNameThePlaceAndWhatWasExpected) {
  EXPECT_EQ(errorFor("[\n {\"RGBPoints\": [0, 1, 1]}]"),
            "p.json:2:16: `RGBPoints`: expected numbers in groups of 4, found an array of 3 values");
  EXPECT_EQ(errorFor("{\"RGBPoints\": [0, 1, \"x\", 1]}"),
            "p.json:1:22: `RGBPoints`: expected a number, found \"x\"");
  EXPECT_NE(errorFor("{\"RGBPoints\": []}").find("groups of 4"), std::string::npos);
  EXPECT_NE(errorFor("{\"Name\": \"x\"}").find("`RGBPoints`"), std::string::npos);
  EXPECT_EQ(errorFor("{\"IndexedColors\": [1, 0]}"),
            "p.json:1:19: `IndexedColors`: expected numbers in groups of 3, found an array of 2 values");
  EXPECT_EQ(errorFor("{\"IndexedColors\": [1, 0, 0], \"Annotations\": [\"1\", \"a\", \"b\", \"b\"]}"),
            "p.json:1:56: `Annotations`: expected the number of a category, found \"b\"");
  EXPECT_NE(errorFor("{\"IndexedColors\": [1, 0, 0], \"Annotations\": [\"1\"]}").find("pairs of a value"),
            std::string::npos);
  EXPECT_NE(errorFor("[]").find("colour preset"), std::string::npos);
  EXPECT_NE(errorFor(twoColors(R"(, "ColorSpace": "CMYK")")).find("expected RGB, HSV, Lab (CIELAB)"),
            std::string::npos);
}

}  // namespace
}  // namespace gxy
