// SPDX-License-Identifier: Apache-2.0
// Room on one rank for the samples of a step, before it is a dataset.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "core/data/partitioning.h"
#include "core/data/volume.h"
#include "insitu/plan/description.h"
#include "insitu/plan/redistribution.h"

namespace gxy {

/// Returns the bytes of this rank's blocks of a field, while they are completed.
int64_t bytesToCome(const insitu::Field& field, const Grid& grid, const Partitioning& partitioning, int rank);

/// One volume for each field of a mesh, with the blocks of the partitions of one rank and room for their ghosts.
class StepRoom {
 public:
  StepRoom(const insitu::Mesh& mesh, const Partitioning& partitioning, int rank);

  /// Puts samples of a piece in their places: those from byte `offset` of the piece's samples of a field on. They are whole points.
  void store(size_t field, const insitu::Piece& piece, uint64_t offset, std::span<const std::byte> samples);

  /// The volumes by field.
  const std::vector<std::shared_ptr<Volume>>& volumes() const { return volumes_; }

 private:
  std::vector<std::shared_ptr<Volume>> volumes_;
};

}  // namespace gxy
