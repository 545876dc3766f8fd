// SPDX-License-Identifier: Apache-2.0
// State files as the earlier Galaxy's documentation and examples write them.
#include "core/scene/colormaps.h"
#include "core/scene/state_file.h"
#include "tests/scene/scene_test_support.h"

namespace gxy {
namespace {

size_t countOf(const std::vector<std::string>& warnings, const std::string& part) {
  size_t count = 0;
  for (const std::string& warning : warnings) count += warning.find(part) != std::string::npos;
  return count;
}

TEST(UpstreamState, ARadialVolumeWithSlicesIsosurfacesAndOldLighting) {
  const StateFile file = readState(R"({
  "Renderer": {
    "epsilon": 0.0001,
    "Lighting": { "Sources": [[1, 2, -4, 0], [3, 0, 5]], "shadows": true, "ao count": 16, "ao radius": 0.5,
                  "Ka": 0.4, "Kd": 0.6 }
  },
  "Datasets": [
    { "name": "oneBall", "type": "Volume", "filename": "radial-oneBall.vol" },
    { "type": "Volume", "filename": "radial-eightBalls.vol" }
  ],
  "Visualizations": [
    { "annotation": "volume",
      "operators": [
        { "type": "VolumeVis", "dataset": "oneBall", "volume rendering": true,
          "isovalues": [0.25, 0.5], "slices": [[1, 0, 0, 0], [0, 1, 0, 0.5]], "plane": [0, 0, 1, 0.25],
          "colormap": [[0.0, 1, 0.5, 0.5], [0.5, 0.5, 1, 0.5], [1.0, 0.5, 0.5, 1]],
          "opacitymap": [[0, 0.0], [1, 0.05]], "data range": [0, 2] }
      ] },
    { "lighting": { "Sources": [] },
      "operators": [ { "type": "Volume", "dataset": "radial-eightBalls.vol", "isovalues": [0.25], "colormap": "" } ] }
  ],
  "zVisualizations": [],
  "Cameras": [
    { "aov": 35, "viewpoint": [3.0, 2.0, -4.0], "viewdirection": [-3.0, -2.0, 4.0], "viewup": [0.0, 1.0, 0.0] },
    { "aov": 0, "viewpoint": [1, 2, 3], "viewcenter": [1, 0, 0], "viewup": [0, 1, 0], "dimensions": [640, 360],
      "annotation": "ortho" }
  ]
})",
                                   "state.json");
  const State& state = file.state;
  ASSERT_EQ(state.datasets.size(), 2u);
  EXPECT_EQ(state.datasets[0],
            (DatasetSpec{"oneBall", DatasetType::Volume, "radial-oneBall.vol", "", {0.8, 0.8, 0.8, 1}}));
  EXPECT_EQ(state.datasets[1].name, "radial-eightBalls.vol");

  ASSERT_EQ(state.visualizations.size(), 2u);
  const Visualization& first = state.visualizations[0];
  EXPECT_EQ(first.annotation, "volume");
  Lighting old;
  old.sources = {{LightType::Directional, {1, 2, -4}}, {LightType::Point, {3, 0, 5}}};
  old.shadows = true;
  old.aoCount = 16;
  old.aoRadius = 0.5;
  old.Ka = 0.4;
  old.Kd = 0.6;
  EXPECT_EQ(first.lighting, old);
  Lighting own;
  own.sources.clear();
  EXPECT_EQ(state.visualizations[1].lighting, own);

  ASSERT_EQ(first.operators.size(), 1u);
  Vis volume;
  volume.dataset = "oneBall";
  volume.volumeRendering = true;
  volume.isovalues = {0.25, 0.5};
  volume.slices = {{{1, 0, 0}, 0}, {{0, 1, 0}, 0.5}, {{0, 0, 1}, 0.25}};
  volume.colormap = {{{0, {1, 0.5, 0.5}}, {0.5, {0.5, 1, 0.5}}, {1, {0.5, 0.5, 1}}}};
  volume.opacitymap = {false, {{0, 0}, {1, 0.05}}};
  volume.dataRange = {0, 2};
  EXPECT_EQ(first.operators[0], volume);

  ASSERT_EQ(state.cameras.size(), 2u);
  EXPECT_EQ(state.cameras[0].viewdirection, glm::dvec3(-3, -2, 4));
  EXPECT_EQ(state.cameras[0].dimensions, glm::ivec2(512, 512));
  EXPECT_EQ(state.cameras[1].viewdirection, glm::dvec3(0, -2, -3));
  EXPECT_EQ(state.cameras[1].aov, 0);
  EXPECT_EQ(state.cameras[1].height, 2);
  EXPECT_EQ(state.cameras[1].dimensions, glm::ivec2(640, 360));
  EXPECT_EQ(state.cameras[1].annotation, "ortho");

  EXPECT_EQ(file.warnings.size(), 3u);
  EXPECT_EQ(countOf(file.warnings, "state.json:3:16: `epsilon`: deprecated"), 1u);
  EXPECT_EQ(countOf(file.warnings, "state.json:4:17: deprecated: `Lighting` of the renderer"), 1u);
  EXPECT_EQ(countOf(file.warnings, "state.json:22:3: unknown key `zVisualizations`"), 1u);
}

