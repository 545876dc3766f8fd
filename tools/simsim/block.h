// SPDX-License-Identifier: Apache-2.0
// The part of a grid that one rank owns, and the values that it has there.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/io/volume_file.h"
#include "insitu/api/galaxy_insitu.h"

namespace gxy::simsim {

/// Returns the points that `rank` owns of a grid. The boxes of all ranks are disjoint and have all points
/// together. Throws Error if the grid cannot be cut into so many boxes of one point or more.
Extent blockOf(const Index3& points, int rank, int ranks);

/// One array in the block of a rank: its values in two files, and its values in the current step. As in many
/// simulations, the latter have one layer of ghost points around the block. Ghost points hold no data here
/// (fillWithNoData()), so that a reader who takes them for owned points is seen.
class BlockArray {
 public:
  BlockArray(const ArrayInfo& array, const Extent& owned);

  /// Memory for the values of the owned points in each file: x fastest, components interleaved.
  std::span<std::byte> first() { return first_; }
  std::span<std::byte> second() { return second_; }

  /// Computes the values of a step in which the second file has this weight.
  void compute(double weight);

  /// The owned points of the current step, as the C interface describes them. The memory stays where it is.
  gxy_array view() const;
  /// Returns a copy of the values of the owned points, laid out as those of the files.
  std::vector<std::byte> copyOfOwned() const;

 private:
  ArrayInfo array_;
  size_t bytesPerPoint_;
  Extent owned_, stored_;  ///< stored_: with the ghost points, also beyond the ends of the grid
  std::vector<std::byte> first_, second_, current_;
};

}  // namespace gxy::simsim
