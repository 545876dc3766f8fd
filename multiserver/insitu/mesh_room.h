// SPDX-License-Identifier: Apache-2.0
// Room on one rank for what comes of a mesh in one step, and the datasets that it becomes.
#pragma once
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/comm/collectives.h"
#include "core/data/dataset.h"
#include "insitu/plan/records.h"

namespace gxy {

/// Takes memory of the stream's tenant for a purpose of the ledger. Throws Error if there is too little.
using TakeStepMemory = std::function<LedgerEntry(const char* purpose, int64_t bytes)>;

/// One thread at a time uses it.
class MeshRoom {
 public:
  virtual ~MeshRoom() = default;
  /// Puts samples of a piece in their places: those of array `array` (arraysOf) from header.offset on. They are whole points. The
  /// pieces of a rank come one after the other, and a piece may begin anew. Throws Error if there is no memory for it.
  virtual void store(const insitu::Piece& piece, size_t array, const insitu::PieceHeader& header,
                     std::span<const std::byte> samples) = 0;
  /// Collective, called once. Returns the datasets in the order of datasetsOf(), with their data, bytes, memory, and the names of
  /// arrays. If any rank fails, all throw the same Error.
  virtual std::vector<std::shared_ptr<Dataset>> complete(Collectives& ranks) = 0;
};

}  // namespace gxy
