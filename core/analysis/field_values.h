// SPDX-License-Identifier: Apache-2.0
// Values of a distributed volume at points of any rank: points go to the ranks that own them, and values come back.
#pragma once
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "core/analysis/field_reader.h"
#include "core/comm/collectives.h"

namespace gxy {

struct FieldValues {
  std::vector<float> values;  ///< for each point of this rank, those of all components that were asked for
  uint64_t outside = 0;       ///< points outside the data's box, on all ranks; their values are NaN
  uint64_t noData = 0;        ///< points in cells without data, on all ranks; their values are NaN
};

/// Computes what is wanted at a place: writes as many numbers as the caller has said.
using ReadPlace =
    std::function<void(const FieldReader& reader, int partition, const GridPlace& place, float* values)>;

/// Collective. Returns, for the points that each rank gives, `count` >= 1 numbers each that `read` computes on the rank that owns the cell;
/// any thread may call it. It works in rounds, so that it needs a bounded amount of memory besides the result. If any rank fails, all
/// throw the same Error.
FieldValues readAt(const Volume& volume, const Partitioning& partitioning, size_t count,
                   const ReadPlace& read, std::span<const glm::dvec3> points, Collectives& ranks);

/// Collective. Returns the values of `components` (as of FieldReader::value) at the points that each rank gives,
/// as readAt() does.
FieldValues valuesAt(const Volume& volume, const Partitioning& partitioning, std::span<const int> components,
                     std::span<const glm::dvec3> points, Collectives& ranks);

}  // namespace gxy
