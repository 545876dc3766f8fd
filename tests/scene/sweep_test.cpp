// SPDX-License-Identifier: Apache-2.0
// Sweeps: what they read, what their pictures are, and what they say of mistakes.
#include "core/scene/sweep.h"

#include "core/scene/orbit.h"
#include "core/scene/resolve.h"
#include "core/scene/swept_pictures.h"
#include "tests/scene/scene_test_support.h"

namespace gxy {
namespace {

constexpr const char* kState = R"({
  "Datasets": {"name": "d", "type": "Volume", "filename": "d.vti"},
  "Renderer": {"tolerance": 0.01},
  "Visualization": {"operators": [
    {"type": "Volume", "dataset": "d", "isovalues": [0.25, 0.5], "slices": [[1, 0, 0, 0.5]]},
    {"type": "Volume", "dataset": "d", "volume rendering": true, "clip planes": [[0, 0, 1, 0]]}]},
  "Camera": {"viewpoint": [0, 0, 4], "viewcenter": [0, 0, 0]}})";

State state(const std::string& text = kState) { return readState(text, "scene.json").state; }

SweptPictures swept(const std::string& axes, const State& of = state()) {
  const Sweep sweep = readSweep("{\"axes\": [" + axes + "]}", "sweep.json");
  EXPECT_TRUE(sweep.warnings.empty()) << sweep.warnings.front();
  return sweptPictures(sweep, of, [](const std::string& text) { return readState(text, "state"); });
}

std::vector<std::vector<std::string>> rowsOf(const SweptPictures& pictures, const std::string& time = "") {
  std::vector<std::vector<std::string>> rows;
  for (size_t p = 0; p < pictures.pictures.size(); p++) rows.push_back(pictures.parametersOf(p, time));
  return rows;
}

using Rows = std::vector<std::vector<std::string>>;

TEST(Sweep, TheLastAxisVariesFastest) {
  const SweptPictures s =
      swept(R"({"axis": "theta", "values": [-30, 0]}, {"axis": "phi", "from": 0, "to": 180, "count": 3})");
  EXPECT_EQ(s.columns, (std::vector<std::string>{"theta", "phi"}));
  EXPECT_EQ(rowsOf(s), (Rows{{"-30.0", "0.0"},
                             {"-30.0", "90.0"},
                             {"-30.0", "180.0"},
                             {"0.0", "0.0"},
                             {"0.0", "90.0"},
                             {"0.0", "180.0"}}));
  EXPECT_EQ(s.scenes.size(), 1u);
  const Camera camera = state().cameras[0];
  EXPECT_EQ(s.pictures[3].camera, camera);
  EXPECT_EQ(s.pictures[2].camera, orbited(camera, 180, -30, {0, 0, 0}));
}

TEST(Sweep, ValuesAreWrittenIntoTheState) {
  const SweptPictures s = swept(R"(
    {"axis": "isovalue", "index": 1, "values": [0.4, 0.6]},
    {"axis": "slice", "values": [1, 2]},
    {"axis": "clip", "operator": 1, "values": [-0.5]},
    {"axis": "colormap", "values": ["Viridis", "Turbo"]},
    {"axis": "key", "path": "/Renderer/tolerance", "values": [0.02, 1]})");
  ASSERT_EQ(s.pictures.size(), 16u);
  EXPECT_EQ(s.columns, (std::vector<std::string>{"isovalue", "slice", "clip", "colormap", "tolerance"}));
  EXPECT_EQ(rowsOf(s)[15], (std::vector<std::string>{"0.6", "2.0", "-0.5", "Turbo", "1.0"}));
  EXPECT_EQ(s.scenes.size(), 16u);
  const SweptScene& last = s.scenes[s.pictures[15].scene];
  State expected = readState(R"({"Visualization": {"operators": [
    {"type": "Volume", "dataset": "d", "isovalues": [0.25, 0.6], "slices": [[1, 0, 0, 2]], "colormap": "Turbo"},
    {"type": "Volume", "dataset": "d", "volume rendering": true, "clip planes": [[0, 0, 1, -0.5]]}]}})",
                             "")
                       .state;
  EXPECT_EQ(last.visualization, expected.visualizations[0]);
  EXPECT_EQ(last.settings.tolerance, 1);
  EXPECT_EQ(s.datasets.size(), 1u);
}

