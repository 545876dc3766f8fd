// SPDX-License-Identifier: Apache-2.0
#include "core/comm/crc32c.h"

#include <gtest/gtest.h>

#include <random>
#include <string_view>
#include <vector>

namespace gxy {
namespace {

std::vector<std::byte> ascending(size_t n) {
  std::vector<std::byte> bytes(n);
  for (size_t i = 0; i < n; i++) bytes[i] = std::byte(i);
  return bytes;
}

TEST(Crc32c, ValuesAreThoseOfRfc3720) {
  const std::string_view digits = "123456789";
  for (const auto& crc : {crc32c, crc32cByTable}) {
    EXPECT_EQ(crc(std::vector<std::byte>(32, std::byte(0))), 0x8a9136aau);
    EXPECT_EQ(crc(std::vector<std::byte>(32, std::byte(0xff))), 0x62a8ab43u);
    EXPECT_EQ(crc(ascending(32)), 0x46dd794eu);
    EXPECT_EQ(crc(std::as_bytes(std::span(digits))), 0xe3069283u);
    EXPECT_EQ(crc({}), 0u);
  }
}

TEST(Crc32c, InstructionAndTableAgreeForAnyLengthAndPlace) {
  std::mt19937 random(1);
  std::vector<std::byte> bytes(40000);
  for (std::byte& b : bytes) b = std::byte(random());
  const std::span<const std::byte> all(bytes);
  const auto expectAgreement = [&](size_t from, size_t n) {
    ASSERT_EQ(crc32c(all.subspan(from, n)), crc32cByTable(all.subspan(from, n))) << from << " " << n;
  };
  for (size_t n = 0; n < 100; n++) expectAgreement(n % 9, n);
  for (size_t n = 3 * 1024 - 20; n < 3 * 1024 + 20; n++) expectAgreement(n % 7, n);
  for (int i = 0; i < 500; i++) {
    const size_t from = random() % 100;
    expectAgreement(from, random() % (bytes.size() - from));
  }
}

TEST(Crc32c, AnyFlippedBitIsSeen) {
  std::vector<std::byte> bytes = ascending(5000);
  const uint32_t whole = crc32c(bytes);
  std::mt19937 random(2);
  for (int i = 0; i < 2000; i++) {
    std::byte& one = bytes[random() % bytes.size()];
    const auto bit = std::byte(1 << random() % 8);
    one ^= bit;
    EXPECT_NE(crc32c(bytes), whole);
    one ^= bit;
  }
}

}  // namespace
}  // namespace gxy
