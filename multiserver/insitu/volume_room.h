// SPDX-License-Identifier: Apache-2.0
// Room on one rank for the cells of an unstructured volume in one step.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "core/data/complete_mesh.h"
#include "core/data/partitioning.h"
#include "multiserver/insitu/sent_arrays.h"

namespace gxy {

/// What this rank has made of a step's points and cells. All fields of the step share it, and further steps as long as all ranks are
/// sent the same points and cells.
struct VolumeLayout {
  /// A point that cells have, or a cell: the rank of the simulation, and the place among those that it has sent.
  struct Place {
    uint32_t rank, index;
  };
  std::array<uint64_t, 2> content{};  ///< ContentHash of what was sent
  std::vector<Place> points;          ///< as distributed, in their order
  /// Likewise the cells, by type, if there are fields of them: by rank of the simulation their places among its cells.
  std::array<std::vector<Place>, kCellTypes> cells;
  uint64_t ghostCells = 0;  ///< as in MeshReport, on all ranks
  MeshLayout mesh;
  std::shared_ptr<const LedgerEntry> memory;  ///< of the blocks; datasets have it, too
  LedgerEntry ownMemory;                      ///< of all else
};

/// What is kept of a mesh from one step to the next. Thread safe.
class KeptVolume {
 public:
  /// Null: the next one is made anew.
  std::shared_ptr<const VolumeLayout> layout() const {
    const std::lock_guard lock(mutex_);
    return layout_;
  }
  void keep(std::shared_ptr<const VolumeLayout> layout) {
    const std::lock_guard lock(mutex_);
    layout_.swap(layout);
  }
  /// Counts a step that had the points and cells of the step before.
  void countUse() {
    const std::lock_guard lock(mutex_);
    uses_++;
  }
  uint64_t uses() const {
    const std::lock_guard lock(mutex_);
    return uses_;
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const VolumeLayout> layout_;
  uint64_t uses_ = 0;
};

/// Takes memory when a rank of the simulation says how many points, cells and corners it has.
class VolumeRoom final : public MeshRoom {
 public:
  /// All must outlive it.
  VolumeRoom(const insitu::Mesh& mesh, const Partitioning& partitioning, TakeStepMemory take,
             KeptVolume& kept);

  void store(const insitu::Piece& piece, size_t array, const insitu::PieceHeader& header,
             std::span<const std::byte> samples) override {
    sent_.store(piece, array, header, samples);
  }
  /// Cells go into the partitions that they touch, as those of files do (core/data/complete_mesh.h). Points are numbered by rank of the
  /// simulation. A field of points or cells that isGhosts() marks ghosts as the array vtkGhostType of files does (core/io/mesh_file.h). Throws Error also for cells that are wrong, naming the rank of the simulation and the cell, and for cells outside of the
  /// partitioning's domain.
  std::vector<std::shared_ptr<Dataset>> complete(Collectives& ranks) override;

 private:
  std::array<uint64_t, 2> content() const;
  int64_t bytesToMake() const;
  MeshPiece make(const std::map<int, uint64_t>& firsts, VolumeLayout& layout) const;
  std::vector<double> valuesOf(size_t field, const VolumeLayout& layout) const;
  bool isHidden(const VolumeLayout::Place& point) const;
  bool hasHiddenPoint(const VolumeLayout::Place& cell) const;
  void checkInside(const Box& box) const;
  std::shared_ptr<Dataset> firstDataset(size_t field, VolumeLayout& layout, Collectives& ranks) const;
  std::shared_ptr<Dataset> dataset(size_t field, const VolumeLayout& layout, Collectives& ranks) const;
  std::shared_ptr<Dataset> datasetOf(size_t field, Mesh mesh, const VolumeLayout& layout) const;

  SentArrays sent_;
  const bool hasCellFields_;
  const std::optional<size_t> ghostCells_, ghostPoints_;  ///< arrays that mark them
  const Partitioning& partitioning_;
  KeptVolume& kept_;
};

}  // namespace gxy
