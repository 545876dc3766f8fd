// SPDX-License-Identifier: Apache-2.0
// Bounds of a density in the macrocells of a distributed volume, in two levels: each rank knows the sums of all blocks of macrocells, and the
// macrocells of the blocks that it holds a part of.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "core/analysis/field_reader.h"
#include "core/comm/collectives.h"

namespace gxy {

/// Immutable. Sums are added in one order, so all ranks compute the same bits.
class MacrocellDensities {
 public:
  static constexpr int64_t kSide = 8;  ///< macrocells of a block along each axis
  static constexpr size_t kCells = size_t(kSide * kSide * kSide);

  /// Collective. `bound` returns the largest density of the values in [least, largest]. `component` is as of FieldReader::value. If any
  /// rank fails, all throw the same Error.
  MacrocellDensities(const Volume& volume, const FieldReader& reader, int component,
                     const std::function<double(double least, double largest)>& bound, Collectives& ranks);

  /// The sum over all macrocells of bound times cells.
  double total() const { return sums_.back(); }

  struct Macrocell {
    Index3 firstCell, cells;  ///< global index of its first cell, and how many it has
    double bound;             ///< of the density in it
  };
  /// Returns the macrocell at `place` in [0, total()) of the cumulative bounds. Returns nothing if this rank holds no part of its
  /// block.
  std::optional<Macrocell> at(double place) const;

  /// How many macrocells have density 0, of all.
  uint64_t empty() const { return empty_; }

 private:
  struct Block {
    std::array<double, kCells> bounds;
    std::array<double, kCells + 1> sums;  ///< of the macrocells before each
  };
  int64_t blockOf(const Index3& macrocell) const;
  Macrocell macrocell(int64_t block, size_t place) const;
  void sum(int64_t number, Block& block) const;

  const Index3 cells_;
  Index3 macrocells_, blocks_;
  std::vector<double> sums_;  ///< of the blocks before each
  std::map<int64_t, Block> held_;
  uint64_t empty_ = 0;
};

}  // namespace gxy