TEST(UpstreamState, SingularKeysTakeOneObject) {
  const State state = readState(R"({
    "Datasets": { "name": "p", "type": "Particles", "filename": "p.part", "default color": [1, 0, 0] },
    "Visualization": { "operators": [ { "type": "Particles", "dataset": "p", "radius": 0.5 } ] },
    "Camera": { "viewpoint": [0, 0, -5], "viewcenter": [0, 0, 0], "viewup": [0, 1, 0], "aov": 30 } })",
                                "state.json")
                          .state;
  ASSERT_EQ(state.datasets.size(), 1u);
  EXPECT_EQ(state.datasets[0].color, glm::dvec4(1, 0, 0, 1));
  ASSERT_EQ(state.visualizations.size(), 1u);
  const Vis& vis = state.visualizations[0].operators.at(0);
  EXPECT_EQ(vis.radius0, 0.5);
  EXPECT_EQ(vis.value0, vis.value1);
  ASSERT_EQ(state.cameras.size(), 1u);
  EXPECT_EQ(state.cameras[0].viewdirection, glm::dvec3(0, 0, 5));
}

TEST(UpstreamState, OperatorTypesWithTheirAliasesAndRadiusDefaults) {
  const State state = readState(R"({"Visualization": {"operators": [
    {"type": "Volume", "dataset": "d", "isovalues": [1]}, {"type": "VolumeVis", "dataset": "d", "isovalues": [1]},
    {"type": "Particles", "dataset": "d"}, {"type": "ParticlesVis", "dataset": "d"},
    {"type": "PathLines", "dataset": "d"}, {"type": "PathLinesVis", "dataset": "d"},
    {"type": "Triangles", "dataset": "d"}, {"type": "TrianglesVis", "dataset": "d"},
    {"type": "Surface", "dataset": "d"}, {"type": "SurfaceVis", "dataset": "d"}]}})",
                                "s")
                          .state;
  const auto& operators = state.visualizations.at(0).operators;
  const VisType expected[] = {VisType::Volume, VisType::Particles, VisType::PathLines, VisType::Triangles,
                              VisType::Triangles};
  for (size_t i = 0; i < 10; ++i) EXPECT_EQ(operators.at(i).type, expected[i / 2]) << i;
  const Vis &particles = operators[2], &lines = operators[4];
  EXPECT_EQ(particles.radius0, 0.025);
  EXPECT_EQ(particles.radius1, 0);
  EXPECT_EQ(particles.value1, 0);
  EXPECT_EQ(lines.radius0, -1);
  EXPECT_EQ(lines.radius1, 1);
  EXPECT_EQ(lines.value0, 0);
  EXPECT_EQ(lines.value1, 1);
}

TEST(UpstreamState, AColormapMayBeAFileNextToTheStateFile) {
  const ScratchDirectory scratch;
  scratch.write("map.json",
                R"([{"RGBPoints": [0, 1, 0, 0, 2, 0, 0, 1], "Points": [0, 0, 0.5, 0, 2, 0.5, 0.5, 0]}])");
  const auto path = scratch.write("state.json", R"({"Visualization": {"operators": [
    {"type": "Volume", "dataset": "d", "volume rendering": true, "transfer function": "map.json"},
    {"type": "Volume", "dataset": "d", "volume rendering": true, "colormap": "map.json", "opacitymap": [[0, 1]]},
    {"type": "Volume", "dataset": "d", "volume rendering": true, "colormap": "default"},
    {"type": "Volume", "dataset": "d", "volume rendering": true, "colormap": "Viridis"}]}})");
  const auto operators = readStateFile(path).state.visualizations.at(0).operators;
  EXPECT_EQ(operators.at(0).colormap, (ColorMap{{{0, {1, 0, 0}}, {2, {0, 0, 1}}}}));
  EXPECT_EQ(operators[0].opacitymap, (OpacityMap{false, {{0, 0}, {2, 0.5}}}));
  EXPECT_EQ(operators.at(1).opacitymap, (OpacityMap{false, {{0, 1}}}));
  EXPECT_EQ(operators.at(2).colormap, Vis{}.colormap);
  EXPECT_EQ(operators.at(3).colormap, *shippedColorMap("Viridis"));
}

TEST(UpstreamState, ACameraMayBeAParaViewFile) {
  const ScratchDirectory scratch;
  scratch.write("c.json", R"({"PVCameraConfiguration": {"Proxy": {"Property": [
    {"@name": "CameraPosition", "Element": [{"@value": "0"}, {"@value": "0"}, {"@value": "9"}]},
    {"@name": "CameraFocalPoint", "Element": [{"@value": "0"}, {"@value": "0"}, {"@value": "1"}]},
    {"@name": "CameraViewUp", "Element": [{"@value": "0"}, {"@value": "1"}, {"@value": "0"}]}]}}})");
  const auto path = scratch.write(
      "state.json", R"({"Cameras": ["c.json", {"viewpoint": [1, 1, 1], "viewcenter": [0, 0, 0]}]})");
  const State state = readStateFile(path).state;
  ASSERT_EQ(state.cameras.size(), 2u);
  EXPECT_EQ(state.cameras[0].viewpoint, glm::dvec3(0, 0, 9));
  EXPECT_EQ(state.cameras[0].viewdirection, glm::dvec3(0, 0, -8));
}

}  // namespace
}  // namespace gxy
