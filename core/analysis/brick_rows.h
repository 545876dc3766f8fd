// SPDX-License-Identifier: Apache-2.0
// Rows of points of blocks in bricks. Used inside core/analysis only.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/data/bricks.h"

namespace gxy {

/// Copies samples of one component, from point `at` of a block on, to a row of doubles or floats.
template <class T, class To>
void readPieces(const Bricks& bricks, const std::byte* samples, int components, int component,
                const Index3& at, int64_t points, To* to) {
  const T* const all = reinterpret_cast<const T*>(samples) + component;
  bricks.alongX(at[0], at[1], at[2], points, [&](size_t place, int64_t first, int64_t n) {
    const T* const from = all + place * size_t(components);
    To* const row = to + first;
    if (n == Bricks::kSide && components == 1)
      for (int64_t i = 0; i < Bricks::kSide; ++i) row[i] = To(from[i]);
    else if (n == Bricks::kSide && components == 3)
      for (int64_t i = 0; i < Bricks::kSide; ++i) row[i] = To(from[3 * i]);
    else
      for (int64_t i = 0; i < n; ++i) row[i] = To(from[i * components]);
  });
}

/// Copies the samples of a row of points, all components, or back.
inline void readSamples(const Bricks& bricks, const std::byte* samples, size_t bytesPerPoint,
                        const Index3& at, int64_t points, std::byte* to) {
  bricks.alongX(at[0], at[1], at[2], points, [&](size_t place, int64_t first, int64_t n) {
    std::memcpy(to + size_t(first) * bytesPerPoint, samples + place * bytesPerPoint,
                size_t(n) * bytesPerPoint);
  });
}
inline void writeSamples(const Bricks& bricks, std::byte* samples, size_t bytesPerPoint, const Index3& at,
                         int64_t points, const std::byte* from) {
  bricks.alongX(at[0], at[1], at[2], points, [&](size_t place, int64_t first, int64_t n) {
    std::memcpy(samples + place * bytesPerPoint, from + size_t(first) * bytesPerPoint,
                size_t(n) * bytesPerPoint);
  });
}

/// Copies a row to samples of one component.
template <class T>
void writePieces(const Bricks& bricks, std::byte* samples, int components, int component, const Index3& at,
                 int64_t points, const T* from) {
  T* const all = reinterpret_cast<T*>(samples) + component;
  bricks.alongX(at[0], at[1], at[2], points, [&](size_t place, int64_t first, int64_t n) {
    T* const to = all + place * size_t(components);
    for (int64_t i = 0; i < n; ++i) to[i * components] = from[first + i];
  });
}

}  // namespace gxy
