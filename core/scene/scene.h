// SPDX-License-Identifier: Apache-2.0
// The content of a state file as plain values: datasets, cameras, lights, maps, operators (Vis), visualizations.
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

/// A camera in world coordinates. `aov` is the full angle of view, in degrees, over the smaller image
/// dimension. 0 means orthographic: then the smaller dimension spans `height` world units.
struct Camera {
  glm::dvec3 viewpoint{0, 0, 4};
  glm::dvec3 viewdirection{0, 0, -1};  ///< any length; viewcenter - viewpoint if the file gives a viewcenter
  glm::dvec3 viewup{0, 1, 0};
  double aov = 30;
  double height = 2;
  glm::ivec2 dimensions{512, 512};
  std::string annotation;
  /// fitted() is to choose the viewpoint (and the height, if orthographic) so that the data fill the picture.
  bool fit = false;
  bool operator==(const Camera&) const = default;
};

enum class LightType : uint8_t {
  Directional,  ///< v: direction in which light travels, world coordinates
  Camera,       ///< v: position, as an offset from the camera along its (right, up, view) axes
  Point         ///< v: position, world coordinates
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
  double Ka = 0.5, Kd = 0.5, Ks = 0, shininess = 20;  ///< each light gets an equal share of Kd
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

/// Colour by value: linear between its points, constant outside. Points ascend. Two points with equal values
/// make a step, where the later point holds from that value on. There is at least one point. rgb is in [0, 1].
struct ColorMap {
  std::vector<ColorPoint> points;
  std::optional<glm::dvec3> nan{};  ///< colour of geometry whose value is NaN; absent: the first point's
  bool operator==(const ColorMap&) const = default;
};

/// Opacity by value, for a slab one reference length thick. With `extinction` (the key `extinctionmap`) it is
/// extinction per world unit by value. Points are as in ColorMap; opacity is in [0, 1], extinction >= 0.
struct OpacityMap {
  bool extinction = false;
  std::vector<OpacityPoint> points;
  bool operator==(const OpacityMap&) const = default;
};

/// How the data of cells of an unstructured volume are shown: each cell in its own value, or as a continuous field of averages at points.
enum class CellsShown : uint8_t { Flat, Smooth };

enum class VisType : uint8_t { Volume, Particles, PathLines, Triangles };

/// The plane normal . p = offset in world coordinates. The normal has any length but 0. A clip plane keeps
/// the side normal . p >= offset.
struct Plane {
  glm::dvec3 normal{1, 0, 0};
  double offset = 0;
  bool operator==(const Plane&) const = default;
};

/// Returns clip planes that keep the inside of a box.
inline std::array<Plane, 6> planesAround(const glm::dvec3& lo, const glm::dvec3& hi) {
  return {{{{1, 0, 0}, lo.x},
           {{-1, 0, 0}, -hi.x},
           {{0, 1, 0}, lo.y},
           {{0, -1, 0}, -hi.y},
           {{0, 0, 1}, lo.z},
           {{0, 0, -1}, -hi.z}}};
}

/// One operator of a visualization: a dataset, and all parameters of showing it.
struct Vis {
  VisType type = VisType::Volume;
  std::string dataset;           ///< name of the dataset
  std::string array;             ///< of geometry: the field that gives values; empty: the dataset's values
  std::optional<int> component;  ///< of a volume or an array with several; absent: the magnitude
  ColorMap colormap{{{0, glm::dvec3(0.4)}, {1, glm::dvec3(1)}}};
  OpacityMap opacitymap{false, {{0, 1}}};
  std::optional<std::array<double, 2>> dataRange;  ///< both maps are stretched over these values
  std::optional<double> referenceLength;           ///< world units; absent: the smallest cell spacing
  double opacity = 1;                              ///< opacity of isosurfaces, slices and geometry
  std::vector<Plane> clipPlanes;
  // Volume
  bool volumeRendering = false;
  CellsShown cells = CellsShown::Flat;  ///< isosurfaces are always those of the averages
  std::vector<double> isovalues;
  std::vector<Plane> slices;
  /// Of samplings only: the distance (world units) between the places along a ray that it meets where the volume has data; 0:
  /// none. At least the longest side of the domain over kMostSteps.
  double every = 0;
  // Particles and PathLines: the radius is radius0 at value0 and radius1 at value1, linear between them and
  // constant outside. If value0 == value1, it is radius0 everywhere. A radius <= 0 draws nothing. In a state
  // file the four default to -1, 1, 0, 1 for PathLines, as in the earlier Galaxy.
  double radius0 = 0.025, radius1 = 0, value0 = 0, value1 = 0;
  bool twoSided = true;  ///< normals face the viewer
  // Parameters that come from the data; resolved() replaces them by numbers.
  bool rangeOfData = false;   ///< dataRange is the range of the data
  bool radiusOfData = false;  ///< the radii are a fraction of the mean spacing of points
  bool operator==(const Vis&) const = default;
};

/// What makes a visualization a view: a picture with a camera of its own.
struct ViewSettings {
  std::string name;
  std::optional<Camera> camera;    ///< none: it is rendered with each camera of the state
  std::optional<glm::ivec2> size;  ///< pixels, in place of the camera's dimensions
  bool follow = true;              ///< windows show newer data by themselves
  bool asItComes = false;          ///< they show each dataset once it is there, not all together
  bool operator==(const ViewSettings&) const = default;
};

struct Visualization {
  std::string annotation;
  Lighting lighting;
  std::vector<Vis> operators;
  ViewSettings view;  ///< no part of the scene that is shown
  bool operator==(const Visualization&) const = default;
};

enum class DatasetType : uint8_t { Volume, Particles, PathLines, Triangles };
/// The datasets that a filter reads as one of its inputs, by their names.
struct FilterInput {
  std::string input;
  std::vector<std::string> datasets;
  bool operator==(const FilterInput&) const = default;
};

/// A dataset of a state file. It comes from a file, or a filter makes it. A *live* one has neither file nor filter: it is what the
/// data space calls by this name.
struct DatasetSpec {
  std::string name;  ///< default: the file name
  DatasetType type = DatasetType::Volume;
  std::string filename;                ///< absolute, or relative to the state file
  std::string array;                   ///< array of the file; empty: its active scalars, else its first array
  glm::dvec4 color{0.8, 0.8, 0.8, 1};  ///< colour of geometry whose file has no values to map
  std::string radiusArray{};           ///< array of the file that gives radii; empty: the values give them
  std::vector<std::string> fields{};  ///< arrays of the file's points that operators may show besides `array`
  std::string filter{};               ///< name of the filter that makes it
  std::vector<FilterInput> inputs{};  ///< of the filter
  std::string properties{};           ///< the filter's own keys: the text of a JSON object
  /// False if the entry has no `type` and its reader does not know the filter, which has the type then.
  bool typeIsKnown = true;

