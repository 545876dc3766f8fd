// SPDX-License-Identifier: Apache-2.0
// The cells of a mesh go into every partition that they touch.
//
//   1. Every rank reads a part of the cells, each cell on one rank only.
//   2. Every rank calls packForOwners(), which makes one message for each rank. The ranks exchange them all-to-all.
//   3. Every rank calls unpackMesh(), which makes the blocks of its partitions.
#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <span>
#include <vector>

#include "core/comm/advance.h"
#include "core/comm/transport.h"
#include "core/data/mesh.h"
#include "core/data/partitioning.h"

namespace gxy {

/// Cells with their points, in any order.
struct MeshPiece {
  std::vector<glm::dvec3> points;
  std::vector<float> values;  ///< stored values, the components of a point together
  std::vector<uint64_t>
      numbers;  ///< of points, in the order of the files; each point of the mesh has another one
  int components = 1;
  MeshCells cells;
};

/// What making blocks has counted. Each cell and point is counted in one partition, so that sums over all ranks are those of the whole
/// mesh.
struct MeshBlockCounts {
  std::array<uint64_t, kCellTypes> cells{};
  uint64_t points = 0, repeatedCells = 0, degenerateCells = 0, mergedPoints = 0, differingPoints = 0,
           crowdedFaces = 0;
};

/// Makes a block of cells that all touch one partition. Points at exactly the same place become one, with the values of the one with
/// the lowest number in the files. Points are numbered along Morton's curve through the domain of the partitioning, and then by x, y
/// and z; cells by their points, the lowest first. So the order depends on nothing but the places of points. Cells with the same points
/// as another one and cells with a point twice are left out. Throws Error if there are too many points or cells.
MeshBlock meshBlock(
    MeshPiece piece, const Partitioning& partitioning, int partition, MeshBlockCounts& counts,
    const Advance& advance = [](double) {});

/// Returns one message for each rank, including this one, with the cells of `read` that touch the rank's partitions, or come as near
/// as borderSlack(). Coordinates must be finite.
std::vector<Bytes> packForOwners(
    const MeshPiece& read, const Partitioning& partitioning, int ranks,
    const Advance& advance = [](double) {});

/// Returns the blocks of all partitions of `rank` to which cells belong, from the messages of all ranks in any order. Throws Error for
/// a malformed message.
std::map<int, MeshBlock> unpackMesh(
    const Partitioning& partitioning, int rank, std::span<const Bytes> received, MeshBlockCounts& counts,
    const Advance& advance = [](double) {});

}  // namespace gxy
