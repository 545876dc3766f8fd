// SPDX-License-Identifier: Apache-2.0
// Test data in memory, cut for any partitioning and number of ranks as an import would do.
#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "core/data/geometry.h"
#include "core/data/partitioning.h"
#include "core/data/point_gradients.h"
#include "core/data/replicate.h"
#include "core/data/volume.h"
#include "core/scene/scene.h"
#include "tests/support/meshes.h"

namespace gxy::test {

/// All samples of a volume in the stored type, x fastest, components interleaved. A value is shift + scale *
/// stored.
struct WholeVolume {
  Grid grid;
  ScalarType stored = ScalarType::Float32;
  int components = 1;
  Samples samples;
  double shift = 0, scale = 1;
};

/// Returns a float volume with the value f(world position) at each grid point.
WholeVolume sampled(const Grid& grid, const std::function<double(glm::dvec3)>& f);
/// Returns a volume of 8 bits, in which f in [0, 1] becomes 0 to 255.
WholeVolume sampledAsBytes(const Grid& grid, const std::function<double(glm::dvec3)>& f);

/// Returns each rank's volume after an import: blocks with ghosts, and summaries merged over all ranks.
std::vector<std::shared_ptr<const Volume>> cut(const WholeVolume& whole, const Partitioning& partitioning,
                                               int ranks);

/// All cells of an unstructured volume. A value is shift + scale * stored.
struct WholeMesh {
  MeshPiece cells;
  double shift = 0, scale = 1;
};

/// Returns each rank's mesh after an import, where cells were read by the ranks in turn.
std::vector<std::shared_ptr<const Mesh>> cut(const WholeMesh& whole, const Partitioning& partitioning,
                                             int ranks);

/// Returns each rank's gradients of what `vis` shows of such a mesh; null if it has no isosurfaces.
std::vector<std::shared_ptr<const PointGradients>> gradientsOf(
    const std::vector<std::shared_ptr<const Mesh>>& meshes, const Vis& vis, const Partitioning& partitioning);

/// All primitives of a geometry, by ascending id.
struct WholeGeometry {
  GeometryKind kind = GeometryKind::Particles;
  GeometryBlock block;
};

/// Returns each rank's geometry after replication, where primitives were read by the ranks in turn.
std::vector<std::shared_ptr<const Geometry>> distributed(const WholeGeometry& whole,
                                                         const Partitioning& partitioning,
                                                         const RadiusOf& radius, int ranks);

}  // namespace gxy::test
