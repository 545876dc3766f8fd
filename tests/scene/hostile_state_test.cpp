// SPDX-License-Identifier: Apache-2.0
// Any text gives a State or an Error, never anything else.
#include <random>

#include "core/scene/colormaps.h"
#include "core/scene/paraview_camera.h"
#include "core/scene/state_file.h"
#include "tests/scene/random_state.h"
#include "tests/scene/scene_test_support.h"
#include "tests/support/seeds.h"

namespace gxy {
namespace {

constexpr const char* kOldStyle =
    R"({"Renderer": {"epsilon": 1e-3, "Lighting": {"Sources": [[1, 2, 3], [0, 0, -1, 0]]}},
  "Datasets": {"type": "Volume", "filename": "a.vol"}, "Visualizations": [{"operators": [
  {"type": "VolumeVis", "dataset": "a.vol", "plane": [1, 0, 0, 0], "colormap": "Turbo", "data range": [0, 1]},
  {"type": "PathLinesVis", "dataset": "b", "radius": 1, "transfer function": [[0, 1, 0.5, 0]]}]}],
  "Camera": {"viewpoint": [0, 0, -4], "viewcenter": [0, 0, 0], "viewup": [0, 1, 0], "aov": 0, "dimensions": [64, 48]}})";

/// Changes a few bytes or pieces of a text.
class Mutator {
 public:
  explicit Mutator(uint64_t seed) : engine_(seed) {}

  std::string operator()(std::string text) {
    for (int i = 0, n = integer(1, 4); i < n; ++i) mutate(text);
    return text;
  }

 private:
  int integer(int lo, int hi) { return std::uniform_int_distribution<int>(lo, hi)(engine_); }
  size_t place(const std::string& text) { return size_t(integer(0, int(text.size()))); }

  void mutate(std::string& text) {
    static const std::string kPieces[] = {"{",
                                          "}",
                                          "[",
                                          "]",
                                          ",",
                                          ":",
                                          "\"",
                                          "\\u0000",
                                          "null",
                                          "true",
                                          "-1",
                                          "1e308",
                                          "1e999",
                                          "1e-320",
                                          "\xFF",
                                          "-0",
                                          "[[[[",
                                          "{}",
                                          "[]",
                                          "\"\"",
                                          "99999999999999999999",
                                          "\xEF\xBB\xBF",
                                          "NaN",
                                          "\"type\":",
                                          "\"Camera\":",
                                          "\"/dev/zero\"",
                                          "\"..\""};
    switch (integer(0, 5)) {
      case 0:
        text.resize(place(text));
        break;
      case 1:
        text.insert(place(text), kPieces[integer(0, int(std::size(kPieces)) - 1)]);
        break;
      case 2:
        text.erase(place(text), size_t(integer(1, 12)));
        break;
      case 3:
        if (!text.empty()) text[size_t(integer(0, int(text.size()) - 1))] = char(integer(0, 255));
        break;
      case 4:
        text.insert(place(text), text.substr(place(text), size_t(integer(1, 60))));
        break;
      default:
        replaceNumber(text);
        break;
    }
  }

  void replaceNumber(std::string& text) {
    static const char* const kNumbers[] = {"-1",     "0",          "0.5",   "1e300", "-1e300",
                                           "1e-310", "2147483648", "\"x\"", "true",  "[]"};
    const size_t begin = text.find_first_of("0123456789", place(text));
    if (begin == std::string::npos) return;
    const size_t end = text.find_first_not_of("0123456789.e+-", begin);
    text.replace(begin, end == std::string::npos ? end : end - begin, kNumbers[integer(0, 9)]);
  }

  std::mt19937_64 engine_;
};

TEST(HostileState, MutatedFilesGiveAStateOrAnError) {
  int loaded = 0, refused = 0;
  for (uint64_t seed = 0; seed < uint64_t(test::sweep(4800)); ++seed) {
    const std::string original = seed % 4 == 0 ? kOldStyle : writeState(RandomState(seed / 8).state());
    const std::string text = Mutator(seed)(original);
    try {
      const State state = readState(text, "mutated", "/nowhere").state;
      ASSERT_TRUE(readState(writeState(state), "saved").state == state) << "seed " << seed << "\n" << text;
      ++loaded;
    } catch (const Error& e) {
      ASSERT_EQ(std::string(e.what()).rfind("mutated", 0), 0u) << e.what();
      ++refused;
    }
  }
  EXPECT_GT(loaded, test::sweep(200));
  EXPECT_GT(refused, test::sweep(200));
}

TEST(HostileState, EveryPrefixOfAFileIsRefused) {
  const std::string text = kOldStyle;
  for (size_t length = 0; length < text.size(); ++length) {
    EXPECT_THROW(readState(text.substr(0, length), "prefix"), Error) << length;
  }
  EXPECT_NO_THROW(readState(text, "whole"));
}

