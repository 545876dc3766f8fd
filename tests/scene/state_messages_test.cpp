// SPDX-License-Identifier: Apache-2.0
// Every message of the state file: what, where, what was expected.
#include "core/scene/state_file.h"
#include "tests/scene/scene_test_support.h"

namespace gxy {
namespace {

std::string errorFor(const std::string& text) {
  return errorOf([&] { readState(text, "state.json"); });
}

std::string operatorError(const std::string& keys) {
  return errorFor("{\"Visualization\": {\"operators\": [\n{\"dataset\": \"d\", " + keys + "}]}}");
}

std::string warningFor(const std::string& text) {
  const StateFile file = readState(text, "state.json");
  EXPECT_EQ(file.warnings.size(), 1u);
  return file.warnings.empty() ? "" : file.warnings[0];
}

TEST(StateMessages, AWrongValueNamesPlaceKeyExpectationAndFinding) {
  EXPECT_EQ(
      errorFor(
          "{\"Visualization\": {\n  \"operators\": [],\n  \"Lighting\": {\n    \"ao count\": \"many\"}}}"),
      "state.json:4:17: `ao count`: expected an integer 0 to 4096, found \"many\"");
  EXPECT_EQ(errorFor(R"({"Visualization": {"operators": [], "Lighting": {"ao count": 67108864}}})"),
            "state.json:1:62: `ao count`: expected an integer 0 to 4096, found 67108864");
  EXPECT_EQ(errorFor(R"({"Renderer": {"tolerance": 0}})"),
            "state.json:1:28: `tolerance`: expected a number > 0 and <= 1, found 0");
  EXPECT_EQ(errorFor(R"({"Renderer": {"rays per pixel": 1.5}})"),
            "state.json:1:33: `rays per pixel`: expected an integer 1 to 65536, found 1.5");
  EXPECT_EQ(errorFor(R"({"Camera": {"viewup": [0, 1]}})"),
            "state.json:1:23: `viewup`: expected [x, y, z], found an array of 2 values");
  EXPECT_EQ(errorFor(R"({"Camera": {"viewup": [0, "a", 1]}})"),
            "state.json:1:27: `viewup`: expected [x, y, z], found in it \"a\"");
  EXPECT_EQ(errorFor(R"({"Camera": {"dimensions": [512, 0]}})"),
            "state.json:1:33: `dimensions[1]`: expected an integer 1 to 65536, found 0");
  EXPECT_EQ(operatorError(R"("type": "Volume", "isovalues": 3)"),
            "state.json:2:49: `isovalues`: expected a list of numbers, found 3");
  EXPECT_EQ(operatorError(R"("type": "Volume", "volume rendering": 1)"),
            "state.json:2:56: `volume rendering`: expected true or false, found 1");
  EXPECT_EQ(operatorError(R"("type": "Volume", "slices": [[0, 0, 0, 1]])"),
            "state.json:2:47: `slices[0]`: expected [a, b, c, d] for a*x + b*y + c*z = d, with a, b, c not "
            "all 0, found "
            "an array of 4 values");
  EXPECT_EQ(operatorError(R"("type": "Volume", "data range": [2, 1])"),
            "state.json:2:50: `data range`: expected [min, max] with min <= max, or \"data\", found an array "
            "of 2 values");
  EXPECT_EQ(operatorError(R"("type": "Volume", "colormap": [])"),
            "state.json:2:48: `colormap`: expected a list of [value, r, g, b], or the name of a map (at "
            "least one), found "
            "an array of 0 values");
  EXPECT_EQ(errorFor("[]"), "state.json:1:1: expected an object (state file), found an array of 0 values");
}

TEST(StateMessages, SurfacesAreAsManyAsRaysCanName) {
  const auto listOf = [](size_t n, const std::string& item) {
    std::string list = "[" + item;
    for (size_t i = 1; i < n; i++) list += "," + item;
    return list + "]";
  };
  const auto stateWith = [](const std::string& operators) {
    return "{\"Visualization\": {\"operators\": " + operators + "}}";
  };
  const auto isovalues = [&](size_t n) {
    return stateWith(R"([{"type": "Volume", "dataset": "d", "plane": [1, 0, 0, 0], "isovalues": )" +
                     listOf(n, "1") + "}]");
  };
  EXPECT_NO_THROW(readState(isovalues(65534), "state.json"));
  EXPECT_EQ(errorFor(isovalues(65535)),
            "state.json:1:34: `operators[0]`: expected at most 65535 isovalues and slices together, found "
            "65536");
  const auto operators = [&](size_t n) {
    return stateWith(listOf(n, R"({"type":"Particles","dataset":"d"})"));
  };
  EXPECT_NO_THROW(readState(operators(65535), "state.json"));
  EXPECT_NE(errorFor(operators(65536)).find("`operators[65535]`: expected at most 65535 operators"),
            std::string::npos);
}

TEST(StateMessages, MissingKeysAreErrorsAtTheirObject) {
  EXPECT_EQ(errorFor("{\"Datasets\": [\n  {\"type\": \"Volume\"}]}"),
            "state.json:2:3: dataset without `filename` and without `name`; expected one of them");
  EXPECT_EQ(errorFor(R"({"Visualization": {}})"),
            "state.json:1:19: visualization without `operators`; expected list of operators");
  EXPECT_EQ(errorFor(R"({"Camera": {"viewpoint": [0, 0, 0]}})"),
            "state.json:1:12: a camera without direction; expected `viewdirection` or `viewcenter`");
}

TEST(StateMessages, TwoNamesOfOneKeyAreAnError) {
  EXPECT_EQ(errorFor("{\"Camera\": [],\n \"Cameras\": []}"),
            "state.json:2:2: `Cameras`: means the same as `Camera` on line 1; expected one of them");
  EXPECT_NE(operatorError(R"("type": "Volume", "opacitymap": [[0, 1]], "extinctionmap": [[0, 1]])")
                .find("expected one of them"),
            std::string::npos);
}

TEST(StateMessages, InternalKeysAndSamplersAreRefused) {
  EXPECT_EQ(
      errorFor(R"({"Visualization": {"operators": [{"type": "Volume", "dataset": "d", "key": 7}]}})"),
      "state.json:1:76: `key`: internal keys mean nothing outside one server; expected `dataset` with the "
      "dataset's name");
  EXPECT_NE(errorFor(R"({"Visualization": {"operators": [{"type": "Volume", "key": 7}]}})")
                .find("without `dataset`"),
            std::string::npos);
  for (const char* type : {"IsoSampler", "IsoSamplerVis", "GradientSampler", "GradientSamplerVis"}) {
    const std::string message = operatorError("\"type\": \"" + std::string(type) + "\"");
    EXPECT_NE(message.find(R"({"filter": "IsosurfaceSampler")"), std::string::npos) << message;
    EXPECT_EQ(message.find("mag(grad(f))") != std::string::npos, type[0] == 'G') << message;
  }
  EXPECT_NE(operatorError(R"("type": "volume")").find("expected Volume, Particles"), std::string::npos);
}

TEST(StateMessages, NamedOperatorsAndOutputsAreChecked) {
  const auto withOperators = [](const std::string& named, const std::string& said) {
    return errorFor(R"({"Operators": )" + named + R"(, "Visualization": {"operators": [)" + said + "]}}");
  };
  const std::string look = R"({"name": "look", "type": "Volume", "dataset": "d", "isovalues": [1]})";
  const State twoLooks =
      readState(R"({"Operators": )" + look + R"(, "Visualization": {"operators": ["look", "look"]}})", "s")
          .state;
  EXPECT_EQ(twoLooks.visualizations.at(0).operators.size(), 2u);
  EXPECT_NE(withOperators(look, "\"loop\"").find("the name of one of `Operators`; did you mean `look`?"),
            std::string::npos)
      << withOperators(look, "\"loop\"");
  EXPECT_NE(withOperators("[" + look + "," + look + "]", "").find("two operators named \"look\""),
            std::string::npos);
  EXPECT_NE(withOperators(R"({"type": "Volume", "dataset": "d"})", "").find("`name` is missing"),
            std::string::npos);
  EXPECT_NE(withOperators(R"({"name": "n", "type": "Volume"})", "").find("without `dataset`"),
            std::string::npos);
  std::string map = "[";
  for (int i = 0; i < 20000; i++) map += (i ? ",[" : "[") + std::to_string(i) + ",0,0,0]";
  std::string names = "\"look\"";
  for (int i = 0; i < 20; i++) names += ",\"look\"";
  EXPECT_NE(
      withOperators(
          R"({"name": "look", "type": "Volume", "dataset": "d", "isovalues": [1], "colormap": )" + map + "]}",
          names)
          .find("at most 1000000 values in all operators that are named"),
      std::string::npos);
  const auto output = [](const std::string& members) { return errorFor(R"({"Outputs": )" + members + "}"); };
  const State outputs = readState(R"({"Outputs": [{"type": "Data file", "of": "d", "to": "d.vti"},
    {"name": "n", "type": "Publish", "of": "d", "to": "e"}]})",
                                  "s")
                            .state;
  ASSERT_EQ(outputs.outputs.size(), 2u);
  EXPECT_EQ(outputs.outputs[0].name, "d.vti");
  EXPECT_EQ(outputs.outputs[1], (OutputSpec{"n", OutputSpec::Type::Publish, "d", "e"}));
  EXPECT_EQ(readState(writeState(outputs), "s").state, outputs);
  EXPECT_NE(
      output(R"({"type": "Film", "of": "d", "to": "e"})").find("expected Data file, Pictures or Publish"),
      std::string::npos);
  EXPECT_NE(output(R"({"type": "Publish", "to": "e"})").find("without `of`"), std::string::npos);
  const std::string twice = R"({"type": "Publish", "of": "d", "to": "e"})";
  EXPECT_NE(output("[" + twice + "," + twice + "]").find("two outputs named \"e\""), std::string::npos);
}

