// SPDX-License-Identifier: Apache-2.0
#include "gxy/server/tenants.h"

#include <gtest/gtest.h>

#include <thread>

#include "gxy/comm/error.h"

namespace gxy {
namespace {

TEST(Tokens, AreLongAndNeverTheSame) {
  const std::string a = newToken(), b = newToken();
  EXPECT_EQ(a.size(), 64u);
  EXPECT_EQ(a.find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_NE(a, b);
}

TEST(Tokens, AreTheSameOrNot) {
  EXPECT_TRUE(sameToken("abc", "abc"));
  for (const char* other : {"", "ab", "abd", "abcd", "abcabc"})
    EXPECT_FALSE(sameToken(other, "abc")) << other;
  EXPECT_FALSE(sameToken("", "abc"));
  EXPECT_FALSE(sameToken("x", ""));
}

TEST(Tenants, AreWhoTheirTokensSay) {
  Tenants tenants(1);
  tenants.add("one", {"ann", true});
  tenants.add("two", {"bob", false});
  EXPECT_EQ(tenants.identify("one", "bob")->tenant, "ann") << "whatever they call themselves";
  EXPECT_FALSE(tenants.identify("two", "ann")->administrator);
  EXPECT_FALSE(tenants.identify("three", "ann").has_value());
  EXPECT_FALSE(tenants.identify("", "ann").has_value());
  EXPECT_FALSE(Tenants(1).identify("", "ann").has_value()) << "nobody, before there are tokens";
}

TEST(Tenants, HaveSoManyFramesInFlightAndNoMore) {
  Tenants tenants(2);
  auto first = tenants.begin("ann"), second = tenants.begin("ann");
  EXPECT_THROW(tenants.begin("ann"), Error);
  EXPECT_NO_THROW(tenants.begin("bob"));
  first = {};
  auto third = tenants.begin("ann");
  std::thread waits([&] { tenants.beginWhenFree("ann", [] {}); });
  second = {};
  waits.join();
  EXPECT_THROW(
      {
        auto fourth = tenants.begin("ann");
        tenants.beginWhenFree("ann", [] { throw Error("cancelled"); });
      },
      Error);
  for (const auto& t : tenants.statistics()) EXPECT_EQ(t["frames in flight"], t["tenant"] == "ann" ? 1 : 0);
}

}  // namespace
}  // namespace gxy
