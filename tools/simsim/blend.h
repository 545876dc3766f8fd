// SPDX-License-Identifier: Apache-2.0
// The values of a step, which lie between those of two files.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/data/scalar.h"

namespace gxy::simsim {

/// A triangle wave, which goes from 0 to 1 and back to 0 in each cycle.
struct Wave {
  double cycles = 1;   ///< number of cycles in `steps` steps
  int64_t steps = 10;  ///< 1 or more

  /// Returns the weight of the second file in a step. Steps count from 1, and step 1 has weight 0.
  double weight(int64_t step) const;
};

/// Sets each value of `out` to (1 - weight) * a + weight * b. Values of float and double are computed in their
/// own type. Integers are computed in double, those of 64 bits in long double, and are rounded to the
/// nearest, halves away from zero. With weights 0 and 1 the values are those of `a` and `b` to the bit. All
/// spans have the same size.
void blend(ScalarType type, double weight, std::span<const std::byte> a, std::span<const std::byte> b,
           std::span<std::byte> out);

/// Fills `out` with NaN, or with the largest value of an integer type.
void fillWithNoData(ScalarType type, std::span<std::byte> out);

}  // namespace gxy::simsim