TEST(HostileState, MutatedCameraFilesAndPresetsGiveAValueOrAnError) {
  const std::string xml =
      R"(<PVCameraConfiguration><Proxy><Property name="CameraPosition"><Element index="0" value="1"/>)"
      R"(<Element value="2"/><Element value="3"/></Property><Property name="CameraFocalPoint"><Element value="0"/>)"
      R"(<Element value="0"/><Element value="0"/></Property><Property name="CameraViewUp"><Element value="0"/>)"
      R"(<Element value="1"/><Element value="0"/></Property></Proxy></PVCameraConfiguration>)";
  const std::string preset =
      R"([{"ColorSpace": "Diverging", "RGBPoints": [0, 0.2, 0.3, 0.7, 1, 0.7, 0, 0.1], "Points": [0, 0, 0.5, 0]}])";
  int refused = 0;
  for (uint64_t seed = 0; seed < 2000; ++seed) {
    Mutator mutate(seed);
    try {
      parseParaViewCamera(mutate(xml), "mutated");
    } catch (const Error&) {
      ++refused;
    }
    try {
      const ColorPreset parsed = parseColorPreset(parseJson(mutate(preset), "mutated"), "mutated");
      ASSERT_FALSE(parsed.colors.points.empty());
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 200);
}

std::string many(const std::string& one, int count) {
  std::string list = one;
  for (int i = 1; i < count; ++i) list += "," + one;
  return "[" + list + "]";
}

std::string operatorWith(const std::string& preset) {
  return R"({"type": "Volume", "dataset": "d", "volume rendering": true, "colormap": ")" + preset + "\"}";
}

TEST(HostileState, AFileIsReadOnceHoweverOftenItIsNamed) {
  std::vector<std::string> read;
  const auto files = [&](const std::string& name) {
    read.push_back(name);
    if (name == "p.json")
      return std::string(R"({"RGBPoints": [0, 0, 0, 0, 1, 1, 1, 1], "Points": [2, 0.5, 0, 0]})");
    const auto property = [](const std::string& key, int z) {
      return "<Property name=\"" + key + "\"><Element value=\"0\"/><Element value=\"1\"/><Element value=\"" +
             std::to_string(z) + "\"/></Property>";
    };
    return "<PVCameraConfiguration>" + property("CameraPosition", 4) + property("CameraFocalPoint", 0) +
           property("CameraViewUp", 0) + "</PVCameraConfiguration>";
  };
  const std::string text = R"({"Visualization": {"operators": )" + many(operatorWith("p.json"), 200) +
                           R"(}, "Cameras": )" + many("\"c.pvcc\"", 200) + "}";
  const State state = readState(text, "s", files).state;
  EXPECT_EQ(read, (std::vector<std::string>{"p.json", "c.pvcc"}));
  ASSERT_EQ(state.visualizations.at(0).operators.size(), 200u);
  ASSERT_EQ(state.cameras.size(), 200u);
  const Vis& last = state.visualizations[0].operators.back();
  EXPECT_EQ(last.colormap, (ColorMap{{{0, {0, 0, 0}}, {1, {1, 1, 1}}}}));
  EXPECT_EQ(last.opacitymap, (OpacityMap{false, {{2, 0.5}}}));
  EXPECT_TRUE(state.cameras.back() == state.cameras.front());
}

TEST(HostileState, FilesAreBoundedTogether) {
  int read = 0;
  const auto large = [&](const std::string&) {
    ++read;
    return R"({"RGBPoints": [0, 0, 0, 0]})" + std::string(kMaxJsonBytes / 4, ' ');
  };
  std::string operators;
  for (int i = 0; i < 10; ++i) operators += (i ? "," : "") + operatorWith("p" + std::to_string(i));
  const std::string bytes =
      errorOf([&] { readState(R"({"Visualization": {"operators": [)" + operators + "]}}", "s", large); });
  EXPECT_NE(bytes.find("expected at most " + std::to_string(kMaxJsonBytes)), std::string::npos) << bytes;
  EXPECT_EQ(read, 4);

  std::string points = "0, 0, 0, 0";
  for (int i = 1; i < 1000; ++i) points += ", " + std::to_string(i) + ", 0, 0, 0";
  const auto thousand = [&](const std::string&) { return "{\"RGBPoints\": [" + points + "]}"; };
  const auto named = [&](int times) {
    return R"({"Visualization": {"operators": )" + many(operatorWith("p"), times) + "}}";
  };
  EXPECT_EQ(readState(named(1000), "s", thousand).state.visualizations.at(0).operators.size(), 1000u);
  const std::string copies = errorOf([&] { readState(named(1001), "s", thousand); });
  EXPECT_NE(copies.find("points of maps, expected at most 1000000"), std::string::npos) << copies;
}

TEST(HostileState, DevicesAndDirectoriesAreNotRead) {
  for (const char* name : {"/dev/zero", "/", "/dev/stdin", "\\u0000"}) {
    const std::string text = std::string("{\"Camera\": \"") + name + "\"}";
    EXPECT_THROW(readState(text, "s"), Error) << name;
  }
}

}  // namespace
}  // namespace gxy
