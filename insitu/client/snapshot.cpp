// SPDX-License-Identifier: Apache-2.0
#include "insitu/client/snapshot.h"

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/data/scalar.h"

namespace gxy::insitu {

namespace {

// How a value is written. row(): the same of `n` values that stand together.
template <size_t Size>
struct AsItIs {
  static constexpr size_t kFrom = Size, kTo = Size;
  void operator()(const std::byte* from, std::byte* to) const { std::memcpy(to, from, Size); }
  void row(const std::byte* from, size_t n, std::byte* to) const { std::memcpy(to, from, n * Size); }
};

struct AsFloat {
  static constexpr size_t kFrom = sizeof(double), kTo = sizeof(float);
  double shift = 0, inverse = 1;  // of the scale, so that a product is the quotient

  void operator()(const std::byte* from, std::byte* to) const {
    double value;
    std::memcpy(&value, from, sizeof value);
    const auto stored = float((value - shift) * inverse);
    constexpr float kLargest = std::numeric_limits<float>::max();
    // Infinite values remain so.
    const bool isTooLarge =
        std::abs(stored) > kLargest && std::abs(value) <= std::numeric_limits<double>::max();
    const float kept = isTooLarge ? std::copysign(kLargest, stored) : stored;
    std::memcpy(to, &kept, sizeof kept);
  }
  void row(const std::byte* __restrict__ from, size_t n, std::byte* __restrict__ to) const {
    for (size_t i = 0; i < n; i++) (*this)(from + i * kFrom, to + i * kTo);
  }
};

// Copies `n` points of a row, each with `components` values.
template <class Write>
std::byte* copyRow(const Write& write, const std::byte* from, int64_t n, int64_t stride, int components,
                   int64_t componentStride, std::byte* out) {
  for (int64_t i = 0; i < n; i++, from += stride) {
    const std::byte* value = from;
    for (int c = 0; c < components; c++, value += componentStride, out += Write::kTo) write(value, out);
  }
  return out;
}

template <class Write>
void copyBox(const Write& write, const gxy_array& values, const Extent& block, const Extent& points,
             std::byte* out) {
  constexpr auto kFrom = int64_t(Write::kFrom);
  const int64_t componentStride = values.component_stride ? values.component_stride : kFrom;
  const auto pointBytes = kFrom * values.components;
  const bool together =
      (values.components == 1 || componentStride == kFrom) && values.stride[0] == pointBytes;
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
        out =
            copyRow(write, row + along(0, from), to - from, stride, values.components, componentStride, out);
      };
      copy(first, inside, 0);
      if (together) {
        const auto n = size_t((outside - inside) * values.components);
        write.row(row + along(0, inside), n, out);
        out += n * Write::kTo;
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
      return copyBox(AsItIs<1>(), values, block, points, out);
    case 2:
      return copyBox(AsItIs<2>(), values, block, points, out);
    case 4:
      return copyBox(AsItIs<4>(), values, block, points, out);
    default:
      return copyBox(AsItIs<8>(), values, block, points, out);
  }
}

void copyPointsAsFloats(const gxy_array& values, const Extent& block, const Extent& points, double shift,
                        double scale, std::byte* out) {
  // The simulation may have traps, flush small results to zero or round in another way; here it is as everywhere in Galaxy.
  std::fenv_t before;
  std::feholdexcept(&before);
  std::fesetenv(FE_DFL_ENV);
  copyBox(AsFloat{shift, 1 / scale}, values, block, points, out);
  std::fesetenv(&before);
}

}  // namespace gxy::insitu