TEST(StateMessages, DatasetsMustFitTheirOperators) {
  const std::string datasets = R"({"Datasets": {"name": "stars", "type": "Particles", "filename": "f"}, )";
  EXPECT_NE(
      errorFor(datasets + R"("Visualization": {"operators": [{"type": "Volume", "dataset": "stars"}]}})")
          .find("expected a dataset of type Volume"),
      std::string::npos);
  EXPECT_NE(
      warningFor(datasets + R"("Visualization": {"operators": [{"type": "Particles", "dataset": "star"}]}})")
          .find("no dataset \"star\" in this file; did you mean `stars`?"),
      std::string::npos);
  EXPECT_NE(
      errorFor(R"({"Datasets": [{"type": "Volume", "filename": "f"}, {"type": "Volume", "filename": "f"}]})")
          .find("two datasets named \"f\""),
      std::string::npos);
}

TEST(StateMessages, UnknownKeysWarnWithPlaceAndSuggestion) {
  EXPECT_EQ(warningFor("{\n \"Renderer\": {\"tolerence\": 1}}"),
            "state.json:2:15: unknown key `tolerence` in the renderer; did you mean `tolerance`?");
  EXPECT_EQ(warningFor(R"({"cameras": []})"),
            "state.json:1:2: unknown key `cameras` in the state file; did you mean `Cameras`?");
  EXPECT_EQ(warningFor(R"({"comment": "x"})"), "state.json:1:2: unknown key `comment` in the state file");
}

