// SPDX-License-Identifier: Apache-2.0
// Builds scenes for Renderers: all ranks together turn a visualization and its data into a scene on their devices.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/comm/collectives.h"
#include "core/data/owned_geometry.h"
#include "core/data/partitioning.h"
#include "core/data/point_gradients.h"
#include "core/rays/backend.h"
#include "core/rays/compiled_scene.h"
#include "core/rays/scene_memory.h"
#include "core/space/ledger.h"
#include "core/space/shared_by.h"

namespace gxy {

/// Geometry that has not been distributed to the partitions that it touches.
struct GeometrySource {
  /// Scenes share the distributed geometry if this name, the radii and what is shown are the same. So different geometry needs different names.
  std::string name;
  std::shared_ptr<const OwnedGeometry> owned;
};

/// Geometry whose primitives have been compiled in every partition that they touch. Blocks were needed for that only, and the
/// geometry has none left.
struct DistributedGeometry {
  std::shared_ptr<const Geometry> geometry;
  std::shared_ptr<const CompiledGeometry> primitives;
};
using DistributedGeometryPtr = std::shared_ptr<const DistributedGeometry>;

/// Collective. Returns a geometry in the partitions that it touches with the radii and the values that `vis` gives it.
std::shared_ptr<Geometry> distributed(std::shared_ptr<const OwnedGeometry> owned, const Vis& vis,
                                      const Partitioning& partitioning, Collectives& ranks,
                                      const EnterMemory& enter);

/// Keeps distributed geometry for as long as somebody holds it, so that scenes share it. There is one on each rank. Thread safe.
class SharedGeometry {
 public:
  /// Collective. Returns the geometry with the radii and the values that `vis` gives it. If any rank does not have it, the geometry
  /// is distributed and compiled, and `enter` is called for "geometry", which is in memory until then. If either fails on one rank,
  /// all ranks throw the same Error. `compiled` gets the entries of primitives that have been compiled; the caller keeps them until
  /// a scene with these has entries of its own.
  DistributedGeometryPtr get(const GeometrySource& source, const Vis& vis, const Partitioning& partitioning,
                             Collectives& ranks, const EnterMemory& enter,
                             std::vector<LedgerEntry>& compiled);

 private:
  /// Name, radiiOf(), Vis::array, Vis::component or -1, and renderSpaceOf() as numbers.
  using Distribution =
      std::tuple<std::string, std::array<double, 4>, std::string, int, std::array<double, 4>>;
  SharedBy<Distribution, DistributedGeometry> known_;
};

/// Gradients of a mesh, with their entry in the ledger.
struct MeshGradients {
  std::shared_ptr<const Mesh> mesh;  ///< of which they are
  PointGradients gradients;
  LedgerEntry memory;
};
using MeshGradientsPtr = std::shared_ptr<const MeshGradients>;

/// Keeps the gradients of meshes for as long as somebody holds them, so that scenes share them. There is one on each rank. Thread safe.
class SharedGradients {
 public:
  /// Collective. Returns the gradients of what `vis` shows of the mesh. If any rank does not have them, they are made and `enter` is called for
  /// "geometry". If either fails on one rank, all ranks throw the same Error.
  MeshGradientsPtr get(std::shared_ptr<const Mesh> mesh, const Vis& vis, const Partitioning& partitioning,
                       Collectives& ranks, const EnterMemory& enter);

 private:
  /// The mesh, and Vis::component or -1.
  SharedBy<std::pair<const Mesh*, int>, MeshGradients> known_;
};

/// The data of one operator.
struct OperatorSource {
  OperatorData data;
  /// Geometry to be distributed, which becomes `data.geometry`. None: `data` is complete.
  std::optional<GeometrySource> geometry;
};

/// A visualization with its data, from which a scene is built.
struct SceneSource {
  Visualization visualization;  ///< resolved(): ranges and radii are numbers (core/scene/resolve.h)
  RenderSettings settings;
  std::shared_ptr<const Partitioning> partitioning;
  std::vector<OperatorSource> data;  ///< by operator
  bool sampled = false;              ///< CompiledScene::sampled
};

/// A scene on one rank, with its entries in the ledger. The holder keeps it for as long as the ledger is to show it.
struct BuiltScene {
  std::shared_ptr<const CompiledScene> compiled;
  std::shared_ptr<const DeviceScene> device;
  std::vector<DistributedGeometryPtr> geometry;  ///< distributed for this scene, or shared with others
  std::vector<MeshGradientsPtr> gradients;       ///< likewise
  /// Entries for "scene". This member is the last, so that the entries are destroyed before the memory that they count.
  SceneMemory::Entries memory;
};

/// Builds scenes. There is one builder on each rank. Its scenes share distributed geometry, the parts that compileScene() takes
/// from other scenes, and the ledger's entries for them. Thread safe: several scenes may be built at the same time.
class SceneBuilder {
 public:
  /// Is called on all ranks when item `item` of `of` begins. There is one item for each geometry that is distributed, one for
  /// compiling and one for the device. If it throws, it must throw on all ranks, and ends the building.
  using OnItem = std::function<void(int64_t item, int64_t of, const std::string& text)>;

  /// The backend must outlive the builder. `rank` is this rank.
  SceneBuilder(const Backend& backend, int rank) : backend_(backend), rank_(rank) {}

  /// Collective. Distributes and compiles geometry, finds the gradients for isosurfaces of meshes, compiles the scene, merges over all ranks which partitions are visible, and makes the
  /// scene on the backend's device. Calls `enter` for "geometry" after each distribution, and for "scene" once the device has
  /// the scene. Takes long for much data. If a rank fails or has no room, all ranks throw the same Error and nothing remains.
  BuiltScene build(
      SceneSource source, Collectives& ranks, const EnterMemory& enter,
      const OnItem& onItem = [](int64_t, int64_t, const std::string&) {});

 private:
  std::vector<std::shared_ptr<const CompiledScene>> others();

  const Backend& backend_;
  const int rank_;
  SharedGeometry geometry_;
  SharedGradients gradients_;
  SceneMemory memory_;
  std::mutex mutex_;
  std::vector<std::weak_ptr<const CompiledScene>> scenes_;  ///< in the order in which they were built
};

}  // namespace gxy
