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
#include "core/comm/wire.h"

namespace gxy {

/// Immutable. Sums are added in one order, so all ranks compute the same bits.
class MacrocellDensities {
 public:
  static constexpr int64_t kSide = 8;  ///< macrocells of a block along each axis
  static constexpr size_t kCells = size_t(kSide * kSide * kSide);

  using Bound = std::function<double(double least, double largest)>;

  /// Collective. `bound` returns the largest density of the values in [least, largest]. `component` is as of FieldReader::value. If any
  /// rank fails, all throw the same Error.
  MacrocellDensities(const Volume& volume, const FieldReader& reader, int component, const Bound& bound,
                     Collectives& ranks);

  /// The sum over all macrocells of bound times cells.
  double total() const { return sums_.back(); }

  struct Macrocell {
    Index3 firstCell, cells;  ///< global index of its first cell, and how many it has
    double bound;             ///< of the density in it
  };
  /// Returns the macrocell at `place` in [0, total()) of the cumulative bounds. Returns nothing if this rank holds no part of its
  /// block.
  std::optional<Macrocell> at(double place) const;

 private:
  struct Block {
    std::array<double, kCells> bounds;
    std::array<double, kCells + 1> sums;  ///< of the macrocells before each
  };
  using Messages = std::vector<Writer>;  ///< by rank
  void tellBounds(const Volume& volume, const FieldReader& reader, int component, const Bound& bound,
                  Collectives& ranks, Messages& told, Messages& wanted) const;
  void collect(const std::vector<Bytes>& heard, std::map<int64_t, Block>& collected, Writer& sums) const;
  void answer(const std::vector<Bytes>& asked, const std::map<int64_t, Block>& collected,
              Messages& answers) const;
  void take(const std::vector<Bytes>& answered);
  void takeSums(const std::vector<Bytes>& all);
  int64_t blockOf(const Index3& macrocell) const;
  Macrocell macrocell(int64_t block, size_t place) const;
  void sum(int64_t number, Block& block) const;

  const Index3 cells_, macrocells_, blocks_;
  std::vector<double> sums_;  ///< of the blocks before each
  std::map<int64_t, Block> held_;
};

}  // namespace gxy