TEST(StateMessages, MendedValuesWarn) {
  const std::string begin =
      R"({"Visualization": {"operators": [{"type": "Volume", "dataset": "d", "volume rendering": true, )";
  EXPECT_NE(warningFor(begin + R"("opacitymap": [[0, 1.5]]}]}})")
                .find("`opacitymap[0]`: 1.5 is outside 0 to 1 and was clamped"),
            std::string::npos);
  EXPECT_NE(warningFor(begin + R"("opacitymap": [[1, 1], [0, 0]]}]}})")
                .find("do not ascend by value and were sorted"),
            std::string::npos);
}

TEST(StateMessages, KeysWithoutEffectWarn) {
  EXPECT_EQ(
      warningFor(
          R"({"Visualization": {"operators": [{"type": "Triangles", "dataset": "d", "isovalues": [1]}]}})"),
      "state.json:1:72: `isovalues` has no effect on this type of operator");
  EXPECT_NE(warningFor(R"({"Visualization": {"operators": [{"type": "Volume", "dataset": "d"}]}})")
                .find("shows nothing"),
            std::string::npos);
}

TEST(StateMessages, OpacityMapsOfSurfacesWarn) {
  const auto warnings = [](const std::string& keys) {
    return readState(R"({"Visualization": {"operators": [{"dataset": "d", )" + keys + "}]}}", "s").warnings;
  };
  using Warnings = std::vector<std::string>;
  EXPECT_EQ(warnings(R"("type": "Triangles", "opacitymap": [[0, 0.25], [1, 1]])"),
            Warnings{"s:1:72: `opacitymap` has no effect on this type of operator"});
  for (const char* surfaces : {R"("isovalues": [1])", R"("slices": [[0, 0, 1, 0]])"}) {
    const std::string volume = R"("type": "Volume", )" + std::string(surfaces);
    EXPECT_EQ(warnings(volume), Warnings{});
    EXPECT_EQ(warnings(R"("type": "Volume", "opacitymap": [[0, 0.25]], )" + std::string(surfaces)),
              Warnings{"s:1:69: `opacitymap` has no effect without `volume rendering`"});
    EXPECT_EQ(warnings(R"("extinctionmap": [[0, 2]], "reference length": 3, )" + volume),
              (Warnings{"s:1:51: `extinctionmap` has no effect without `volume rendering`",
                        "s:1:78: `reference length` has no effect without `volume rendering`"}));
    EXPECT_EQ(warnings(R"("opacitymap": [[0, 0.25]], "volume rendering": true, )" + volume), Warnings{});
  }
}

