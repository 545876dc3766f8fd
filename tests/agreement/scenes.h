// SPDX-License-Identifier: Apache-2.0
// Scenes made in memory, as both the backends and the reference renderer take them: whole in one partition.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/data/geometry.h"
#include "core/data/volume.h"
#include "core/rays/compiled_scene.h"
#include "core/reference/reference.h"

namespace gxy::agreement {

/// A visualization, the data of its operators, and a camera that looks at it.
struct TestScene {
  std::string name;
  Visualization visualization;
  std::vector<OperatorData> data;
  RenderSettings settings;
  Camera camera;
  Box domain;  ///< of the partitioning; empty: the box of all data
  std::vector<std::shared_ptr<const CompiledScene>> others;  ///< that compile() may take from

  Vis& add(Vis vis, std::shared_ptr<const Volume> volume);
  Vis& add(Vis vis, std::shared_ptr<const Mesh> mesh);
  Vis& add(Vis vis, std::shared_ptr<const Geometry> geometry);

  std::shared_ptr<const CompiledScene> compile() const;
  reference::ReferenceScene forReference() const;
};

/// Looks from `eye` at the origin, 30 degrees wide.
TestScene sceneFrom(std::string name, glm::dvec3 eye, int width, int height);

/// The same scene with every length multiplied by `factor` and then moved by `shift`: data, planes, radii, lights,
/// reference lengths and the camera.
TestScene moved(const TestScene& scene, double factor, glm::dvec3 shift);

using FieldFunction = std::function<double(glm::dvec3)>;

/// Samples of `type` of field(world position), stored as an import would; values are clamped to narrow types. One component.
std::shared_ptr<Volume> makeVolume(const Grid& grid, const FieldFunction& field,
                                   ScalarType type = ScalarType::Float32);

/// n^3 points that span [-half, half]^3.
Grid cube(int64_t n, double half = 1);

/// Completes block 0: ids, box, range, counts; drops what cannot be drawn, as an import does.
std::shared_ptr<Geometry> makeGeometry(GeometryKind kind, GeometryBlock block);

/// Points joined to one line each, with neighbours.
void addLine(GeometryBlock& block, const std::vector<glm::dvec3>& points, const std::vector<float>& values);

/// Gives each point a colour of its own, from its place, instead of a value.
GeometryBlock coloured(GeometryBlock block);

/// A sphere of radius 1 as 2 n^2 triangles, with normals and values (the height) where asked for.
GeometryBlock sphereMesh(int n, bool normals, bool values);

/// Repeatable numbers in [0, 1).
class Uniform {
 public:
  explicit Uniform(uint64_t seed) : state_(seed) {}
  double operator()() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return double(state_ >> 11) * 0x1p-53;
  }
  double in(double lo, double hi) { return lo + (hi - lo) * (*this)(); }
  glm::dvec3 inCube(double half) {
    const double x = in(-half, half), y = in(-half, half), z = in(-half, half);
    return {x, y, z};
  }

 private:
  uint64_t state_;
};

/// The test signal of Marschner and Lobb (1994), on [-1, 1]^3.
double marschnerLobb(glm::dvec3 p);
/// A sum of seeded waves, of wave lengths from 1/3 to 1; in [-1, 1] or little more.
double waves(glm::dvec3 p);

/// A Vis that draws the volume itself: colour from blue to red over [lo, hi], opacity as given.
Vis rendered(std::vector<OpacityPoint> opacity, double lo = 0, double hi = 1, bool extinction = false);
/// A Vis with isosurfaces (or geometry, by type), coloured over [lo, hi].
Vis surfaces(VisType type, double lo = 0, double hi = 1);

/// 28^3 samples of waves() on [-1, 1]^3.
std::shared_ptr<const Volume> wavy();

/// A floor, spheres, tubes, a mesh with normals, an isosurface and a slice; operators in this order.
TestScene solids(const std::string& name, int size = 72);

/// Ka 0.3, Kd 0.6, Ks 0.3.
Lighting lit(std::vector<Light> sources, bool shadows);

inline const Light kSun{LightType::Directional, {-0.5, -1, -0.3}};
inline const Light kLamp{LightType::Point, {1.5, 2, 1}};
inline const Light kNearLamp{LightType::Point, {0.1, 0.3, 0.4}};
inline const Light kHeadlight{LightType::Camera, {0.7, 0.9, -0.2}};

/// Solids, translucent ones among them, two volumes, shadows, ambient occlusion, two rays per pixel.
TestScene everything(int size);

}  // namespace gxy::agreement
