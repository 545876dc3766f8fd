// SPDX-License-Identifier: Apache-2.0
#include "insitu/client/snapshot.h"

#include <algorithm>
#include <cstring>

#include "core/data/scalar.h"

namespace gxy::insitu {

namespace {

// Copies `n` points of a row, each with `components` values of `Size` bytes.
template <size_t Size>
std::byte* copyRow(const std::byte* from, int64_t n, int64_t stride, int components, int64_t componentStride,
                   std::byte* out) {
  for (int64_t i = 0; i < n; i++, from += stride) {
    const std::byte* value = from;
    for (int c = 0; c < components; c++, value += componentStride, out += Size) std::memcpy(out, value, Size);
  }
  return out;
}

template <size_t Size>
void copyBox(const gxy_array& values, const Extent& block, const Extent& points, std::byte* out) {
  const int64_t componentStride = values.component_stride ? values.component_stride : int64_t(Size);
  const auto pointBytes = int64_t(Size) * values.components;
  const bool together =
      (values.components == 1 || componentStride == int64_t(Size)) && values.stride[0] == pointBytes;
  // The place of a value, along one axis.
  const auto along = [&](size_t axis, int64_t i) {
    return std::clamp<int64_t>(i - block.first[axis], 0, block.points[axis] - 1) * values.stride[axis];
  };
  const int64_t first = points.first[0], end = first + points.points[0],
                blockEnd = block.first[0] + block.points[0];
  const int64_t inside = std::clamp(block.first[0], first, end), outside = std::clamp(blockEnd, inside, end);
  for (int64_t k = points.first[2]; k < points.first[2] + points.points[2]; k++)
    for (int64_t j = points.first[1]; j < points.first[1] + points.points[1]; j++) {
      const std::byte* row = static_cast<const std::byte*>(values.data) + along(1, j) + along(2, k);
      const auto copy = [&](int64_t from, int64_t to, int64_t stride) {
        out = copyRow<Size>(row + along(0, from), to - from, stride, values.components, componentStride, out);
      };
      copy(first, inside, 0);
      if (together) {
        const auto bytes = size_t((outside - inside) * pointBytes);
        std::memcpy(out, row + along(0, inside), bytes);
        out += bytes;
      } else {
        copy(inside, outside, values.stride[0]);
      }
      copy(outside, end, 0);
    }
}

}  // namespace

void copyPoints(const gxy_array& values, const Extent& block, const Extent& points, std::byte* out) {
  switch (bytesOf(ScalarType(values.type))) {
    case 1:
      return copyBox<1>(values, block, points, out);
    case 2:
      return copyBox<2>(values, block, points, out);
    case 4:
      return copyBox<4>(values, block, points, out);
    default:
      return copyBox<8>(values, block, points, out);
  }
}

}  // namespace gxy::insitu