TEST(StateMessages, WarningsAreBounded) {
  std::string text = "{";
  for (int i = 0; i < 5000; ++i) text += (i ? ",\"" : "\"") + std::to_string(i) + "\":0";
  const StateFile file = readState(text + "}", "state.json");
  ASSERT_EQ(file.warnings.size(), 101u);
  EXPECT_EQ(file.warnings.back(), "state.json: and 4900 more warnings");
}

TEST(StateMessages, FilesThatCannotBeReadAreNamed) {
  const ScratchDirectory scratch;
  EXPECT_NE(errorOf([&] { readStateFile(scratch.path() / "none.json"); }).find("none.json"),
            std::string::npos);
  EXPECT_NE(errorOf([&] { readStateFile(scratch.path()); }).find("not a regular file"), std::string::npos);
  const auto read = [&](const std::string& text) {
    return errorOf([&] { readState(text, "s", scratch.path()); });
  };
  const std::string map =
      read(R"({"Visualization": {"operators": [{"type": "Volume", "dataset": "d", "colormap": "Virids"}]}})");
  EXPECT_EQ(map.find("s:1:81: `colormap`: expected the name of a shipped map (Viridis, Inferno"), 0u) << map;
  const std::string camera = read(R"({"Camera": "none.pvcc"})");
  EXPECT_EQ(camera.find("s:1:12: camera file: "), 0u) << camera;
}

TEST(StateMessages, ImpossibleCamerasAreErrorsAtTheCamera) {
  EXPECT_EQ(errorFor("{\"Camera\":\n {\"viewpoint\": [1, 2, 3], \"viewcenter\": [1, 2, 3]}}"),
            "state.json:2:2: camera `viewdirection`: expected a finite vector that is not zero (viewcenter "
            "is not viewpoint)");
  EXPECT_NE(errorFor(R"({"Camera": {"viewpoint": [1e308, 0, 0], "viewcenter": [-1e308, 0, 0]}})")
                .find("viewdirection"),
            std::string::npos);
  EXPECT_NE(
      errorFor(R"({"Camera": {"aov": 180}})").find("`aov`: expected a number >= 0 and < 180, found 180"),
      std::string::npos);
  EXPECT_NE(errorFor(R"({"Camera": {"dimensions": [65536, 65536]}})").find("at most 2^31 pixels"),
            std::string::npos);
}

}  // namespace
}  // namespace gxy
