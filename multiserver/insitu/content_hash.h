// SPDX-License-Identifier: Apache-2.0
// Tells whether long arrays have changed without keeping them.
#pragma once
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace gxy {

/// Of 128 bits: contents that are not made to collide have another hash if they differ. Reads some bytes per nanosecond.
class ContentHash {
 public:
  void add(std::span<const std::byte> bytes) {
    add(bytes.size());
    size_t i = 0;
    for (; i + sizeof(uint64_t) <= bytes.size(); i += sizeof(uint64_t)) {
      uint64_t word = 0;
      std::memcpy(&word, bytes.data() + i, sizeof word);
      add(word);
    }
    uint64_t rest = 0;
    if (i < bytes.size()) std::memcpy(&rest, bytes.data() + i, bytes.size() - i);
    add(rest);
  }
  void add(uint64_t word) {
    // Each step is a bijection of the state and of the word, so that a single change always shows; odd factors with bits all over.
    state_[0] = std::rotl(state_[0] ^ word, 29) * 0x9e3779b97f4a7c15u;
    state_[1] = std::rotl(state_[1] + word, 37) * 0xd6e8feb86659fd93u;
  }
  std::array<uint64_t, 2> value() const { return state_; }

 private:
  std::array<uint64_t, 2> state_{0x243f6a8885a308d3u, 0x13198a2e03707344u};
};

}  // namespace gxy
