// SPDX-License-Identifier: Apache-2.0
// LineFields: fields through which lines go, on all ranks, and where in them heads of lines begin.
#pragma once
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "core/data/partitioning.h"
#include "core/rays/heads.h"
#include "core/rays/path_points.h"
#include "core/rays/trace_options.h"

namespace gxy {

/// Heads for seeds, and the ends of those that cannot have one.
struct SeedHeads {
  std::vector<HeadList> heads;  ///< one list for each partition, ascending; in order of the seeds
  std::vector<LineEnd> ends;    ///< `Outside`, one for each direction asked for
};

/// Vectors, and other fields whose components are recorded on the way, of one partitioning. Immutable and thread safe.
class LineFields {
 public:
  virtual ~LineFields() = default;

  virtual const Partitioning& partitioning() const = 0;
  /// The number of components that are recorded at stored points.
  virtual size_t recordedComponents() const = 0;

  /// The kind of heads that go through them.
  virtual HeadKind headKind() const = 0;
  /// Makes heads of lines at world positions, which may be in partitions of any rank; the lines' numbers are `ids` (at
  /// most kLastLine). With TraceDirection::Both each seed has two heads, of which the forward one stores the seed.
  /// Throws Error unless there are as many ids as positions and they are in range.
  virtual SeedHeads seeds(std::span<const glm::dvec3> positions, std::span<const uint64_t> ids,
                          TraceDirection direction) const = 0;
  /// Checks heads of this kind that came in a message for a partition of this rank. Returns what is wrong with them (a
  /// static text), or null if all are good.
  virtual const char* wrongHeads(const HeadList& heads) const = 0;
};

/// What seeds() does for all fields. `partitionOf` returns the partition of seed i, or -1 for one outside; it is called
/// once for each seed, in order. `start` makes head k of seed i.
SeedHeads makeSeedHeads(std::span<const glm::dvec3> positions, std::span<const uint64_t> ids,
                        TraceDirection direction, HeadKind kind,
                        const std::function<int(size_t i)>& partitionOf,
                        const std::function<void(HeadList& heads, int k, size_t i, bool backward)>& start);

/// The end of a line whose seed is outside.
LineEnd outsideEnd(uint64_t line, bool backward, glm::dvec3 position);

}  // namespace gxy
