// SPDX-License-Identifier: Apache-2.0
// CompiledScene: a visualization and its data in the kernels' units. A backend makes a DeviceScene of it.
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
#include "core/data/mesh.h"
#include "core/data/owned_geometry.h"
#include "core/data/partitioning.h"
#include "core/data/point_gradients.h"
#include "core/data/volume.h"
#include "core/rays/compiled_map.h"
#include "core/scene/scene.h"

namespace gxy {

/// The frame's render space: the partitioning's domain centred at 0, its longest side 1
/// (docs/conventions.md).
struct RenderSpace {
  glm::dvec3 centre{0};
  double scale = 1;  ///< render length of one world unit
  glm::dvec3 toRender(glm::dvec3 world) const { return (world - centre) * scale; }
  bool operator==(const RenderSpace&) const = default;
};
RenderSpace renderSpaceOf(const Partitioning& partitioning);

struct GeometryInPartition;
/// The primitives of a geometry in each partition of this rank that has some, compiled with an operator's radii.
using CompiledGeometry = std::map<int, std::shared_ptr<const GeometryInPartition>>;

/// The dataset of an operator: a volume, or geometry that has come to the partitions that it touches (data/distribute.h). One of
/// volume, mesh and geometry is set.
struct OperatorData {
  std::shared_ptr<const Volume> volume;
  std::shared_ptr<const Mesh> mesh{};  ///< an unstructured volume
  /// Of what the operator shows of the mesh. Without it, isosurfaces have the normals of the cells.
  std::shared_ptr<const PointGradients> gradients{};
  std::shared_ptr<const Geometry> geometry{};
  /// The primitives of `geometry`, if they have been compiled already. Then it has no blocks, and `owned` is what it was made of.
  std::shared_ptr<const CompiledGeometry> primitives{};
  std::shared_ptr<const OwnedGeometry> owned{};
  glm::dvec3 color{0.8};  ///< colour of geometry without values
};

/// A plane n . p = offset in render space, |n| = 1.
struct CompiledPlane {
  float x, y, z, offset;
  bool operator==(const CompiledPlane&) const = default;
};

/// The primitives of an operator in one partition, or the cells of an unstructured volume, whose primitives are the faces of their
/// shell (kernels/mesh.h). Scenes that show the same geometry with the same radii share them, and so do those that show the same values
/// of the same mesh.
struct GeometryInPartition {
  std::vector<float> points;   ///< x y z radius, render space; of a mesh: x y z and the stored value
  std::vector<float> normals;  ///< x y z per point, or empty
  std::vector<float> values;   ///< per point, or empty; of a mesh: stored values per cell, or empty
  std::vector<float> colors;   ///< r g b per point, or empty
  std::vector<uint32_t>
      indices;  ///< 2 (segments) or 3 (triangles) per primitive; empty for particles; of a mesh: 4 or 8 per cell
  /// For segments: the points before and after; the segment's own end if there is none. Of a mesh: MeshBlock::neighbours, with the sides
  /// of hexahedra (kernels/hexahedron.h) where not all cells are tetrahedra.
  std::vector<uint32_t> neighbours;
  std::vector<uint32_t> orders;  ///< of hexahedra: one per cell (kernels/hexahedron.h)
  std::vector<uint32_t>
      corners;  ///< of cells that surfaces pass: for each corner the number of its gradient in `normals`, or empty
  std::vector<uint32_t>
      shell;  ///< of a mesh: the sides where rays begin: MeshBlock::shell, likewise, and those of bricks that are not seen
  uint32_t primitives = 0;  ///< 1 or more
  /// Of a mesh: the ranges of stored values in bricks of 2^TETRAHEDRA_IN_BRICK tetrahedra or 2^HEXAHEDRA_IN_BRICK hexahedra.
  std::vector<Range> bricks;
  std::vector<uint32_t>
      unseen;  ///< of a mesh: a bit for each brick that rays leave out; empty if there are none
  /// Of a mesh of which rays leave out bricks: its cells. Then only `shell`, `primitives` and `unseen` are this part's own.
  std::shared_ptr<const GeometryInPartition> cells;

