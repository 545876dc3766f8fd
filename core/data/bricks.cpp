// SPDX-License-Identifier: Apache-2.0
#include "core/data/bricks.h"

#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "core/comm/error.h"

namespace gxy {

Bricks::Bricks(const Index3& points) {
  const auto bricks = [&](size_t axis) { return (points[axis] + kSide - 1) / kSide; };
  far_[0] = kSide * kSide * kSide;
  far_[1] = far_[0] * bricks(0);
  far_[2] = far_[1] * bricks(1);
  if (far_[2] > std::numeric_limits<int32_t>::max())
    throw Error("a block of " + std::to_string(points[0]) + " x " + std::to_string(points[1]) +
                " points in x and y, expected at most 2^28: cut the volume into more partitions");
  count_ = size_t(far_[2] * bricks(2));
}

void putIntoBricks(Samples& samples, const Index3& points, size_t bytesPerPoint,
                   const std::function<void()>& check) {
  const Bricks bricks(points);
  const size_t layer = size_t(bricks.layer()) * bytesPerPoint;
  const size_t row = size_t(points[0]) * bytesPerPoint, plane = size_t(points[1]) * row;
  samples.resize(bricks.count() * bytesPerPoint);
  std::vector<std::byte> planes(plane * size_t(Bricks::kSide));
  // The last layer comes first: a layer of bricks begins no earlier than its rows did, so it overwrites no
  // unread rows.
  for (int64_t z0 = (points[2] - 1) / Bricks::kSide * Bricks::kSide; z0 >= 0; z0 -= Bricks::kSide) {
    check();
    const int64_t n = std::min(Bricks::kSide, points[2] - z0);
    std::memcpy(planes.data(), samples.data() + size_t(z0) * plane, size_t(n) * plane);
    std::memset(samples.data() + size_t(z0 / Bricks::kSide) * layer, 0, layer);
    for (int64_t z = 0; z < n; z++)
      for (int64_t y = 0; y < points[1]; y++) {
        const std::byte* from = planes.data() + size_t(z) * plane + size_t(y) * row;
        bricks.alongX(0, y, z0 + z, points[0], [&](size_t place, int64_t first, int64_t count) {
          std::memcpy(samples.data() + place * bytesPerPoint, from + size_t(first) * bytesPerPoint,
                      size_t(count) * bytesPerPoint);
        });
      }
  }
}

}  // namespace gxy
