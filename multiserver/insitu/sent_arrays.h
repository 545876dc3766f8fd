// SPDX-License-Identifier: Apache-2.0
// What ranks of a simulation send of a mesh whose size is another one in each step.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "core/data/owned_geometry.h"
#include "core/space/large_vector.h"
#include "insitu/plan/cells.h"
#include "multiserver/insitu/mesh_room.h"

namespace gxy {

template <class T>
T valueAt(const std::byte* values, size_t i) {
  T value;
  std::memcpy(&value, values + i * sizeof value, sizeof value);
  return value;
}

/// The arrays of a step that have come to one rank, by rank of the simulation. One thread at a time uses it.
class SentArrays {
 public:
  /// What one rank of the simulation has sent.
  struct Source {
    std::vector<uint64_t> counts;  ///< by array: its entries
    std::vector<LargeVector<std::byte>> arrays;
    std::vector<LedgerEntry> memory;

    const std::byte* data(size_t array) const { return arrays[array].data(); }
    uint64_t points() const { return counts.empty() ? 0 : counts[0]; }
  };

  /// `morePerPoint`: bytes that are taken for each point beyond what is sent. The mesh must outlive it.
  SentArrays(const insitu::Mesh& mesh, TakeStepMemory take, uint64_t morePerPoint);

  const insitu::Mesh& mesh() const { return mesh_; }
  const std::vector<insitu::Array>& arrays() const { return arrays_; }
  /// The array of a field of the mesh, or the first with another content. There is one.
  size_t arrayOf(size_t field) const;
  size_t arrayOf(insitu::Array::What what) const;

  /// As MeshRoom::store().
  void store(const insitu::Piece& piece, size_t array, const insitu::PieceHeader& header,
             std::span<const std::byte> samples);
  /// By rank of the simulation, up to the last one that has sent something.
  const std::vector<Source>& sources() const { return sources_; }
  glm::dvec3 position(const Source& source, size_t point) const;
  LedgerEntry take(int64_t bytes) const { return take_(purpose_, bytes); }
  /// Gives the memory back.
  void clear() { sources_.clear(); }

 private:
  const insitu::Mesh& mesh_;
  const std::vector<insitu::Array> arrays_;
  const TakeStepMemory take_;
  const char* const purpose_;  ///< of the memory, for the ledger
  const uint64_t morePerPoint_;
  std::vector<Source> sources_;
};

/// What one rank of the simulation has sent of a mesh of cells. Nothing is known of its content.
insitu::Cells cellsOf(const SentArrays& sent, const SentArrays::Source& source);
/// Throws Error for cells that are wrong, naming the mesh, the rank of the simulation and the cell (insitu/plan/cells.h).
void checkCells(const SentArrays& sent);

/// Collective. Numbers what each rank of the simulation has, by ascending rank. `counts` are those of this rank of the server, by rank of the
/// simulation, where each rank of the simulation has sent to one rank only. Returns the first number of each rank that has something.
std::map<int, uint64_t> firstNumbers(Collectives& ranks, std::span<const uint64_t> counts);

/// What a field looks like at a point, as in files: its value, the magnitude of several components, or a colour (core/io/values_choice.h).
class LookOf {
 public:
  explicit LookOf(const insitu::Field& field);
  bool colored() const { return full_ > 0; }
  /// Appends entry i of the field's array to the values or colours of a block.
  void append(const std::byte* values, size_t i, GeometryBlock& to) const;

 private:
  ScalarType type_;
  int components_;
  double full_ = 0;  ///< the largest value that a component of a colour can have
};

/// Returns the dataset of a field, or of a mesh without fields. Takes its memory as another of `memory`.
std::shared_ptr<Dataset> datasetOf(const insitu::Mesh& mesh, const insitu::Field* field,
                                   OwnedGeometry geometry, const LedgerEntry& memory);

}  // namespace gxy