  bool isLive() const { return filename.empty() && filter.empty(); }
  bool operator==(const DatasetSpec&) const = default;
};

/// The parameters of a rendering besides scene and camera.
struct RenderSettings {
  double tolerance = 1.0 / 512;  ///< every channel of every pixel has an error below this
  double step = 0;               ///< if > 0: a fixed step in cells instead of the tolerance, for comparison
  int raysPerPixel = 1;
  glm::dvec4 background{0, 0, 0, 1};
  std::optional<glm::dvec4> backgroundTop = {};  ///< top of a gradient that starts with `background`
  bool operator==(const RenderSettings&) const = default;
};

/// Annotations drawn over finished pictures. By default there are none.
struct Annotations {
  bool legend = false;   ///< colour bars with titles and numbers
  bool axes = false;     ///< directions of the world's axes, in the lower left corner
  bool outline = false;  ///< the box of the shown data, with its extents
  std::string text;      ///< text in the upper left corner; {step} and {time} are replaced
  bool operator==(const Annotations&) const = default;
};

/// Something that is made of data beside pictures of windows.
struct OutputSpec {
  enum class Type { DataFile, Pictures, Publish };
  std::string name;  ///< each once; default: `to`
  Type type = Type::DataFile;
  std::string of;  ///< DataFile and Publish: a dataset; Pictures: a view of a graph document
  std::string to;  ///< DataFile and Pictures: the file; Publish: what the dataset is called
  bool operator==(const OutputSpec&) const = default;
};

/// Returns the name of a type as state files have it.
const char* nameOf(OutputSpec::Type type);

/// Returns `to` with {step} replaced by a number of at least six digits.
std::string fileOfStep(const std::string& to, int64_t step);

/// A whole state file.
struct State {
  std::vector<DatasetSpec> datasets;
  RenderSettings settings;
  std::vector<Visualization> visualizations;
  std::vector<Camera> cameras;
  Annotations annotations;
  std::vector<OutputSpec> outputs;
  bool operator==(const State&) const = default;
};

}  // namespace gxy
