// SPDX-License-Identifier: Apache-2.0
// Room on one rank for the cells of an unstructured volume in one step.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "core/data/complete_mesh.h"
#include "core/data/partitioning.h"
#include "multiserver/insitu/sent_arrays.h"

namespace gxy {

/// Takes memory when a rank of the simulation says how many points, cells and corners it has.
class VolumeRoom final : public MeshRoom {
 public:
  /// Mesh and partitioning must outlive it.
  VolumeRoom(const insitu::Mesh& mesh, const Partitioning& partitioning, TakeStepMemory take);

  void store(const insitu::Piece& piece, size_t array, const insitu::PieceHeader& header,
             std::span<const std::byte> samples) override {
    sent_.store(piece, array, header, samples);
  }
  /// Cells go into the partitions that they touch, as those of files do (core/data/complete_mesh.h). Points are numbered by rank of the
  /// simulation. Throws Error also for cells that are wrong, naming the rank of the simulation and the cell, and for cells outside of the
  /// partitioning's domain.
  std::vector<std::shared_ptr<Dataset>> complete(Collectives& ranks) override;

 private:
  /// The points that cells have, and the cells, without values.
  struct Made {
    struct Place {
      uint32_t rank, index;  ///< of the simulation, and among what it has sent
    };
    MeshPiece piece;
    std::vector<Place> places;  ///< of the piece's points
  };
  int64_t bytesToMake() const;
  Made make(const std::map<int, uint64_t>& firsts) const;
  std::vector<double> valuesOf(const insitu::Field& field, size_t array, const Made& made) const;
  void checkInside(const Box& box) const;
  std::shared_ptr<Dataset> datasetOf(size_t field, MeshPiece piece, const Made& made,
                                     Collectives& ranks) const;

  SentArrays sent_;
  const Partitioning& partitioning_;
};

}  // namespace gxy