  /// The part that has the cells' arrays.
  const GeometryInPartition& arrays() const { return cells ? *cells : *this; }
  size_t bytes() const;  ///< without those of `cells`
};

/// The data of one operator in one local partition.
struct OperatorInPartition {
  const VolumeBlock* block = nullptr;  ///< owned by the operator's volume
  std::vector<int32_t> plan;           ///< per macrocell of the block, see step_plan.h
  std::vector<int32_t> isoMask;        ///< see iso_mask.h; empty where there is no isosurface
  std::shared_ptr<const GeometryInPartition>
      geometry;  ///< or cells to be volume rendered; null if there is none
  /// Of a mesh: the cells that isosurfaces and slices pass, those of each surface together, slices first; null if there are none. Per
  /// primitive `points` has 4 corners, or 8 where not all cells are tetrahedra, x y z in render space and the level
  /// (kernels/cell_surface.h, hex_surface.h), `values` the stored values there, and `indices` the number of the surface. `normals`, if
  /// there are any, are the gradients at the points of cells with isosurfaces.
  std::shared_ptr<const GeometryInPartition> surfaces;
};

/// An allocation that scenes may hold together: its identity and its size.
struct SharedBytes {
  const void* what;
  size_t bytes;
};

inline constexpr float kAllOccluding =
    1e30f;  ///< CompiledOperator::occludingExtinction where surfaces may cut segments off

struct CompiledOperator {
  Vis vis;  ///< volumeRendering is off if the map is transparent over all data
  OperatorData data;
  CompiledMap map;  ///< over stored values; with extinction only if it is volume rendered
  std::array<float, 3> gridOrigin{},
      gridInverse{};             ///< of a uniform grid, in render space; cells per unit of it
  std::vector<float> isovalues;  ///< stored units
  std::vector<CompiledPlane> slices, clips;
  float every = 0;                           ///< Vis::every in render space
  std::map<int, OperatorInPartition> parts;  ///< key: local partition
  /// Upper bound on the extinction, per unit of t, of everything else that can hide the back of a segment and
  /// not its front: the largest extinctions of the other volumes together, or kAllOccluding where surfaces may
  /// cut segments off. kernels/multi_volume.h halves segments by it.
  float occludingExtinction = 0;
  int summary = 0;  ///< index into the block's summaries: the component, or the last for the magnitude
};

/// Whether an operator shows a mesh whose cells have a constant value each (Vis::cells).
inline bool showsConstantCells(const CompiledOperator& op) {
  return op.data.mesh && op.data.mesh->ofCells && op.vis.cells == CellsShown::Flat;
}

struct CompiledScene {
  Visualization visualization;
  RenderSettings settings;
  std::shared_ptr<const Partitioning> partitioning;
  RenderSpace space;
  glm::dvec3 lo, hi;  ///< the visible domain, render space: all that can be seen lies strictly inside
  /// Faces of the partitioning in render space; the outer ones are at -+infinity.
  std::array<std::vector<float>, 3> faces;
  std::vector<int32_t> cellPartition;  ///< partition of each cell of the lattice, x fastest
  std::vector<uint8_t> visible;        ///< per partition: whether it may change a ray; the same on all ranks
  std::vector<CompiledOperator> operators;
  /// Numbers of the operators, in order: those whose volume on a uniform grid has slices or places at equal distances (Vis::every), those
  /// whose volume on one has isosurfaces, and those that are volume rendered, at most MANY_VOLUMES (kernels/scene_view.h).
  std::vector<int32_t> sliced, isosurfaces, rendered;
  bool opaqueSurfaces = true;  ///< no translucent surface, so shadow and AO rays may stop at any hit
  float tMin = 0;              ///< transmittance below which a ray ends
  /// Cells of local macrocells that an isovalue passes through, if they hold no isovalue or the block lacks
  /// them. Rays skip them.
  uint64_t isoCellsSkipped = 0;
  /// It is for samplings alone: no frame is made of it, so devices need not prepare any.
  bool sampled = false;
  double largestRadiance = 1;  ///< bound on the light of a hit or a segment

  /// Bytes that this scene holds alone, besides the data.
  size_t bytes() const;
  /// Allocations that it may hold together with other scenes.
  std::vector<SharedBytes> sharedBytes() const;
};

/// The longest side of the domain is at most so many times Vis::every: then no ray has more than 65535 places.
inline constexpr double kMostSteps = 1 << 15;

/// Compiles the primitives of a block of geometry, of which there is at least one, with the radii that `vis` gives them.
std::shared_ptr<const GeometryInPartition> compilePrimitives(
    const GeometryBlock& block, GeometryKind kind, const Vis& vis, const RenderSpace& space,
    const Advance& advance = [](double) {});

/// Compiles a scene for the partitions that are local, which the data's blocks or primitives tell. `visible` then holds
/// only the answers of local partitions: merge them over ranks (bitwise or), and set it. If one of `others`
/// shows the same isosurfaces of the same volume, its plan of them is used. Making it looks at all samples, and an edit of a map
/// or of a light need not wait for that. Throws Error for an operator without fitting data and for more than
/// MANY_VOLUMES volumes that are volume rendered, and what `advance` throws.
std::shared_ptr<CompiledScene> compileScene(
    const Visualization& visualization, std::vector<OperatorData> data,
    std::shared_ptr<const Partitioning> partitioning, const RenderSettings& settings,
    std::span<const std::shared_ptr<const CompiledScene>> others = {},
    const Advance& advance = [](double) {});

/// The numbers on which the radii of a Vis depend, besides values; the same for all Triangles, which have no
/// radii.
std::array<double, 4> radiiOf(const Vis& vis);
/// The radius (world units) that a Particles or PathLines Vis gives a value; radius0 for NaN; never negative.
double radiusOf(const Vis& vis, double value);
/// The largest radius over a range of values.
double largestRadius(const Vis& vis, const Range& range);

}  // namespace gxy
