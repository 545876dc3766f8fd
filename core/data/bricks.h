// SPDX-License-Identifier: Apache-2.0
// The order in which a block's points lie in memory.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "core/data/scalar.h"
#include "core/data/volume.h"

namespace gxy {

/// Bricks of 8^3 points, x fastest in each and among them; those at the ends of the axes are filled up. What a ray looks up
/// next is near in memory whichever way it goes (docs/decisions/0011). Kernels find points by the same rule
/// (core/kernels/volume_view.h).
class Bricks {
 public:
  static constexpr int64_t kSide = 8;

  /// Of a block with so many points. Throws Error if there are more than 2^28 in a layer of one z.
  explicit Bricks(const Index3& points);

  /// The place of a point, which counts points.
  size_t operator()(int64_t x, int64_t y, int64_t z) const { return along(0, x) + along(1, y) + along(2, z); }
  /// How many places there are.
  size_t count() const { return count_; }
  /// Places in a row of bricks along x, and in a layer of such rows.
  int64_t row() const { return far_[1]; }
  int64_t layer() const { return far_[2]; }

  /// Calls visit(place, first, n) for the pieces of `points` points from (x, y, z) on along x that lie together: the
  /// `first`th and n - 1 behind it, from `place` on.
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

  static constexpr Index3 kNear{1, kSide, kSide* kSide};  ///< from a point to the next, in a brick
  Index3 far_;                                            ///< from a brick to the next
  size_t count_;
};

/// Puts points that lie x fastest into bricks, filled up with zeros. Needs memory for one layer of bricks more, and for all
/// where `samples` has no capacity for what fills up. `check` is called before each layer; what it throws leaves the samples in no
/// order.
void putIntoBricks(
    Samples& samples, const Index3& points, size_t bytesPerPoint, const std::function<void()>& check = [] {});

}  // namespace gxy
