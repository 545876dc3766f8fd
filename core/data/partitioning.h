// SPDX-License-Identifier: Apache-2.0
// How a domain is cut into disjoint boxes (partitions), and which rank owns which.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/data/box.h"

namespace gxy {

/// A domain box cut by faces into a lattice of cells, each cell belonging to one partition, each partition a
/// box of cells owned by one rank. The table is the same on every rank; a rank may own any number of
/// partitions, none included. Immutable after construction; safe to read from any thread.
class Partitioning {
 public:
  /// faces[a]: ascending world coordinates of all cuts on axis a, both ends of the domain included (>= 2
  /// entries). cells: partition of each lattice cell, x fastest. owners: rank of each partition. Throws Error
  /// unless every partition is a non-empty box of cells and every owner a rank (>= 0).
  Partitioning(std::array<std::vector<double>, 3> faces, std::vector<int32_t> cells,
               std::vector<int32_t> owners);

  /// A regular or irregular lattice: one partition per lattice cell, x fastest, owned by rank p * ranks /
  /// partitions.
  static Partitioning lattice(std::array<std::vector<double>, 3> faces, int ranks);

  /// Arbitrary disjoint boxes that fill their common bounding box (k-d splits, what a simulation hands over);
  /// box p becomes partition p, owned by owners[p]. Coordinates closer than 1e-9 of the domain's side are one
  /// face, the smallest of them except at the domain's end. Throws Error, naming the boxes, if two overlap or
  /// a hole is left, or if their faces make more than 2^28 lattice cells.
  static Partitioning fromBoxes(std::span<const Box> boxes, std::vector<int32_t> owners);

  /// The whole box as one partition, owned by rank 0.
  static Partitioning single(const Box& box);

  const Box& domain() const { return domain_; }
  int partitions() const { return int(boxes_.size()); }
  const Box& box(int partition) const { return boxes_[partition]; }
  int owner(int partition) const { return owners_[partition]; }
  /// The partitions of a rank, ascending; empty for a rank that owns none.
  std::vector<int> owned(int rank) const;

  std::span<const double> faces(int axis) const { return faces_[axis]; }
  /// Lattice cells on each axis.
  std::array<int, 3> cells() const;
  std::span<const int32_t> cellPartition() const { return cells_; }

  /// The partition that holds world point p, upper faces belonging to the next partition except at the
  /// domain's end; -1 outside the domain.
  int locate(glm::dvec3 p) const;
  /// The partition nearest to p: that of p clamped into the domain. p must be finite.
  int nearest(glm::dvec3 p) const;

  /// Lattice cells on one axis whose closed extent meets [lo, hi], as first and last index; cells at the
  /// domain's ends reach outwards without limit, so there is always one.
  std::array<int, 2> cellsTouched(int axis, double lo, double hi) const;

  bool operator==(const Partitioning&) const = default;

 private:
  Box domain_;
  std::array<std::vector<double>, 3> faces_;
  std::vector<int32_t> cells_;
  std::vector<int32_t> owners_;
  std::vector<Box> boxes_;
};

/// Factors `parts` into i*j*k so that blocks of a grid with `cells` cells per axis are as close to cubes as
/// possible (least total cut surface; ties: larger k, then j). Throws Error if a factorisation with at least
/// one cell per block does not exist.
std::array<int, 3> decompose(int parts, std::array<int64_t, 3> cells);

/// n + 1 face coordinates that cut [lo, hi] evenly; where cells > 0, on points of a grid with `cells` cells,
/// block sizes differing by one cell at most. Throws Error for n < 1, an empty interval or fewer cells than
/// blocks.
std::vector<double> evenFaces(double lo, double hi, int n, int64_t cells);

}  // namespace gxy
