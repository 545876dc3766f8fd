// SPDX-License-Identifier: Apache-2.0
// Decodes one LZ4 block piece by piece (github.com/lz4/lz4, doc/lz4_Block_format.md). liblz4 would decode a
// block all at once, into memory of the size that the file states. Used inside core/io only.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace gxy {

/// A block is a list of sequences. Each has a token with two lengths, literals, and a copy of earlier output.
class Lz4Block {
 public:
  struct Step {
    size_t used, made;
    bool damaged;
  };
  /// Decodes from `in`, which continues the bytes used before, into `out`, until one of them is used up.
  /// Returns the numbers of bytes used and made, and whether the block is damaged.
  Step decode(std::span<const std::byte> in, std::span<std::byte> out);
  /// Whether a block may end here, which is after literals only.
  bool mayEnd() const { return expects_ == Expects::Offset && offsetBytes_ == 0; }

 private:
  enum class Expects { Token, LiteralLength, Literals, Offset, MatchLength, Match };
  static constexpr size_t kWindow = size_t(64) << 10;  ///< a copy reaches back at most this many bytes

  void put(std::byte b, std::span<std::byte> out, Step& step) {
    out[step.made++] = b;
    window_[put_++ % kWindow] = b;
  }

  Expects expects_ = Expects::Token;
  uint64_t literals_ = 0, match_ = 0;  ///< bytes of literals, and of the copy, that are still to come
  unsigned matchCode_ = 0, offsetBytes_ = 0;
  size_t offset_ = 0;
  uint64_t put_ = 0;
  std::array<std::byte, kWindow> window_{};
};

}  // namespace gxy
