// SPDX-License-Identifier: Apache-2.0
// Brings all of an unstructured volume to one rank: for a file, or for a client.
#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "core/comm/collectives.h"
#include "core/data/mesh.h"
#include "core/data/partitioning.h"
#include "core/data/scalar.h"

namespace gxy {

/// Cells as VTK's files have them. Tetrahedra, pyramids, wedges and hexahedra come one after the other, each cell once.
struct GatheredMesh {
  std::vector<glm::dvec3> points;  ///< world; those that cells have
  std::vector<uint8_t> types;      ///< VTK's, by cell
  std::vector<uint64_t> offsets;   ///< by cell and the end of all: where its points begin in `connectivity`
  std::vector<uint32_t> connectivity;
  std::vector<std::byte>
      values;  ///< of points, or of cells (Mesh::ofCells), of gatheredType(), the components together
};

/// The type of values that are gathered: Float32, or Float64 where values are shift + scale * stored.
ScalarType gatheredType(const Mesh& mesh);

/// An upper bound of the bytes that gatherMesh() and its result take on a rank. `root`: on rank 0.
int64_t gatheringBytes(const Mesh& mesh, bool root);

/// Collective. Returns the whole mesh on rank 0, and nothing on other ranks. Its order depends on nothing but the places of points. Cells and
/// points that the mesh has left out are not there, and no tetrahedron is inverted. Throws Error on all ranks if check() throws, or if the mesh
/// has more points or cells than one rank may have.
GatheredMesh gatherMesh(const Mesh& mesh, const Partitioning& partitioning, Collectives& ranks);

}  // namespace gxy
