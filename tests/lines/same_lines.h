// SPDX-License-Identifier: Apache-2.0
// Compares lines to the bit.
#pragma once
#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "tests/lines/flow_fields.h"

namespace gxy::test {

template <class T>
bool sameBits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

inline bool sameBits(const LineEnd& a, const LineEnd& b) {
  const auto same = [](const auto& x, const auto& y) { return std::memcmp(&x, &y, sizeof x) == 0; };
  return a.line == b.line && a.backward == b.backward && a.reason == b.reason && a.points == b.points &&
         same(a.time, b.time) && same(a.length, b.length) && same(a.position, b.position);
}

/// Expects that the points and the ends of lines have the same bits.
inline void expectSameLines(const Lines& a, const Lines& b, const std::string& what) {
  EXPECT_TRUE(sameBits(a.points.line, b.points.line)) << what;
  EXPECT_TRUE(sameBits(a.points.number, b.points.number)) << what;
  EXPECT_TRUE(sameBits(a.points.position, b.points.position)) << what;
  EXPECT_TRUE(sameBits(a.points.time, b.points.time)) << what;
  EXPECT_TRUE(sameBits(a.points.length, b.points.length)) << what;
  EXPECT_TRUE(sameBits(a.points.speed, b.points.speed)) << what;
  ASSERT_EQ(a.points.values.size(), b.points.values.size()) << what;
  for (size_t k = 0; k < a.points.values.size(); k++)
    EXPECT_TRUE(sameBits(a.points.values[k], b.points.values[k])) << what;
  ASSERT_EQ(a.ends.size(), b.ends.size()) << what;
  size_t different = 0;
  for (size_t i = 0; i < a.ends.size(); i++) different += !sameBits(a.ends[i], b.ends[i]);
  EXPECT_EQ(different, 0u) << what;
}

}  // namespace gxy::test
