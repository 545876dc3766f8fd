// SPDX-License-Identifier: Apache-2.0
// The cells of a mesh go into every partition that they touch.
//
//   1. Every rank reads a part of the cells, each cell on one rank only.
//   2. Every rank calls packForOwners(), which makes one message for each rank. The ranks exchange them all-to-all.
//   3. Every rank calls unpackMesh(), which makes the blocks of its partitions.
//   4. If there are points that the files give several values, or the data are those of cells, every rank calls packSettledValues(), the
//      ranks exchange these messages all-to-all, and every rank calls takeSettledValues().
//
// distribute() does all but the first.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <map>
#include <span>
#include <vector>

#include "core/comm/advance.h"
#include "core/comm/collectives.h"
#include "core/comm/transport.h"
#include "core/data/mesh.h"
#include "core/data/partitioning.h"

namespace gxy {

/// Cells with their points, in any order.
struct MeshPiece {
  std::vector<glm::dvec3> points;
  std::vector<float> values;  ///< stored values, the components of a point together
  /// Of points, in the order of the files. Each point of the mesh has another one, on whichever ranks it is.
  std::vector<uint64_t> numbers;
  int components = 1;
  MeshCells cells;
  /// Whether the data are those of cells, on all ranks alike. Then points have no values.
  bool ofCells = false;
  std::array<std::vector<float>, kCellTypes>
      cellValues;  ///< by type: stored values, the components of a cell together
  /// By type, for each cell: 1 if it is a duplicate that another piece has. It serves the averages at points only.
  std::array<std::vector<uint8_t>, kCellTypes> duplicates;
};

/// Its memory in bytes.
int64_t bytesOf(const MeshPiece& piece);

/// Throws Error unless a piece has a value for each point or cell, a number for each point, whole cells of existing points, and finite
/// coordinates.
void validate(const MeshPiece& piece);

struct BlockSources;  // core/data/mesh_values.h
struct ValueRoutes;

/// What making blocks has counted. Each cell and point is counted in one partition, the one that is nearest to it, so that sums over all
/// ranks are those of the whole mesh.
struct MeshBlockCounts {
  std::array<uint64_t, kCellTypes> cells{};
  uint64_t points = 0, repeatedCells = 0, degenerateCells = 0, mergedPoints = 0, differingPoints = 0,
           crowdedFaces = 0, foldedFaces = 0, invertedCells = 0, hangingPoints = 0, splitFaces = 0,
           noDataPoints = 0, noDataCells = 0, differingCells = 0;
  /// By partition: those of its points that are counted there and have several values in the files; if the data are those of cells, all
  /// that are counted there. Only their partition is sure to know the right value, as it has all cells around them.
  std::map<int, std::vector<uint32_t>> differing;
};

/// Makes a block of cells that all touch one partition. Points at exactly the same place become one, with the values of the one with
/// the lowest number in the files. Points are numbered along Morton's curve through the domain of the partitioning, and then by x, y
/// and z; cells by their points, the lowest first. So the order depends on nothing but the places of points. Hexahedra with repeated points
/// become wedges, pyramids or tetrahedra if they are such (collapsed()). Cells with the same points as another one and other cells with
/// a point twice are left out, and points that no cell has. If the data are those of cells, of several cells with the same points the
/// lowest value is kept, and points get averages of the cells around them that are in the piece. Throws Error for a piece that is not valid,
/// and if there are too many points or cells. Takes time and memory that grow as the mesh does. `sources`, if not null, becomes where the
/// points and cells of the block come from.
MeshBlock meshBlock(
    MeshPiece piece, const Partitioning& partitioning, int partition, MeshBlockCounts& counts,
    const Advance& advance = [](double) {}, BlockSources* sources = nullptr);

/// Returns one message for each rank, including this one, with the cells of `read` that touch the rank's partitions, or come as near
/// as borderSlack(). Throws Error for a piece that is not valid, or if a partition's owner is not below `ranks`. `routes`, if not null,
/// becomes which points and cells go where.
std::vector<Bytes> packForOwners(
    const MeshPiece& read, const Partitioning& partitioning, int ranks,
    const Advance& advance = [](double) {}, ValueRoutes* routes = nullptr);

/// Returns the blocks of all partitions of `rank` to which cells belong, from the messages of all ranks in any order. Throws Error for
/// a malformed message. `routes`, if not null, becomes where points and cells of blocks come from; the messages are those of all ranks in
/// ascending order then.
std::map<int, MeshBlock> unpackMesh(
    const Partitioning& partitioning, int rank, std::span<const Bytes> received, MeshBlockCounts& counts,
    const Advance& advance = [](double) {}, ValueRoutes* routes = nullptr);

/// A partition may have a point of a cell that only reaches into it, and not all cells with this point. If the files give the point
/// several values, or its value is an average of cells, it may then have another one than elsewhere. Returns one message for each rank with the points of
/// counts.differing, as they are in `blocks`, that cells have which touch partitions of the rank.
std::vector<Bytes> packSettledValues(const std::map<int, MeshBlock>& blocks, const MeshBlockCounts& counts,
                                     const Partitioning& partitioning, int ranks);
/// Takes the values in such messages of all ranks over into the blocks. Throws Error for a malformed message.
void takeSettledValues(std::map<int, MeshBlock>& blocks, const Partitioning& partitioning,
                       std::span<const Bytes> received);

/// Collective. Returns the blocks of all partitions of this rank to which cells belong, of the cells that all ranks have read. `counts`
/// is of the whole mesh on every rank, but for `differing`. Tells ranks.done() how far it is. `toTake`, if not empty, is called with the
/// bytes of messages, and then with those of blocks in the making, before they are taken; it may refuse them by throwing Error. If any
/// rank fails, all throw the same Error. `routes`, if not null, becomes what distributeValues() needs.
std::map<int, MeshBlock> distribute(MeshPiece read, const Partitioning& partitioning, MeshBlockCounts& counts,
                                    Collectives& ranks, const std::function<void(int64_t)>& toTake = {},
                                    ValueRoutes* routes = nullptr);

/// Collective. Replaces counts of this rank by those of the whole mesh, and brings the values of points that have several in the files to
/// all blocks, and all averages of cells if the data are those of cells. It is what distribute() ends with.
void settle(std::map<int, MeshBlock>& blocks, const Partitioning& partitioning, MeshBlockCounts& counts,
            std::span<uint64_t* const> toSum, Collectives& ranks, bool ofCells = false);

}  // namespace gxy