TEST(Sweep, EqualScenesAreOne) {
  const SweptPictures s =
      swept(R"({"axis": "isovalue", "values": [0.25, 0.5]}, {"axis": "phi", "values": [0, 10]},
    {"axis": "key", "path": "/Cameras/0/aov", "values": [20, 40]})");
  EXPECT_EQ(s.pictures.size(), 8u);
  EXPECT_EQ(s.scenes.size(), 2u);
  EXPECT_EQ(s.pictures[7].camera.aov, 40);
  EXPECT_EQ(s.scenes[s.pictures[0].scene].visualization, state().visualizations[0]);
}

TEST(Sweep, AnglesArePairsAndTheCenterMayBeSaid) {
  const Sweep sweep =
      readSweep(R"({"axes": [{"axis": "angles", "values": [[0, 90], [45, 0]]}], "center": [1, 0, 0]})", "s");
  const SweptPictures s =
      sweptPictures(sweep, state(), [](const std::string& t) { return readState(t, "state"); });
  EXPECT_EQ(s.columns, (std::vector<std::string>{"phi", "theta"}));
  EXPECT_EQ(rowsOf(s), (Rows{{"0.0", "90.0"}, {"45.0", "0.0"}}));
  EXPECT_EQ(s.pictures[1].camera, orbited(state().cameras[0], 45, 0, {1, 0, 0}));
}

TEST(Sweep, CamerasAreThoseOfTheState) {
  State some = state();
  some.cameras.push_back(some.cameras[0]);
  some.cameras[1].aov = 50;
  EXPECT_EQ(rowsOf(swept(R"({"axis": "camera"}, {"axis": "phi", "values": [0, 10]})", some)),
            (Rows{{"0", "0.0"}, {"0", "10.0"}, {"1", "0.0"}, {"1", "10.0"}}));
  const SweptPictures one = swept(R"({"axis": "camera", "values": [1]})", some);
  EXPECT_EQ(one.pictures.at(0).camera, some.cameras[1]);
  some.cameras.clear();
  EXPECT_EQ(swept(R"({"axis": "phi", "values": [0]})", some).pictures.at(0).camera, defaultCamera());
}

TEST(Sweep, TheTimeIsFilledInLater) {
  const SweptPictures s =
      swept(R"({"axis": "phi", "values": [0, 1]}, {"axis": "time"}, {"axis": "theta", "values": [5]})");
  EXPECT_EQ(s.time, 1u);
  EXPECT_EQ(rowsOf(s, "2.5"), (Rows{{"0.0", "2.5", "5.0"}, {"1.0", "2.5", "5.0"}}));
}

TEST(Sweep, OtherValuesHaveLabels) {
  const SweptPictures s =
      swept(R"({"axis": "key", "path": "/Renderer/background", "values": [[0, 0, 0], [1, 1, 1]],
    "labels": ["black", "white"]}, {"axis": "key", "path": "/Visualizations/0/Lighting/shadows", "values": [false, true]})");
  EXPECT_EQ(rowsOf(s), (Rows{{"black", "false"}, {"black", "true"}, {"white", "false"}, {"white", "true"}}));
  EXPECT_EQ(s.scenes[s.pictures[3].scene].settings.background, glm::dvec4(1));
  EXPECT_TRUE(s.scenes[s.pictures[3].scene].visualization.lighting.shadows);
}

TEST(Sweep, AnIsovalueMayBeTheFirst) {
  const State none = state(
      R"({"Visualization": {"operators": [{"type": "Volume", "dataset": "d", "volume rendering": true}]}})");
  const SweptPictures s = swept(R"({"axis": "isovalue", "values": [3]})", none);
  EXPECT_EQ(s.scenes[0].visualization.operators[0].isovalues, std::vector<double>{3});
}

TEST(Sweep, KeysOfDatasetsMakeOtherDatasets) {
  const SweptPictures s = swept(R"({"axis": "key", "path": "/Datasets/0/array", "values": ["p", "t"]})");
  ASSERT_EQ(s.datasets.size(), 2u);
  EXPECT_EQ(s.datasets[1][0].array, "t");
  EXPECT_EQ(s.stateOf(1).visualizations.size(), 1u);
  EXPECT_EQ(s.scenesOf(1), std::vector<size_t>{1});
}

std::string sweepError(const std::string& text) {
  return errorOf([&] { readSweep(text, "sweep.json"); });
}
std::string axisError(const std::string& axis) { return sweepError("{\"axes\": [\n" + axis + "]}"); }

