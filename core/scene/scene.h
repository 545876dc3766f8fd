// SPDX-License-Identifier: Apache-2.0
// How to look at data: cameras, lights, maps, Vis operators, visualizations. Plain values, as the state file
// holds them.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <string>
#include <vector>

namespace gxy {

/// A camera in world coordinates. `aov` is the full angle, in degrees, over the smaller image dimension; 0
/// means orthographic, with a window `height` world units high over the smaller dimension.
struct Camera {
  glm::dvec3 viewpoint{0, 0, 4};
  glm::dvec3 viewdirection{0, 0, -1};  ///< from viewpoint to viewcenter where the file gives that; any length
  glm::dvec3 viewup{0, 1, 0};
  double aov = 30;
  double height = 2;
  glm::ivec2 dimensions{512, 512};
  std::string annotation;
  bool fit =
      false;  ///< the viewpoint (orthographic: height, too) is such that the data fill the picture; fitted()
  bool operator==(const Camera&) const = default;
};

enum class LightType : uint8_t {
  Directional,  ///< v: the direction in which light travels, world
  Camera,       ///< v: position as an offset along (right, up, view) axes of the camera
  Point         ///< v: position, world
};
struct Light {
  LightType type = LightType::Point;
  glm::dvec3 v{1, 1, 1};
  bool operator==(const Light&) const = default;
};

struct Lighting {
  std::vector<Light> sources = std::vector<Light>(1);
  bool shadows = false;
  int aoCount = 0;
  double aoRadius = 1;                                ///< world units
  double Ka = 0.5, Kd = 0.5, Ks = 0, shininess = 20;  ///< Kd is shared equally among the lights
  bool operator==(const Lighting&) const = default;
};

struct ColorPoint {
  double value;
  glm::dvec3 rgb;
  bool operator==(const ColorPoint&) const = default;
};
struct OpacityPoint {
  double value, opacity;
  bool operator==(const OpacityPoint&) const = default;
};

/// Colour by value: linear between its points, clamped outside. Points ascend; two equal values are a step
/// (the later point holds from that value on). Never empty. rgb in [0, 1].
struct ColorMap {
  std::vector<ColorPoint> points;
  std::optional<glm::dvec3> nan{};  ///< the colour of geometry whose value is NaN; absent: the first point's
  bool operator==(const ColorMap&) const = default;
};

/// Opacity by value, of a slab one reference length thick; or, for an `extinctionmap`, extinction per world
/// unit. Points as in ColorMap; opacity in [0, 1], extinction >= 0.
struct OpacityMap {
  bool extinction = false;
  std::vector<OpacityPoint> points;
  bool operator==(const OpacityMap&) const = default;
};

enum class VisType : uint8_t { Volume, Particles, PathLines, Triangles };

/// The plane normal . p = offset, world coordinates; any normal length but 0. As a clip plane it keeps
/// normal . p >= offset.
struct Plane {
  glm::dvec3 normal{1, 0, 0};
  double offset = 0;
  bool operator==(const Plane&) const = default;
};

/// Planes that keep what is inside a box.
inline std::array<Plane, 6> planesAround(const glm::dvec3& lo, const glm::dvec3& hi) {
  return {{{{1, 0, 0}, lo.x},
           {{-1, 0, 0}, -hi.x},
           {{0, 1, 0}, lo.y},
           {{0, -1, 0}, -hi.y},
           {{0, 0, 1}, lo.z},
           {{0, 0, -1}, -hi.z}}};
}

/// One operator of a visualization: a dataset and every parameter of how to look at it.
struct Vis {
  VisType type = VisType::Volume;
  std::string dataset;           ///< name of the dataset
  std::optional<int> component;  ///< of a volume with several; absent: the magnitude
  ColorMap colormap{{{0, glm::dvec3(0.4)}, {1, glm::dvec3(1)}}};
  OpacityMap opacitymap{false, {{0, 1}}};
  std::optional<std::array<double, 2>> dataRange;  ///< maps the maps' own ends onto these values
  std::optional<double> referenceLength;           ///< world units; absent: the smallest cell spacing
  double opacity = 1;                              ///< of surfaces: isosurfaces, slices, geometry
  std::vector<Plane> clipPlanes;
  // Volume
  bool volumeRendering = false;
  std::vector<double> isovalues;
  std::vector<Plane> slices;
  // Particles and PathLines: radius r0 at value v0 to r1 at v1, clamped; v0 == v1: constant r0. A radius <= 0
  // draws nothing. PathLines in a state file start from -1, 1, 0, 1, as the earlier Galaxy's do.
  double radius0 = 0.025, radius1 = 0, value0 = 0, value1 = 0;
  bool twoSided = true;  ///< normals face the viewer
  // What is asked of the data instead of said; resolved() makes numbers of it.
  bool rangeOfData = false;   ///< dataRange is that of the data
  bool radiusOfData = false;  ///< the radii are a part of the mean spacing of points
  bool operator==(const Vis&) const = default;
};

struct Visualization {
  std::string annotation;
  Lighting lighting;
  std::vector<Vis> operators;
  bool operator==(const Visualization&) const = default;
};

enum class DatasetType : uint8_t { Volume, Particles, PathLines, Triangles };
struct DatasetSpec {
  std::string name;  ///< default: the file name
  DatasetType type = DatasetType::Volume;
  std::string filename;                ///< absolute, or relative to the state file
  std::string array;                   ///< of the file; empty: its active scalars, else its first array
  glm::dvec4 color{0.8, 0.8, 0.8, 1};  ///< of geometry whose file has no values to map
  std::string radiusArray{};           ///< of the file, gives radii; empty: the values do
  bool operator==(const DatasetSpec&) const = default;
};

/// What a rendering needs besides scene and camera.
struct RenderSettings {
  double tolerance = 1.0 / 512;  ///< error that every channel of every pixel stays below
  double step = 0;               ///< > 0: fixed step in cells instead, for comparison
  int raysPerPixel = 1;
  glm::dvec4 background{0, 0, 0, 1};
  std::optional<glm::dvec4> backgroundTop = {};  ///< makes a gradient, of which `background` is the bottom
  bool operator==(const RenderSettings&) const = default;
};

/// What is drawn over pictures for people; nothing, unless it is asked for.
struct Annotations {
  bool legend = false;   ///< colours of values, with titles and numbers
  bool axes = false;     ///< directions of the world's axes, in the lower left corner
  bool outline = false;  ///< the box of the data that are shown, with its extents
  std::string text;      ///< in the upper left corner; {step} and {time} become those of the time step
  bool operator==(const Annotations&) const = default;
};

/// A whole state file.
struct State {
  std::vector<DatasetSpec> datasets;
  RenderSettings settings;
  std::vector<Visualization> visualizations;
  std::vector<Camera> cameras;
  Annotations annotations;
  bool operator==(const State&) const = default;
};

}  // namespace gxy
