// SPDX-License-Identifier: Apache-2.0
#include "core/io/volume_description.h"

#include <gtest/gtest.h>

#include "core/comm/error.h"
#include "tests/io/fixtures.h"

namespace gxy {
namespace {

const std::string kVol = "float\n-1 -1 -1\n64 32 16\n0.1 0.2 0.3\nmy file.raw\n";
const std::string kJson =
    R"({"type": "int16", "origin": [1, 2, 3], "counts": [4, 5, 6], "delta": [0.5, 0.25, 1], "rawdata": "x.raw",
        "number of components": 3, "byte order": "big"})";

std::string errorOf(const std::string& text, bool vol) {
  try {
    vol ? parseVol(text, "f") : parseVolumeJson(text, "f");
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

TEST(Vol, IsReadAsDocumented) {
  const VolumeDescription v = parseVol(kVol, "f");
  EXPECT_EQ(v.type, ScalarType::Float32);
  EXPECT_EQ(v.grid.points, (Index3{64, 32, 16}));
  EXPECT_EQ(v.grid.origin, glm::dvec3(-1));
  EXPECT_EQ(v.grid.spacing, glm::dvec3(0.1, 0.2, 0.3));
  EXPECT_EQ(v.rawFile, "my file.raw");
}

TEST(Vol, UnknownTypeIsAnErrorWithItsLine) {
  EXPECT_EQ(errorOf("\n\nfloaty\n" + kVol.substr(6), true).find("f:3: unknown type \"floaty\""), 0u);
}

TEST(Vol, WrongNumberIsAnErrorWithItsLine) {
  EXPECT_EQ(errorOf("float\n0 0 0\n4 4.5 4\n1 1 1\nx\n", true),
            "f:3: expected a number of points, found \"4.5\"");
}

TEST(Vol, GridsThatCannotBeAreErrors) {
  EXPECT_NE(errorOf("float 0 0 0 1 4 4 1 1 1 x", true).find("expected at least 2"), std::string::npos);
  EXPECT_NE(errorOf("float 0 0 0 -4 4 4 1 1 1 x", true).find("expected at least 2"), std::string::npos);
  EXPECT_NE(errorOf("float 0 0 0 4 4 4 0 1 1 x", true).find("expected positive"), std::string::npos);
  EXPECT_NE(errorOf("float nan 0 0 4 4 4 1 1 1 x", true).find("not finite"), std::string::npos);
  EXPECT_NE(errorOf("float 0 0 0 4000000000 4000000000 4 1 1 1 x", true).find("too large"),
            std::string::npos);
}

TEST(VolumeJson, IsReadAsDocumented) {
  const VolumeDescription v = parseVolumeJson(kJson, "f");
  EXPECT_EQ(v.type, ScalarType::Int16);
  EXPECT_EQ(v.components, 3);
  EXPECT_EQ(v.grid.points, (Index3{4, 5, 6}));
  EXPECT_TRUE(v.swapBytes);
}

TEST(VolumeJson, ErrorsNameTheKey) {
  EXPECT_EQ(errorOf("{}", false), "f: key \"type\" is missing");
  EXPECT_EQ(
      errorOf(R"({"type":"float","origin":[0,0,0],"delta":[1,1,1],"counts":[2,2.5,2],"rawdata":"x"})", false),
      "f: \"counts\": expected an array of three integers");
  EXPECT_EQ(
      errorOf(R"({"type":"float","origin":[0,0,0],"delta":[1,1,1],"counts":[2,2,2],"rawdata":7})", false),
      "f: \"rawdata\": expected a string");
  EXPECT_EQ(errorOf("{", false).find("f: not valid JSON"), 0u);
}

TEST(VolumeDescriptions, FormatAndParseAreInverse) {
  for (int t = 0; t <= int(ScalarType::Float64); ++t) {
    VolumeDescription v = parseVol(kVol, "f");
    v.type = ScalarType(t);
    v.grid.origin = {0.1, 1.0 / 3, -1e300};
    const VolumeDescription a = parseVol(formatVol(v), "f"), b = parseVolumeJson(formatVolumeJson(v), "f");
    EXPECT_EQ(a.type, v.type);
    EXPECT_EQ(b.type, v.type);
    EXPECT_EQ(a.grid, v.grid);
    EXPECT_EQ(b.grid, v.grid);
    EXPECT_EQ(b.rawFile, v.rawFile);
  }
}

/// Whatever the text, the outcome is a valid description or an Error; nothing else leaves the parser.
void expectErrorOrValid(const std::string& text, bool vol, int& errors) {
  try {
    const VolumeDescription v = vol ? parseVol(text, "f") : parseVolumeJson(text, "f");
    EXPECT_NO_THROW(checkGrid(v.grid, v.type, v.components, "f"));
    EXPECT_FALSE(v.rawFile.empty());
  } catch (const Error& e) {
    ++errors;
    EXPECT_EQ(std::string(e.what()).find("f:"), 0u) << e.what();
  }
}

TEST(VolumeDescriptions, DamagedTextsGiveAnErrorOrAValidDescription) {
  const testing::QuietLog quiet;
  std::mt19937 random(7);
  for (bool vol : {true, false}) {
    int errors = 0;
    for (int i = 0; i < 2000; ++i)
      expectErrorOrValid(testing::mutated(vol ? kVol : kJson, random), vol, errors);
    EXPECT_GT(errors, 500);
  }
}

}  // namespace
}  // namespace gxy
