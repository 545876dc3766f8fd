// SPDX-License-Identifier: Apache-2.0
// A small random generator whose numbers are the same with every compiler and library.
#pragma once
#include <cstdint>

namespace gxy {

/// SplitMix64 (Steele, Lea, Flood 2014): 64 bits of state, any seed is good.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  uint64_t next() {
    uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }

  /// Uniform in [0, n), n > 0; the bias of the remainder is below n / 2^64.
  uint64_t below(uint64_t n) { return next() % n; }

  /// True once in n times, n > 0.
  bool oneIn(uint64_t n) { return below(n) == 0; }

 private:
  uint64_t state_;
};

}  // namespace gxy
