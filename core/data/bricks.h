// SPDX-License-Identifier: Apache-2.0
// The order in which a block's points lie in memory.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "core/data/scalar.h"
#include "core/data/volume.h"

namespace gxy {

/// The layout of a block in bricks of 8^3 points. x is fastest among the points of a brick and among the
/// bricks; bricks at the upper ends of the axes are padded. So the samples that a ray reads next are near in
/// memory, whatever its direction (docs/decisions/0011). Kernels find points by the same rule
/// (core/kernels/volume_view.h).
class Bricks {
 public:
  static constexpr int64_t kSide = 8;
  static constexpr int64_t kStepX = kSide * kSide * kSide;  ///< places from a brick to the next along x

  /// The layout of a block with this many points per axis. Throws Error if a layer in x and y has more than
  /// 2^28 points (padding included).
  explicit Bricks(const Index3& points);

  /// The place of a point in memory, counted in points.
  size_t operator()(int64_t x, int64_t y, int64_t z) const { return along(0, x) + along(1, y) + along(2, z); }
  /// The number of places, padding included.
  size_t count() const { return count_; }
  /// The number of places in a row of bricks along x, and in a layer of such rows.
  int64_t row() const { return far_[1]; }
  int64_t layer() const { return far_[2]; }

  /// Splits a row of `points` points, from (x, y, z) on along x, into pieces that are contiguous in memory.
  /// Calls visit(place, first, n) for each: the n points from number `first` of the row on lie at `place` and
  /// the places after.
  template <class Visit>
  void alongX(int64_t x, int64_t y, int64_t z, int64_t points, Visit visit) const {
    const size_t row = along(1, y) + along(2, z);
    for (int64_t first = 0, n; first < points; first += n, x += n) {
      n = std::min(kSide - x % kSide, points - first);
      visit(row + along(0, x), first, n);
    }
  }

 private:
  size_t along(int axis, int64_t i) const {
    return size_t(i / kSide * far_[size_t(axis)] + i % kSide * kNear[size_t(axis)]);
  }

  static constexpr Index3 kNear{1, kSide, kSide* kSide};  ///< by axis: step to the next point in a brick
  Index3 far_;                                            ///< by axis: step to the next brick
  size_t count_;
};

/// Reorders samples from x fastest into bricks, padded with zeros. Needs additional memory for one layer of
/// bricks, and for a copy of everything if `samples` has no capacity for the padding. Calls `check` before
/// each layer. If `check` throws, the samples are left in an undefined order.
void putIntoBricks(
    Samples& samples, const Index3& points, size_t bytesPerPoint, const std::function<void()>& check = [] {});

/// Stores samples in a block that is in bricks: consecutive points of `box`, x fastest, from its point number `first` on. The block
/// contains the box, and the box as many points.
void storeInBricks(std::span<std::byte> bricks, const Extent& block, const Extent& box, int64_t first,
                   std::span<const std::byte> samples, size_t bytesPerPoint);

/// Copies the points of `box` out of a block that is in bricks and contains it, x fastest.
void copyFromBricks(std::span<const std::byte> bricks, const Extent& block, const Extent& box,
                    std::span<std::byte> samples, size_t bytesPerPoint);

/// Sets the padding of a block of this many points to zeros.
void clearPadding(std::span<std::byte> bricks, const Index3& points, size_t bytesPerPoint);

}  // namespace gxy
