// SPDX-License-Identifier: Apache-2.0
// Room on one rank for the fields of a grid in one step.
#pragma once
#include <memory>
#include <vector>

#include "core/data/ghosts.h"
#include "core/data/partitioning.h"
#include "core/data/volume.h"
#include "insitu/plan/encodings.h"
#include "multiserver/insitu/mesh_room.h"

namespace gxy {

/// One volume for each field, with the blocks of the partitions of one rank and room for their ghosts.
class GridRoom final : public MeshRoom {
 public:
  /// Takes the memory at once. The mesh is the stream's mesh `number`. Partitioning and ghosts must outlive it.
  GridRoom(const insitu::Mesh& mesh, size_t number, const insitu::Encodings& encodings,
           const Partitioning& partitioning, const GhostPlan& ghosts, int rank, const TakeStepMemory& take);

  void store(const insitu::Piece& piece, size_t array, const insitu::PieceHeader& header,
             std::span<const std::byte> samples) override;
  std::vector<std::shared_ptr<Dataset>> complete(Collectives& ranks) override;

 private:
  const Partitioning& partitioning_;
  const GhostPlan& ghosts_;
  std::vector<std::shared_ptr<Volume>> volumes_;  ///< by field; their samples are in bricks
  std::vector<FieldStatistics> statistics_;       ///< by field, of what has come; where they are needed
  uint64_t count_ = 0;                            ///< the publish that it is of
  std::vector<LedgerEntry> memory_;
};

}  // namespace gxy
