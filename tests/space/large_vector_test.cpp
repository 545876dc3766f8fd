// SPDX-License-Identifier: Apache-2.0
#include "core/space/large_vector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

namespace gxy {
namespace {

TEST(LargeVector, TakesTheMemoryOfTheLastOneOfItsSize) {
  constexpr size_t kMany = 3 * kHugePage / sizeof(uint32_t);
  const uint32_t *first = nullptr, *second = nullptr;
  {
    LargeVector<uint32_t> a(kMany, 7), b(kMany, 8);
    first = a.data(), second = b.data();
    EXPECT_EQ(reinterpret_cast<uintptr_t>(first) % kHugePage, 0u);
  }  // b goes first
  LargeVector<uint32_t> larger(2 * kMany, 1);
  EXPECT_NE(larger.data(), first);
  EXPECT_NE(larger.data(), second);
  LargeVector<uint32_t> a(kMany - 5, 9), b(kMany, 0);  // of as many pages
  EXPECT_EQ(a.data(), first);
  EXPECT_EQ(b.data(), second);
  EXPECT_EQ(std::count(b.begin(), b.end(), 0u), std::ptrdiff_t(kMany));
  EXPECT_EQ(std::count(a.begin(), a.end(), 9u), std::ptrdiff_t(kMany - 5));
}

// More than are kept, at once and one after the other.
TEST(LargeVector, GivesBackWhatIsNotKept) {
  for (int i = 0; i < 3; i++) {
    std::vector<LargeVector<std::byte>> many(5);
    for (auto& v : many) {
      v.resize(kMostKept / 4);
      v.front() = v.back() = std::byte{1};
    }
  }
  LargeVector<std::byte> large;
  large.resize(kMostKept + kHugePage);
  large.back() = std::byte{1};
}

}  // namespace
}  // namespace gxy
