// SPDX-License-Identifier: Apache-2.0
// How a domain is cut into disjoint boxes (partitions), and which rank owns which.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gxy/data/box.h"

namespace gxy {

/// A domain box cut by faces into a lattice of cells, each cell belonging to one partition, each partition a box of
/// cells owned by one rank. The table is the same on every rank; a rank may own any number of partitions, none included.
/// Immutable after construction; safe to read from any thread.
class Partitioning {
 public:
  /// faces[a]: ascending world coordinates of all cuts on axis a, both ends of the domain included (>= 2 entries).
  /// cells: partition of each lattice cell, x fastest. owners: rank of each partition. Throws Error unless every
  /// partition is a non-empty box of cells.
  Partitioning(std::array<std::vector<double>, 3> faces, std::vector<int32_t> cells, std::vector<int32_t> owners);

  /// A regular or irregular lattice: one partition per lattice cell, x fastest, owned by rank p * ranks / partitions.
  static Partitioning lattice(std::array<std::vector<double>, 3> faces, int ranks);

  const Box& domain() const { return domain_; }
  int partitions() const { return int(boxes_.size()); }
  const Box& box(int partition) const { return boxes_[partition]; }
  int owner(int partition) const { return owners_[partition]; }
  std::vector<int> owned(int rank) const;

  std::span<const double> faces(int axis) const { return faces_[axis]; }
  /// Lattice cells on each axis.
  std::array<int, 3> cells() const;
  std::span<const int32_t> cellPartition() const { return cells_; }

  /// The partition that holds world point p, upper faces belonging to the next partition except at the domain's end;
  /// -1 outside the domain.
  int locate(glm::dvec3 p) const;

  bool operator==(const Partitioning&) const = default;

 private:
  Box domain_;
  std::array<std::vector<double>, 3> faces_;
  std::vector<int32_t> cells_;
  std::vector<int32_t> owners_;
  std::vector<Box> boxes_;
};

/// Factors `parts` into i*j*k so that blocks of a grid with `cells` cells per axis are as close to cubes as possible
/// (least total cut surface; ties: larger k, then j). Throws Error if a factorisation with at least one cell per block
/// does not exist.
std::array<int, 3> decompose(int parts, std::array<int64_t, 3> cells);

/// n + 1 face coordinates that cut [lo, hi] evenly, on grid points of a grid with `cells` cells where cells > 0.
std::vector<double> evenFaces(double lo, double hi, int n, int64_t cells);

}  // namespace gxy
