// SPDX-License-Identifier: Apache-2.0
#include "core/data/bricks.h"

#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "core/comm/error.h"

namespace gxy {
namespace {

// Most pieces are a side of a brick. A copy whose length is known when it is compiled is several times as fast.
void copyPiece(std::byte* to, const std::byte* from, size_t bytes) {
  constexpr size_t kSide = Bricks::kSide;
  if (bytes == kSide * 4) return void(std::memcpy(to, from, kSide * 4));
  if (bytes == kSide) return void(std::memcpy(to, from, kSide));
  if (bytes == kSide * 2) return void(std::memcpy(to, from, kSide * 2));
  if (bytes == kSide * 8) return void(std::memcpy(to, from, kSide * 8));
  if (bytes == kSide * 12) return void(std::memcpy(to, from, kSide * 12));
  std::memcpy(to, from, bytes);
}

}  // namespace

Bricks::Bricks(const Index3& points) {
  const auto bricks = [&](size_t axis) { return (points[axis] + kSide - 1) / kSide; };
  far_[0] = kStepX;
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
  if (bricks.count() == 0) return samples.clear();
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
          copyPiece(samples.data() + place * bytesPerPoint, from + size_t(first) * bytesPerPoint,
                    size_t(count) * bytesPerPoint);
        });
      }
  }
}

void storeInBricks(std::span<std::byte> bricks, const Extent& block, const Extent& box, int64_t first,
                   std::span<const std::byte> samples, size_t bytesPerPoint) {
  const Bricks place(block.points);
  const Index3& n = box.points;
  for (int64_t point = first; !samples.empty();) {
    const int64_t x = point % n[0], y = point / n[0] % n[1], z = point / n[0] / n[1];
    const int64_t points = std::min(n[0] - x, int64_t(samples.size() / bytesPerPoint));
    place.alongX(x + box.first[0] - block.first[0], y + box.first[1] - block.first[1],
                 z + box.first[2] - block.first[2], points, [&](size_t at, int64_t from, int64_t count) {
                   copyPiece(bricks.data() + at * bytesPerPoint,
                             samples.data() + size_t(from) * bytesPerPoint, size_t(count) * bytesPerPoint);
                 });
    samples = samples.subspan(size_t(points) * bytesPerPoint);
    point += points;
  }
}

void copyFromBricks(std::span<const std::byte> bricks, const Extent& block, const Extent& box,
                    std::span<std::byte> samples, size_t bytesPerPoint) {
  const Bricks place(block.points);
  std::byte* to = samples.data();
  for (int64_t z = 0; z < box.points[2]; ++z)
    for (int64_t y = 0; y < box.points[1]; ++y) {
      place.alongX(box.first[0] - block.first[0], y + box.first[1] - block.first[1],
                   z + box.first[2] - block.first[2], box.points[0],
                   [&](size_t at, int64_t first, int64_t count) {
                     copyPiece(to + size_t(first) * bytesPerPoint, bricks.data() + at * bytesPerPoint,
                               size_t(count) * bytesPerPoint);
                   });
      to += size_t(box.points[0]) * bytesPerPoint;
    }
}

void clearPadding(std::span<std::byte> bricks, const Index3& points, size_t bytesPerPoint) {
  const Bricks place(points);
  const auto whole = [&](size_t axis) {
    return (points[axis] + Bricks::kSide - 1) / Bricks::kSide * Bricks::kSide;
  };
  for (int64_t z = 0; z < whole(2); ++z)
    for (int64_t y = 0; y < whole(1); ++y) {
      const bool inside = y < points[1] && z < points[2];
      const int64_t first = inside ? points[0] : 0;
      place.alongX(first, y, z, whole(0) - first, [&](size_t at, int64_t, int64_t count) {
        std::memset(bricks.data() + at * bytesPerPoint, 0, size_t(count) * bytesPerPoint);
      });
    }
}

}  // namespace gxy
