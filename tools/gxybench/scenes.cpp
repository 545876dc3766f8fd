// SPDX-License-Identifier: Apache-2.0
#include "tools/gxybench/scenes.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <optional>

#include "core/comm/error.h"
#include "core/scene/state_file.h"
#include "core/scene/state_pictures.h"
#include "tools/gxydata/commands.h"

namespace gxy::bench {
namespace {

using data_tool::Field;

constexpr double kReferenceLength = 1.0 / 128;  // for the maps below: a cell of 256^3 points on [-1, 1]^3

/// Sizes of the data and the picture.
struct Sizes {
  int64_t volume, small, particles, meshRows;
  double particleRadius;
  int picture, mixedPicture;  ///< pixels a side; references of mixed scenes take long
};
constexpr Sizes kFull{256, 41, 1000000, 512, 0.002, 512, 256}, kQuick{48, 25, 2000, 24, 0.02, 80, 64};

const ColorMap kColors{{{0, {0.1, 0.2, 0.8}}, {0.5, {0.9, 0.85, 0.7}}, {1, {0.9, 0.2, 0.1}}}};

struct NamedMap {
  const char* name;
  std::vector<OpacityPoint> points;
};
const NamedMap kSmooth{"smooth", {{0, 0}, {0.3, 0}, {1, 0.06}}};
const NamedMap kSpiky{
    "spiky", {{0, 0}, {0.43, 0}, {0.45, 0.37}, {0.47, 0}, {0.6, 0}, {0.62, 0.37}, {0.64, 0}, {1, 0}}};
const NamedMap kStepped{
    "stepped",
    {{0, 0}, {0.4, 0}, {0.4, 0.05}, {0.6, 0.05}, {0.6, 0.01}, {0.75, 0.01}, {0.75, 0.1}, {1, 0.1}}};
const NamedMap kNearlyOpaque{"nearly-opaque", {{0, 0}, {0.35, 0}, {0.6, 0.9}, {1, 0.95}}};
const NamedMap kNearlyTransparent{"nearly-transparent", {{0, 0}, {1, 0.002}}};
const NamedMap kLinear{"linear", {{0, 0}, {1, 0.145}}};

Field smoothField() {
  return {"smooth", [](glm::dvec3 p, double) {
            return float(0.5 + 0.25 * std::sin(2 * p.x + p.y) * std::cos(2 * p.z) +
                         0.2 * std::sin(3 * p.y - p.x));
          }};
}

/// The camera of the scenes on which peers are compared: view 0 of an orbit about the origin.
Camera orbitCamera(int pixels) {
  const double distance = 4.4, elevation = 20 * std::numbers::pi / 180, azimuth = 0.3;
  Camera camera;
  camera.viewpoint = distance * glm::dvec3(std::cos(elevation) * std::cos(azimuth), std::sin(elevation),
                                           std::cos(elevation) * std::sin(azimuth));
  camera.viewdirection = -camera.viewpoint;
  camera.aov = 45;
  camera.dimensions = {pixels, pixels};
  return camera;
}

/// A name that changes with the field's values.
std::string nameOf(const Field& field, int64_t points) {
  uint32_t print = 2166136261u;
  for (int i = 0; i < 64; i++) {
    const auto at = [&](uint64_t a) { return 2 * data_tool::uniform(7, uint64_t(3 * i) + a) - 1; };
    const float value = field.value({at(0), at(1), at(2)}, 0);
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", double(value));
    for (const char* c = text; *c; c++) print = (print ^ uint32_t(*c)) * 16777619u;
  }
  char name[64];
  std::snprintf(name, sizeof name, "%s-%lld-%08x.vti", field.name.c_str(), static_cast<long long>(points),
                print);
  return name;
}

std::string geometryName(const char* kind, int64_t count) {
  return std::string(kind) + "-" + std::to_string(count) + "-v" +
         std::to_string(data_tool::kGeometryVersion) + ".vtp";
}

class Maker {
 public:
  explicit Maker(const Sizes& sizes) : sizes_(sizes) {}

  Scene volume(const Field& field, int64_t points, const NamedMap& map, const char* about) const {
    Scene scene = empty(field.name + "-" + std::to_string(points) + "-" + map.name, about);
    addVolume(scene, field, points);
    scene.state.visualizations[0].operators[0].volumeRendering = true;
    scene.state.visualizations[0].operators[0].opacitymap.points = map.points;
    return scene;
  }

  Scene isosurface(const Field& field, int64_t points, double value, const char* about) const {
    Scene scene = empty(field.name + "-" + std::to_string(points) + "-isosurface", about);
    addVolume(scene, field, points);
    scene.state.visualizations[0].operators[0].isovalues = {value};
    return scene;
  }

