// SPDX-License-Identifier: Apache-2.0
// Cuts a domain into disjoint boxes (partitions), each owned by a rank.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/data/box.h"

namespace gxy {

/// A domain box cut by faces into a lattice of cells. Each cell belongs to one partition, and each partition
/// is a box of cells owned by one rank. The table is the same on every rank. A rank may own any number of
/// partitions, or none. It is immutable after construction; any thread may read it.
class Partitioning {
 public:
  /// faces[a]: ascending world coordinates of all cuts on axis a, including both ends of the domain (>= 2
  /// entries). cells: partition of each lattice cell, x fastest. owners: rank of each partition. Throws Error
  /// unless faces are finite and ascend, every partition is a non-empty box of cells and every owner is >= 0.
  Partitioning(std::array<std::vector<double>, 3> faces, std::vector<int32_t> cells,
               std::vector<int32_t> owners);

  /// One partition per lattice cell, x fastest. Partition p is owned by rank p * ranks / partitions.
  static Partitioning lattice(std::array<std::vector<double>, 3> faces, int ranks);

  /// Any disjoint boxes that fill their common bounding box, such as k-d splits or the boxes of a simulation.
  /// Box p becomes partition p, owned by owners[p]. Coordinates closer than 1e-9 of the domain's side become
  /// one face: the smallest of them, or the largest at the domain's upper end. Throws Error with the boxes if
  /// two overlap or a hole is left, or if their faces make more than 2^28 lattice cells.
  static Partitioning fromBoxes(std::span<const Box> boxes, std::vector<int32_t> owners);

  /// One partition that is the whole box, owned by rank 0.
  static Partitioning single(const Box& box);

  const Box& domain() const { return domain_; }
  int partitions() const { return int(boxes_.size()); }
  const Box& box(int partition) const { return boxes_[partition]; }
  int owner(int partition) const { return owners_[partition]; }
  /// The partitions of a rank, ascending; empty for a rank that owns none.
  std::vector<int> owned(int rank) const;

  std::span<const double> faces(int axis) const { return faces_[axis]; }
  /// The number of lattice cells on each axis.
  std::array<int, 3> cells() const;
  std::span<const int32_t> cellPartition() const { return cells_; }

  /// Returns the partition that contains world point p, or -1 outside the domain. A point on an upper face
  /// belongs to the next partition, except at the domain's end.
  int locate(glm::dvec3 p) const;
  /// Returns the partition nearest to p: that of p clamped into the domain. p must be finite.
  int nearest(glm::dvec3 p) const;

  /// Returns the first and last index of the lattice cells on one axis whose closed extent meets [lo, hi].
  /// Cells at the domain's ends reach outwards without limit, so there is always one.
  std::array<int, 2> cellsTouched(int axis, double lo, double hi) const;

  bool operator==(const Partitioning&) const = default;

 private:
  Box domain_;
  std::array<std::vector<double>, 3> faces_;
  std::vector<int32_t> cells_;
  std::vector<int32_t> owners_;
  std::vector<Box> boxes_;
};

/// Factors `parts` into i*j*k blocks of a grid with `cells` cells per axis, with the least total area of cuts; ties
/// prefer larger k, then larger j. Throws Error if there is no factorisation with at least one cell per block.
std::array<int, 3> decompose(int parts, std::array<int64_t, 3> cells);

/// Returns n + 1 face coordinates that cut [lo, hi] evenly. If cells > 0, the faces lie on points of a grid
/// with `cells` cells, and block sizes differ by one cell at most. Throws Error for n < 1, an empty interval
/// or fewer cells than blocks.
std::vector<double> evenFaces(double lo, double hi, int n, int64_t cells);

}  // namespace gxy
