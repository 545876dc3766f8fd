// SPDX-License-Identifier: Apache-2.0
// Tests that reading before or behind an allocation of guarded_new ends a program. Otherwise programs that
// pass under it would prove nothing.
#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace gxy::test {
namespace {

int valueAt(const std::vector<int>& v, ptrdiff_t i) {
  const volatile int* p = v.data();
  return p[i];
}

std::vector<int> counted(size_t n) {
  std::vector<int> v(n);
  std::iota(v.begin(), v.end(), 0);
  return v;
}

TEST(GuardedNew, before) {
  for (size_t n : {size_t(8), size_t(24), size_t(1024), size_t(100000)}) {
    const std::vector<int> v = counted(n);
    EXPECT_EQ(valueAt(v, 0), 0);
    for (ptrdiff_t i : {-1, -50000}) EXPECT_DEATH(valueAt(v, i), "");
  }
}

TEST(GuardedNew, behind) {
  for (size_t n : {size_t(8), size_t(24), size_t(1024), size_t(100000)}) {
    const std::vector<int> v = counted(n);
    EXPECT_EQ(valueAt(v, ptrdiff_t(n) - 1), int(n) - 1);
    for (ptrdiff_t i : {0, 50000}) EXPECT_DEATH(valueAt(v, ptrdiff_t(n) + i), "");
  }
}

}  // namespace
}  // namespace gxy::test
