// SPDX-License-Identifier: Apache-2.0
// Random numbers that depend on nothing but what they are drawn for.
#pragma once
#include <array>
#include <cstdint>

#include "core/kernels/single.h"

namespace gxy {

/// Returns 4 random words of Philox4x32-10 (core/kernels/philox.h) for draw number `number` of a purpose.
inline std::array<uint32_t, 4> randomWords(uint32_t seed, uint32_t purpose, uint64_t number,
                                           uint32_t part = 0) {
  std::array<uint32_t, 4> c{uint32_t(number), uint32_t(number >> 32), part, 0};
  single::philox4x32(seed, purpose, c[0], c[1], c[2], c[3]);
  return c;
}

/// Returns the number in [0, 1) that a word stands for.
inline double unitOf(uint32_t word) { return double(word) * 0x1p-32; }

/// What numbers are drawn for: keys of Philox, so that draws for one purpose do not repeat those for another.
enum class Draw : uint32_t { Seeds = 1, Density = 2, DensityShift = 3 };

}  // namespace gxy