TEST(Sweep, AWrongTextNamesPlaceKeyAndExpectation) {
  EXPECT_EQ(sweepError("[]"), "sweep.json:1:1: expected an object (sweep), found an array of 0 values");
  EXPECT_EQ(sweepError("{}"), "sweep.json:1:1: sweep without `axes`; expected list of axes");
  EXPECT_EQ(sweepError(R"({"axes": []})"),
            "sweep.json:1:10: `axes`: expected a list of one axis or more, found an array of 0 values");
  EXPECT_EQ(axisError(R"({"axis": "psi", "values": [1]})"),
            "sweep.json:2:10: `axis`: expected phi, theta, angles, camera, isovalue, slice, clip, colormap, "
            "key or time, found \"psi\"; "
            "did you mean `phi`?");
  EXPECT_EQ(axisError(R"({"axis": "phi"})"),
            "sweep.json:2:1: axis without `values`; expected a list of them");
  EXPECT_EQ(axisError(R"({"axis": "phi", "values": [1, "x"]})"),
            "sweep.json:2:31: `values[1]`: expected a number, found \"x\"");
  EXPECT_EQ(axisError(R"({"axis": "phi", "values": [1, 2, 1.0]})"),
            "sweep.json:2:34: `values`: \"1.0\" is given twice, expected different values");
  EXPECT_EQ(axisError(R"({"axis": "phi", "from": 1, "to": 2})"),
            "sweep.json:2:1: axis: expected `values`, or else `from`, `to` and `count` together, with `from` "
            "other than `to`");
  EXPECT_EQ(axisError(R"({"axis": "angles", "values": [1]})"),
            "sweep.json:2:31: `values[0]`: expected [phi, theta], found 1");
  EXPECT_EQ(axisError(R"({"axis": "phi", "values": [1]}, {"axis": "phi", "name": "b", "values": [1]})"),
            "sweep.json:2:33: axis: expected one axis of phi and one of theta, or one of angles");
  EXPECT_EQ(axisError(R"({"axis": "isovalue", "values": [1]}, {"axis": "isovalue", "values": [1]})"),
            "sweep.json:2:38: axis: there is a column \"isovalue\" already, expected another `name`");
  EXPECT_EQ(axisError(R"({"axis": "phi", "name": "FILE", "values": [1]})"),
            "sweep.json:2:25: `name`: expected a name that does not begin with FILE, found \"FILE\"");
  EXPECT_EQ(axisError(R"({"axis": "phi", "name": "7", "values": [1]})"),
            "sweep.json:2:25: `name`: expected a text of 1 to 64 bytes that is no number, without blanks "
            "around it, found \"7\"");
  EXPECT_EQ(axisError(R"({"axis": "key", "values": [1]})"),
            "sweep.json:2:1: axis without `path`; expected a JSON Pointer such as \"/Renderer/tolerance\"");
  EXPECT_NE(axisError(R"({"axis": "key", "path": "/a", "values": [1, "x"]})")
                .find("expected numbers only, or texts only"),
            std::string::npos);
  EXPECT_NE(axisError(R"({"axis": "key", "path": "/a", "values": [[1]]})").find("expected `labels`"),
            std::string::npos);
  EXPECT_EQ(
      axisError(
          R"({"axis": "phi", "from": 0, "to": 1, "count": 101}, {"axis": "theta", "from": 0, "to": 1, "count": 100})"),
      "sweep.json:2:52: axis: with it there are 10100 pictures or more, expected at most 10000 of one time");
  const Sweep warned =
      readSweep(R"({"axes": [{"axis": "time", "values": [1], "index": 0, "indx": 1}]})", "s");
  EXPECT_EQ(warned.warnings.size(), 3u);
  const Sweep odd = readSweep(
      R"({"axes": [{"axis": "angles", "values": [[1, 2]], "labels": ["a"], "from": 1, "name": "b"}]})", "s");
  EXPECT_EQ(odd.axes[0].values[0].cells, (std::vector<std::string>{"1.0", "2.0"}))
      << "keys without effect have none";
  EXPECT_EQ(odd.warnings.size(), 3u);
}

std::string mismatch(const std::string& axis, const State& of = state()) {
  return errorOf([&] { swept("\n" + axis, of); });
}