  /// A field at the points of tetrahedra or hexahedra, as many as cubes of a grid of points^3 have, with bent faces. An `isovalue` takes the
  /// place of the map.
  Scene cells(const char* kind, const Field& field, int64_t points, const NamedMap& map, const char* about,
              std::optional<double> isovalue = std::nullopt) const {
    Scene scene = empty(
        field.name + "-" + kind + "-" + std::to_string(points) + "-" + (isovalue ? "isosurface" : map.name),
        about);
    const auto make = [field, points, kind](const std::string& path) {
      data_tool::Options options;
      options.resolution = {points, points, points};
      options.cells = kind;
      options.displacement = 0.12;
      options.out = path;
      data_tool::makeVolume({field}, options);
    };
    const std::string name = std::filesystem::path(nameOf(field, points)).stem().string();
    Vis& vis = add(
        scene, DatasetType::Volume, VisType::Volume,
        {std::string(kind) + "-" + name + "-v" + std::to_string(data_tool::kGeometryVersion) + ".vtu", make});
    vis.referenceLength = kReferenceLength;
    if (isovalue) {
      vis.isovalues = {*isovalue};
    } else {
      vis.volumeRendering = true;
      vis.opacitymap.points = map.points;
    }
    return scene;
  }

  Scene spheres() const {
    Scene scene = empty("spheres-" + std::to_string(sizes_.particles), "clustered particles, with shadows");
    addSpheres(scene);
    return scene;
  }

  Scene mesh() const {
    Scene scene =
        empty("mesh-" + std::to_string(meshTriangles()), "a bumpy sphere of triangles, with shadows");
    addMesh(scene);
    return scene;
  }

  Scene mixed() const {
    Scene scene = volume(data_tool::turbulence(1), sizes_.volume, kSmooth,
                         "volume, isosurface, slice, spheres and a translucent mesh, with shadows");
    scene.name = "mixed-" + std::to_string(sizes_.volume);
    scene.state.cameras = {orbitCamera(sizes_.mixedPicture)};
    Vis& vis = scene.state.visualizations[0].operators[0];
    vis.isovalues = {0.75};
    vis.slices = {{{0, 0, 1}, -0.4}};
    vis.opacity = 0.8;
    addSpheres(scene);
    addMesh(scene);
    scene.state.visualizations[0].operators.back().opacity = 0.2;
    return scene;
  }

 private:
  int64_t meshTriangles() const { return 4 * sizes_.meshRows * (sizes_.meshRows - 1); }

  Scene empty(std::string name, std::string about) const {
    Scene scene{std::move(name), std::move(about), {}, {}, {}};
    scene.state.cameras = {orbitCamera(sizes_.picture)};
    Lighting& light = scene.state.visualizations.emplace_back().lighting;
    light.sources = {{LightType::Directional, {-1, -2, -1.5}}};
    light.Ka = 0.3;
    light.Kd = 0.7;
    return scene;
  }

  Vis& add(Scene& scene, DatasetType type, VisType vis, DataFile file) const {
    const std::string name = file.name.substr(0, file.name.find('.'));
    scene.state.datasets.push_back({name, type, file.name, {}, {0.8, 0.8, 0.8, 1}});
    scene.data.push_back(std::move(file));
    Vis& shown = scene.state.visualizations[0].operators.emplace_back();
    shown.type = vis;
    shown.dataset = name;
    shown.colormap = kColors;
    return shown;
  }

  void addVolume(Scene& scene, const Field& field, int64_t points) const {
    const auto make = [field, points](const std::string& path) {
      data_tool::Options options;
      options.resolution = {points, points, points};
      options.out = path;
      data_tool::makeVolume({field}, options);
    };
    add(scene, DatasetType::Volume, VisType::Volume, {nameOf(field, points), make}).referenceLength =
        kReferenceLength;
  }

  void addSpheres(Scene& scene) const {
    const auto make = [count = sizes_.particles](const std::string& path) {
      data_tool::Options options;
      options.count = count;
      options.out = path;
      data_tool::makeParticles(options);
    };
    scene.state.visualizations[0].lighting.shadows = true;
    Vis& vis = add(scene, DatasetType::Particles, VisType::Particles,
                   {geometryName("particles", sizes_.particles), make});
    vis.radius0 = sizes_.particleRadius;
    vis.dataRange = {0, 4};
  }

  void addMesh(Scene& scene) const {
    const auto make = [rows = sizes_.meshRows](const std::string& path) {
      data_tool::Options options;
      options.count = rows;
      options.displacement = 0.1;
      options.out = path;
      data_tool::makeSphereMesh(options);
    };
    scene.state.visualizations[0].lighting.shadows = true;
    Vis& vis =
        add(scene, DatasetType::Triangles, VisType::Triangles, {geometryName("mesh", meshTriangles()), make});
    vis.dataRange = {-1, 1};
  }

