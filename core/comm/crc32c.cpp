// SPDX-License-Identifier: Apache-2.0
#include "core/comm/crc32c.h"

#include <array>
#include <cstring>

#ifdef __x86_64__
#include <nmmintrin.h>
#endif

namespace gxy {

namespace {

constexpr uint32_t kPolynomial = 0x82f63b78;  // 0x1edc6f41, the lowest power first
constexpr size_t kWord = sizeof(uint64_t);

/// Row n says what a byte does to the checksum with n bytes behind it.
using Table = std::array<std::array<uint32_t, 256>, kWord>;

constexpr Table makeTable() {
  Table table{};
  for (uint32_t byte = 0; byte < 256; byte++) {
    uint32_t crc = byte;
    for (int bit = 0; bit < 8; bit++) crc = crc >> 1 ^ (crc & 1 ? kPolynomial : 0);
    table[0][byte] = crc;
  }
  for (size_t row = 1; row < kWord; row++)
    for (size_t byte = 0; byte < 256; byte++)
      table[row][byte] = table[row - 1][byte] >> 8 ^ table[0][table[row - 1][byte] & 0xff];
  return table;
}
constexpr Table kTable = makeTable();

uint64_t wordAt(const std::byte* bytes) {
  uint64_t word;
  std::memcpy(&word, bytes, kWord);
  return word;
}

#ifdef __x86_64__
// Three parts at once, since the instruction takes one word in each cycle, but has its result after three.
constexpr size_t kPart = 1024;  // bytes

/// The effect of kPart bytes of 0 on each byte of a checksum.
constexpr std::array<std::array<uint32_t, 256>, 4> makeShift() {
  std::array<std::array<uint32_t, 256>, 4> shift{};
  std::array<uint32_t, 32> ofBit{};
  for (size_t bit = 0; bit < 32; bit++) {
    uint32_t crc = 1u << bit;
    for (size_t byte = 0; byte < kPart; byte++) crc = crc >> 8 ^ kTable[0][crc & 0xff];
    ofBit[bit] = crc;
  }
  for (size_t byte = 0; byte < 4; byte++)
    for (size_t value = 0; value < 256; value++)
      for (size_t bit = 0; bit < 8; bit++)
        if (value >> bit & 1) shift[byte][value] ^= ofBit[8 * byte + bit];
  return shift;
}

uint32_t shifted(uint32_t crc) {
  static constexpr auto kShift = makeShift();
  return kShift[0][crc & 0xff] ^ kShift[1][crc >> 8 & 0xff] ^ kShift[2][crc >> 16 & 0xff] ^
         kShift[3][crc >> 24];
}

__attribute__((target("sse4.2"))) uint32_t byInstruction(std::span<const std::byte> bytes) {
  const std::byte* at = bytes.data();
  size_t left = bytes.size();
  uint64_t crc = 0xffffffff;
  for (; left >= 3 * kPart; at += 3 * kPart, left -= 3 * kPart) {
    uint64_t second = 0, third = 0;
    for (size_t i = 0; i < kPart; i += kWord) {
      crc = _mm_crc32_u64(crc, wordAt(at + i));
      second = _mm_crc32_u64(second, wordAt(at + kPart + i));
      third = _mm_crc32_u64(third, wordAt(at + 2 * kPart + i));
    }
    crc = shifted(shifted(uint32_t(crc)) ^ uint32_t(second)) ^ uint32_t(third);
  }
  for (; left >= kWord; at += kWord, left -= kWord) crc = _mm_crc32_u64(crc, wordAt(at));
  auto last = uint32_t(crc);
  for (; left > 0; at++, left--) last = _mm_crc32_u8(last, uint8_t(*at));
  return ~last;
}
#endif

}  // namespace

uint32_t crc32cByTable(std::span<const std::byte> bytes) {
  const std::byte* at = bytes.data();
  size_t left = bytes.size();
  uint32_t crc = 0xffffffff;
  for (; left >= kWord; at += kWord, left -= kWord) {
    const uint64_t word = wordAt(at) ^ crc;  // little-endian, as all of Galaxy
    crc = 0;
    for (size_t i = 0; i < kWord; i++) crc ^= kTable[kWord - 1 - i][word >> 8 * i & 0xff];
  }
  for (; left > 0; at++, left--) crc = crc >> 8 ^ kTable[0][(crc ^ uint8_t(*at)) & 0xff];
  return ~crc;
}

uint32_t crc32c(std::span<const std::byte> bytes) {
#ifdef __x86_64__
  static const bool hasInstruction = __builtin_cpu_supports("sse4.2");
  if (hasInstruction) return byInstruction(bytes);
#endif
  return crc32cByTable(bytes);
}

}  // namespace gxy
