// SPDX-License-Identifier: Apache-2.0
// Sums that do not depend on the order of what is added. Used inside core/analysis only.
#pragma once
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace gxy {

/// A sum of doubles as a 128-bit integer in units of 2^-80 of a power of two above all of them. Each value is rounded once, to the
/// nearest unit. 2^44 values fit, each times at most 8.
class FixedSum {
 public:
  FixedSum() = default;
  /// For values of a size of at most `largest`, which is finite.
  explicit FixedSum(double largest) {
    int exponent = 0;
    std::frexp(largest, &exponent);  // largest < 2^exponent
    unit_ = exponent - kBits;
  }

  void add(double value, int times = 1) { sum_ += in(value)*times; }
  /// `other` has the same unit.
  void add(const FixedSum& other, int times = 1) { sum_ += other.sum_ * times; }

  /// The sum divided by `by`.
  double over(double by) const { return std::ldexp(double(sum_) / by, unit_); }

 private:
  static constexpr int kBits = 80;
  __extension__ using Integer = __int128;

  Integer in(double value) const {
    const auto bits = std::bit_cast<uint64_t>(value);
    const int exponent = int(bits >> 52 & 0x7ff);
    const uint64_t fraction = bits & ((uint64_t(1) << 52) - 1);
    const uint64_t digits = exponent > 0 ? fraction | uint64_t(1) << 52 : fraction;
    // Without branches, which would be mispredicted. At most, a value is 2^27 times as large as its digits.
    constexpr int kMostShift = kBits - 53;
    const int right = std::min(kMostShift - ((exponent > 0 ? exponent : 1) - 1075 - unit_), 126);
    const Integer half = (Integer(1) << right) >> 1;
    const Integer size = ((Integer(digits) << kMostShift) + half) >> right;
    const Integer sign = -Integer(bits >> 63);
    return (size ^ sign) - sign;
  }

  Integer sum_ = 0;
  int unit_ = 0;
};

}  // namespace gxy
