// SPDX-License-Identifier: Apache-2.0
#include "insitu/client/snapshot.h"

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
void copyBox(const gxy_array& values, const std::byte* first, const Extent& points, std::byte* out) {
  const int64_t componentStride = values.component_stride ? values.component_stride : int64_t(Size);
  const auto pointBytes = int64_t(Size) * values.components;
  const bool together = values.components == 1 || componentStride == int64_t(Size);
  for (int64_t k = 0; k < points.points[2]; k++)
    for (int64_t j = 0; j < points.points[1]; j++) {
      const std::byte* row = first + j * values.stride[1] + k * values.stride[2];
      if (together && values.stride[0] == pointBytes) {
        std::memcpy(out, row, size_t(points.points[0] * pointBytes));
        out += points.points[0] * pointBytes;
      } else {
        out = copyRow<Size>(row, points.points[0], values.stride[0], values.components, componentStride, out);
      }
    }
}

}  // namespace

void copyPoints(const gxy_array& values, const Index3& first, const Extent& points, std::byte* out) {
  const std::byte* from = static_cast<const std::byte*>(values.data);
  for (size_t a = 0; a < 3; a++) from += (points.first[a] - first[a]) * values.stride[a];
  switch (bytesOf(ScalarType(values.type))) {
    case 1:
      return copyBox<1>(values, from, points, out);
    case 2:
      return copyBox<2>(values, from, points, out);
    case 4:
      return copyBox<4>(values, from, points, out);
    default:
      return copyBox<8>(values, from, points, out);
  }
}

}  // namespace gxy::insitu
