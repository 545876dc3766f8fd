// SPDX-License-Identifier: Apache-2.0
// Room on one rank for lines or triangles of one step.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "multiserver/insitu/sent_arrays.h"

namespace gxy {

/// Takes memory when a rank of the simulation says how many points, cells and corners it has. This rank owns the primitives of what is sent
/// to it, wherever they lie.
class CellsRoom final : public MeshRoom {
 public:
  /// The mesh must outlive it. Its shape is known.
  CellsRoom(const insitu::Mesh& mesh, TakeStepMemory take);

  void store(const insitu::Piece& piece, size_t array, const insitu::PieceHeader& header,
             std::span<const std::byte> samples) override {
    sent_.store(piece, array, header, samples);
  }
  /// Cells become primitives as those of files do (core/data/cells.h), numbered by rank of the simulation, in the order of cells. Primitives
  /// that cannot be drawn are left out and counted. Throws Error also for cells that are wrong, naming the rank of the simulation and the cell
  /// (insitu/plan/cells.h).
  std::vector<std::shared_ptr<Dataset>> complete(Collectives& ranks) override;

 private:
  /// The primitives of all cells, and the number of the cell that each belongs to: cells are numbered as they are stored.
  struct Made {
    GeometryBlock block;
    std::vector<int64_t> cells;
  };
  std::vector<uint64_t> checkedPrimitives() const;
  int64_t bytesToMake(uint64_t primitives) const;
  Made make(const std::map<int, uint64_t>& firstIds) const;
  bool addNormals(GeometryBlock& block) const;
  void giveLook(Made& made, size_t field) const;
  OwnedGeometry geometryOf(Made made, const insitu::Publishes& dataset, Collectives& ranks) const;

  SentArrays sent_;
  const GeometryKind kind_;
};

}  // namespace gxy