TEST(Sweep, WhatDoesNotFitTheStateIsSaidWithItsPlace) {
  EXPECT_EQ(mismatch(R"({"axis": "isovalue", "operator": 2, "values": [1]})"),
            "sweep.json:2:1: `operator`: there is no operator 2, expected 0 to 1");
  EXPECT_EQ(mismatch(R"({"axis": "isovalue", "index": 2, "values": [1]})"),
            "sweep.json:2:1: `index`: operator 0 has 2 of them, expected a smaller number, from 0 on");
  EXPECT_EQ(mismatch(R"({"axis": "slice", "operator": 1, "values": [1]})"),
            "sweep.json:2:1: `index`: operator 1 has 0 of them, expected a smaller number, from 0 on");
  EXPECT_EQ(mismatch(R"({"axis": "camera", "values": [0, 1]})"),
            "sweep.json:2:34: `values`: there is no camera 1, expected 0 to 0");
  EXPECT_EQ(mismatch(R"({"axis": "key", "path": "/Renderer/tolerance", "values": [0.1, -1]})"),
            "sweep.json:2:64: `values`: with \"-1.0\" the state is wrong: `tolerance`: expected a number > 0 "
            "and <= 1, found -1");
  EXPECT_EQ(mismatch(R"({"axis": "key", "path": "/Renderer/tolerence", "values": [0.1]})"),
            "sweep.json:2:59: `values`: with \"0.1\" the state is wrong: unknown key `tolerence` in the "
            "renderer; did you mean "
            "`tolerance`?");
  EXPECT_NE(mismatch(R"({"axis": "key", "path": "/Datasets/4/array", "values": ["a"]})")
                .find("leads nowhere in the state"),
            std::string::npos);
  EXPECT_NE(mismatch(R"({"axis": "colormap", "values": ["Viridish"]})").find("the state is wrong"),
            std::string::npos);
  State two = state();
  two.visualizations.push_back(two.visualizations[0]);
  EXPECT_EQ(mismatch(R"({"axis": "time"})", two), "sweep.json: the state has 2 visualizations, expected one");
  two.visualizations.pop_back();
  two.cameras.push_back(two.cameras[0]);
  EXPECT_EQ(mismatch(R"({"axis": "time"})", two),
            "sweep.json: the state has 2 cameras, expected one, or an axis \"camera\"");
}

TEST(Sweep, ValuesLeaveTheNumberOfVisualizationsAndCameras) {
  const auto key = [](const std::string& path, const std::string& value) {
    return R"({"axis": "key", "name": "n", "path": ")" + path + R"(", "labels": ["x"], "values": [)" + value +
           "]}";
  };
  const auto expect = [](const std::string& said, const std::string& why) {
    EXPECT_NE(said.find("`values`: with \"x\" the state is wrong: " + why), std::string::npos) << said;
  };
  const std::string one = R"({"operators": [{"type": "Volume", "dataset": "d", "volume rendering": true}]})";
  expect(mismatch(key("/Visualizations", "[]")), "the state has 0 visualizations, expected one");
  expect(mismatch(key("/Visualizations", "[" + one + ", " + one + "]")),
         "the state has 2 visualizations, expected one");
  expect(mismatch(key("/Cameras", "[{}, {}]")), "the state has 2 cameras, expected one, or an axis");
  const std::string cameras = R"({"axis": "camera"}, )";
  expect(mismatch(cameras + key("/Cameras", "[]")), "it has 0 cameras, expected 1 as without the sweep");
  expect(mismatch(cameras + key("/Cameras", "[{}, {}]")),
         "it has 2 cameras, expected 1 as without the sweep");
  expect(mismatch(R"({"axis": "slice", "values": [1]}, )" + key("/Visualizations/0", one)),
         "`index`: operator 0 has 0 of them");
  State none = state();
  none.visualizations[0].operators.clear();
  EXPECT_EQ(mismatch(R"({"axis": "isovalue", "values": [1]})", none),
            "sweep.json:2:1: axis: the visualization has no operators, expected one or more");
}

TEST(Sweep, NamesOfFilesThatAreTooLongAreRefused) {
  const auto axis = [](const char* path, const std::string& label) {
    return std::string(R"({"axis": "key", "path": ")") + path + R"(", "values": [0.5], "labels": [")" +
           label + "\"]}";
  };
  const std::string first = axis("/Renderer/tolerance", std::string(64, '_')) + ", ";  // 192 bytes
  EXPECT_EQ(swept(first + axis("/Cameras/0/aov", "seven..")).pictures.size(), 1u);
  EXPECT_NE(mismatch(first + axis("/Cameras/0/aov", "eight...")).find("a name of 201 bytes"),
            std::string::npos);
}

TEST(Sweep, MadeScenesCanBeCancelled) {
  const Sweep sweep = readSweep(R"({"axes": [{"axis": "isovalue", "from": 0, "to": 1, "count": 50}]})", "s");
  int calls = 0;
  const auto check = [&] {
    if (++calls == 7) throw Error("cancelled");
  };
  EXPECT_EQ(errorOf([&] {
              sweptPictures(
                  sweep, state(), [](const std::string& t) { return readState(t, "state"); }, check);
            }),
            "cancelled");
}

}  // namespace
}  // namespace gxy
