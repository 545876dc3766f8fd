// SPDX-License-Identifier: Apache-2.0
// Values of a distributed volume at points of any rank: points go to the ranks that own them, and values come back.
#pragma once
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "core/analysis/field_reader.h"
#include "core/analysis/filter.h"
#include "core/analysis/mesh_reader.h"
#include "core/comm/collectives.h"

namespace gxy {

struct FieldValues {
  std::vector<float> values;  ///< for each point of this rank, those of all components that were asked for
  uint64_t outside = 0;  ///< points outside the data's box, or in no cell, on all ranks; their values are NaN
  uint64_t noData = 0;   ///< points in cells without data, on all ranks; their values are NaN
};

/// Computes what is wanted at a place: writes as many numbers as the caller has said.
using ReadPlace =
    std::function<void(const FieldReader& reader, int partition, const GridPlace& place, float* values)>;

/// The same in a cell of an unstructured volume.
using ReadMeshPlace = std::function<void(const Mesh& mesh, const MeshPlace& place, float* values)>;

/// Collective. Returns, for the points that each rank gives, `count` >= 1 numbers each that `read` computes on the rank that owns the cell;
/// any thread may call it. It works in rounds, so that it needs a bounded amount of memory besides the result. If any rank fails, all
/// throw the same Error.
FieldValues readAt(const Volume& volume, const Partitioning& partitioning, size_t count,
                   const ReadPlace& read, std::span<const glm::dvec3> points, Collectives& ranks);

/// Reads values of a volume, on a grid or unstructured, at points of any rank.
class ValueReader {
 public:
  /// Collective. Makes what finds the cells of points, and takes memory for it from the run. If any rank fails, all throw the same Error.
  ValueReader(FilterRun& run, const FilterSource& field);
  ~ValueReader();

  /// Collective. Returns the values of `components` (as of FieldReader::value) at the points that each rank gives, as readAt() does.
  FieldValues at(std::span<const int> components, std::span<const glm::dvec3> points,
                 Collectives& ranks) const;
  /// Collective. The same for `count` numbers that `read` computes in the cells of an unstructured volume.
  FieldValues inCellsAt(size_t count, const ReadMeshPlace& read, std::span<const glm::dvec3> points,
                        Collectives& ranks) const;

 private:
  std::shared_ptr<const Dataset> field_;
  LedgerEntry memory_;
  std::unique_ptr<const MeshReader> mesh_;  ///< null on a grid
};

}  // namespace gxy