  Sizes sizes_;
};

}  // namespace

std::vector<Scene> fixedScenes(bool quick) {
  const Sizes& sizes = quick ? kQuick : kFull;
  const Maker maker(sizes);
  const Field ml = data_tool::marschnerLobb(), smooth = smoothField(), turbulent = data_tool::turbulence(1),
              sparse = data_tool::sparse(1);
  const int64_t n = sizes.volume;
  if (quick)
    return {maker.volume(ml, sizes.small, kSmooth, "the test signal, coarse, under a ramp"),
            maker.isosurface(ml, sizes.small, 0.5, "the test signal's isosurface"),
            maker.volume(turbulent, n, kSpiky, "six octaves of noise under two peaks"),
            maker.volume(turbulent, n, kNearlyOpaque, "opaque after a cell"),
            maker.volume(smooth, n, kStepped, "a field of long waves under a staircase"),
            maker.volume(sparse, n, kSpiky, "mostly empty, under two narrow peaks"),
            maker.cells("tetrahedra", turbulent, 9, kSpiky, "noise in tetrahedra under two peaks"),
            maker.cells("hexahedra", turbulent, 9, kSmooth, "noise in bent hexahedra under a ramp"),
            maker.spheres(),
            maker.mesh(),
            maker.mixed()};
  return {
      maker.volume(ml, sizes.small, kSmooth, "the test signal of Marschner and Lobb, coarse, under a ramp"),
      maker.volume(ml, n, kSmooth, "the same, fine"),
      maker.volume(ml, n, kSpiky, "under two narrow peaks"),
      maker.volume(smooth, n, kSmooth, "a field of long waves under a ramp"),
      maker.volume(smooth, n, kStepped, "under a staircase"),
      maker.volume(turbulent, n, kSmooth, "six octaves of noise under a ramp"),
      maker.volume(turbulent, n, kSpiky, "under two narrow peaks"),
      maker.volume(turbulent, n, kStepped, "under a staircase"),
      maker.volume(turbulent, n, kNearlyOpaque, "opaque after a cell"),
      maker.volume(turbulent, n, kNearlyTransparent, "thin everywhere"),
      maker.volume(sparse, n, kLinear, "mostly empty: transparent only where the field is 0"),
      maker.volume(sparse, n, kSpiky, "mostly empty, under two narrow peaks"),
      maker.isosurface(ml, sizes.small, 0.5, "the test signal's isosurface, coarse"),
      maker.isosurface(ml, n, 0.5, "the same, fine"),
      maker.isosurface(turbulent, n, 0.5, "an isosurface with very many sheets"),
      maker.isosurface(sparse, n, 0.3, "an isosurface in mostly empty space"),
      maker.cells("tetrahedra", turbulent, 65, kSmooth, "noise in 1.6 million tetrahedra under a ramp"),
      maker.cells("tetrahedra", turbulent, 65, kSpiky, "under two narrow peaks"),
      maker.cells("tetrahedra", sparse, 65, kSpiky, "mostly empty, under two narrow peaks"),
      maker.cells("tetrahedra", turbulent, 65, kSmooth, "an isosurface with very many sheets", 0.5),
      maker.cells("hexahedra", turbulent, 65, kSmooth, "noise in 262,144 bent hexahedra under a ramp"),
      maker.cells("hexahedra", turbulent, 65, kSpiky, "under two narrow peaks"),
      maker.cells("hexahedra", sparse, 65, kSpiky, "mostly empty, under two narrow peaks"),
      maker.cells("hexahedra", turbulent, 65, kSmooth, "an isosurface with very many sheets", 0.5),
      maker.spheres(),
      maker.mesh(),
      maker.mixed()};
}

std::vector<Scene> scenesOf(const std::string& stateFile,
                            const std::function<void(const std::string&)>& warn) {
  const StateFile file = readStateFile(stateFile);
  for (const std::string& w : file.warnings) warn(w);
  const std::filesystem::path path = std::filesystem::absolute(stateFile);
  std::vector<Scene> scenes;
  for (const StatePicture& picture : picturesOf(file.state)) {
    State state = file.state;
    state.visualizations = {file.state.visualizations[picture.visualization]};
    state.visualizations[0].view = {};
    state.cameras = {picture.camera};
    scenes.push_back({path.stem().string(), stateFile, state, path.parent_path().string(), {}});
  }
  if (scenes.empty()) throw Error(stateFile + ": there is no visualization to measure");
  if (scenes.size() > 1)
    for (size_t i = 0; i < scenes.size(); i++) scenes[i].name += "-" + std::to_string(i);
  return scenes;
}

void makeData(Scene& scene, const std::string& folder) {
  if (scene.directory.empty()) scene.directory = std::filesystem::absolute(folder).string();
  for (const DataFile& file : scene.data) {
    const std::filesystem::path path = std::filesystem::path(folder) / file.name;
    if (std::filesystem::exists(path)) continue;
    std::filesystem::create_directories(folder);
    const std::filesystem::path partial = std::filesystem::path(folder) / ("partial-" + file.name);
    file.make(partial.string());
    std::filesystem::rename(partial, path);
  }
}

}  // namespace gxy::bench
