// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace gxy::flow {

/// SHA-256 (FIPS 180-4) of bytes that are added piece by piece.
class Sha256 {
 public:
  using Digest = std::array<uint8_t, 32>;

  void add(std::string_view bytes);
  /// Returns the digest of all that was added. Nothing may be added afterwards.
  Digest digest();

 private:
  void compress();

  std::array<uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                 0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<uint8_t, 64> block_{};
  size_t filled_ = 0;  // bytes of the block
  uint64_t bytes_ = 0;
};

}  // namespace gxy::flow
