// SPDX-License-Identifier: Apache-2.0
// A visualization and its data in the kernels' units: what a backend turns into a DeviceScene.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/comm/advance.h"
#include "core/data/geometry.h"
#include "core/data/partitioning.h"
#include "core/data/volume.h"
#include "core/rays/compiled_map.h"
#include "core/scene/scene.h"

namespace gxy {

/// The frame's render space: the partitioning's domain centred at 0, its longest side 1 (numerics.md section 1).
struct RenderSpace {
  glm::dvec3 centre{0};
  double scale = 1;  ///< render length of one world unit
  glm::dvec3 toRender(glm::dvec3 world) const { return (world - centre) * scale; }
  bool operator==(const RenderSpace&) const = default;
};
RenderSpace renderSpaceOf(const Partitioning& partitioning);

/// What an operator looks at: a volume, or geometry whose blocks are complete (replicated, data/replicate.h).
struct OperatorData {
  std::shared_ptr<const Volume> volume;
  std::shared_ptr<const Geometry> geometry;
  glm::dvec3 color{0.8};  ///< of geometry without values
};

/// A plane n . p = offset in render space, |n| = 1.
struct CompiledPlane {
  float x, y, z, offset;
};

/// Primitives of an operator in one partition. Scenes that show the same geometry with the same radii share them.
struct GeometryPart {
  std::vector<float> points;         ///< x y z radius, render space
  std::vector<float> normals;        ///< x y z per point, or empty
  std::vector<float> values;         ///< per point, or empty
  std::vector<float> colors;         ///< r g b per point, or empty
  std::vector<uint32_t> indices;     ///< 2 (segments) or 3 (triangles) per primitive; particles none
  std::vector<uint32_t> neighbours;  ///< of segments: the points before and after, own ends where none
  uint32_t primitives = 0;           ///< 1 or more

  size_t bytes() const;
};

/// What one operator has in one local partition.
struct OperatorPart {
  const VolumeBlock* block = nullptr;            ///< owned by the operator's volume
  std::vector<int32_t> plan;                     ///< per macrocell of the block, see step_plan.h
  std::vector<int32_t> isoPlan;                  ///< see iso_plan.h; empty where there is no isosurface
  std::shared_ptr<const GeometryPart> geometry;  ///< null if there is none
};

/// An allocation that scenes may hold together: what tells it from others, and its size.
struct SharedBytes {
  const void* what;
  size_t bytes;
};

inline constexpr float kAllHidden = 1e30f;  ///< CompiledOperator::hidden: what counts is all that varies

struct CompiledOperator {
  Vis vis;  ///< volumeRendering: only where the map is not transparent over all data
  OperatorData data;
  CompiledMap map;  ///< over stored values; extinction only where it is volume rendered
  std::array<float, 3> gridOrigin{}, gridInverse{};  ///< render space; cells per unit
  std::vector<float> isovalues;                      ///< stored units
  std::vector<CompiledPlane> slices, clips;
  std::map<int, OperatorPart> parts;  ///< by local partition
  /// What may hide the back of a segment but not its front, so that how it varies matters, per unit of t: the largest extinction
  /// of the volumes rendered with it, together, or kAllHidden where surfaces may cut segments off.
  float hidden = 0;
  int summary = 0;  ///< which of the block's summaries: component, or the magnitude
};

struct CompiledScene {
  Visualization visualization;
  RenderSettings settings;
  std::shared_ptr<const Partitioning> partitioning;
  RenderSpace space;
  glm::dvec3 lo, hi;  ///< the visible domain, render space: all that can be seen lies strictly inside
  std::array<std::vector<float>, 3>
      faces;                           ///< of the partitioning, render space; the outer ones at -+infinity
  std::vector<int32_t> cellPartition;  ///< of the lattice, x fastest
  std::vector<uint8_t> visible;        ///< per partition: may it change a ray? the same on all ranks
  std::vector<CompiledOperator> operators;
  bool opaqueSurfaces = true;  ///< no translucent surface, so shadow and AO rays may stop at any hit
  int volumesRendered = 0;
  float tMin = 0;  ///< transmittance below which a ray ends
  /// Of local macrocells which an isovalue passes through, the cells that hold none, or that the block lacks:
  /// rays pass them by.
  uint64_t isoCellsSkipped = 0;
  double largestRadiance = 1;

  /// Bytes that it holds alone, besides the data.
  size_t bytes() const;
  /// What it may hold together with others.
  std::vector<SharedBytes> sharedBytes() const;
};

/// Compiles for the partitions that are local (the data's blocks say which). `visible` holds the local partitions'
/// answers only; merge over ranks (bitwise or), then set it. Where one of `others` shows the same isosurfaces of
/// the same volume, or the same geometry with the same radii, its plan of them and its primitives are taken: making them
/// looks at all samples and points, and an edit of a map or of a light need not wait for that. Throws Error for an operator
/// without fitting data.
std::shared_ptr<CompiledScene> compileScene(
    const Visualization& visualization, std::vector<OperatorData> data,
    std::shared_ptr<const Partitioning> partitioning, const RenderSettings& settings,
    std::span<const std::shared_ptr<const CompiledScene>> others = {},
    const Advance& advance = [](double) {});

/// What the radii of a Vis depend on, besides values; the same for all Triangles, which have none.
std::array<double, 4> radiiOf(const Vis& vis);
/// The radius (world units) that a Particles or PathLines Vis gives a value; radius0 for NaN; never negative.
double radiusOf(const Vis& vis, double value);
/// The largest radius over a range of values.
double largestRadius(const Vis& vis, const Range& range);

}  // namespace gxy
