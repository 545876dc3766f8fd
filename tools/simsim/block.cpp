// SPDX-License-Identifier: Apache-2.0
#include "tools/simsim/block.h"

#include <algorithm>
#include <array>
#include <string>

#include "core/comm/error.h"
#include "core/data/partitioning.h"
#include "tools/simsim/blend.h"

namespace gxy::simsim {
namespace {

// The numbers of types are the same on both sides.
static_assert(int(ScalarType::Int8) == GXY_INT8 && int(ScalarType::UInt8) == GXY_UINT8 &&
              int(ScalarType::Int16) == GXY_INT16 && int(ScalarType::UInt16) == GXY_UINT16 &&
              int(ScalarType::Int32) == GXY_INT32 && int(ScalarType::UInt32) == GXY_UINT32 &&
              int(ScalarType::Int64) == GXY_INT64 && int(ScalarType::UInt64) == GXY_UINT64 &&
              int(ScalarType::Float32) == GXY_FLOAT32 && int(ScalarType::Float64) == GXY_FLOAT64);

std::array<int, 3> latticeOf(const Index3& points, int ranks) {
  try {
    return decompose(ranks, points);
  } catch (const Error&) {
    throw Error("the grid of " + std::to_string(points[0]) + " x " + std::to_string(points[1]) + " x " +
                std::to_string(points[2]) + " points cannot be cut into " + std::to_string(ranks) +
                " blocks of one point or more; expected another number of ranks");
  }
}

Extent withGhostLayer(Extent extent) {
  for (size_t a = 0; a < 3; ++a) {
    extent.first[a] -= 1;
    extent.points[a] += 2;
  }
  return extent;
}

}  // namespace

Extent blockOf(const Index3& points, int rank, int ranks) {
  const std::array<int, 3> lattice = latticeOf(points, ranks);
  const std::array<int, 3> at{rank % lattice[0], rank / lattice[0] % lattice[1],
                              rank / lattice[0] / lattice[1]};
  Extent owned;
  for (size_t a = 0; a < 3; ++a) {
    // Blocks differ by one point at most.
    const auto cut = [n = points[a], blocks = int64_t(lattice[a])](int64_t i) {
      return n / blocks * i + std::min(i, n % blocks);
    };
    owned.first[a] = cut(at[a]);
    owned.points[a] = cut(at[a] + 1) - owned.first[a];
  }
  return owned;
}

BlockArray::BlockArray(const ArrayInfo& array, const Extent& owned)
    : array_(array),
      bytesPerPoint_(bytesOf(array.type) * size_t(array.components)),
      owned_(owned),
      stored_(withGhostLayer(owned)),
      first_(size_t(owned.count()) * bytesPerPoint_),
      second_(first_.size()),
      current_(size_t(stored_.count()) * bytesPerPoint_) {
  fillWithNoData(array.type, current_);
}

void BlockArray::compute(double weight) {
  const size_t row = size_t(owned_.points[0]) * bytesPerPoint_;
  size_t from = 0;
  for (int64_t k = 1; k <= owned_.points[2]; ++k)
    for (int64_t j = 1; j <= owned_.points[1]; ++j, from += row) {
      const size_t to = size_t((k * stored_.points[1] + j) * stored_.points[0] + 1) * bytesPerPoint_;
      blend(array_.type, weight, std::span(first_).subspan(from, row), std::span(second_).subspan(from, row),
            std::span(current_).subspan(to, row));
    }
}

gxy_array BlockArray::view() const {
  const int64_t point = int64_t(bytesPerPoint_), row = point * stored_.points[0],
                slice = row * stored_.points[1];
  gxy_array view{};
  view.data = current_.data() + slice + row + point;
  view.type = int(array_.type);
  view.components = array_.components;
  view.stride[0] = point;
  view.stride[1] = row;
  view.stride[2] = slice;
  return view;
}

std::vector<std::byte> BlockArray::copyOfOwned() const {
  std::vector<std::byte> copy(first_.size());
  copyBox(owned_, current_, stored_, copy, owned_, bytesPerPoint_);
  return copy;
}

}  // namespace gxy::simsim
