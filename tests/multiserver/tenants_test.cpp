// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/tenants.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

#include "core/comm/error.h"

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

TEST(Tenants, OfAServerThatAdmitsAllAreWhomTheyNameButForWhatIsNoTenant) {
  Tenants tenants(1);
  tenants.admitAll();
  EXPECT_EQ(tenants.identify("", "ann")->tenant, "ann");
  EXPECT_TRUE(tenants.identify("", "ann")->administrator);
  for (const char* name : {"server", "device", "", ".hidden", "a/b"})
    EXPECT_THROW(tenants.identify("", name), Error) << name;
}

const Tenants::Cost free{0, [] { return int64_t(0); }};

TEST(Tenants, HaveSoManyBytesOfPicturesInFlightAndNoMore) {
  Tenants tenants(100);
  const auto cost = [](int64_t bytes) { return Tenants::Cost{bytes, [] { return int64_t(1000); }}; };
  auto first = tenants.begin("ann", cost(600));
  EXPECT_THROW(tenants.begin("ann", cost(401)), Error);
  EXPECT_NO_THROW(tenants.begin("bob", cost(1000)));
  auto second = tenants.begin("ann", cost(400));
  std::thread waits([&] { tenants.beginWhenFree("ann", cost(500), [] {}); });
  first = {};
  waits.join();
  EXPECT_THROW(tenants.beginWhenFree("ann", cost(601), [] { throw Error("cancelled"); }), Error);
  second = {};
  EXPECT_THROW(tenants.beginWhenFree("ann", cost(1001), [] { FAIL() << "it waits"; }), Error)
      << "it will never fit";
  for (const auto& t : tenants.statistics()) EXPECT_EQ(t["picture bytes"], 0);
}

TEST(Tenants, HaveSoManyFramesInFlightAndNoMore) {
  Tenants tenants(2);
  auto first = tenants.begin("ann", free), second = tenants.begin("ann", free);
  EXPECT_THROW(tenants.begin("ann", free), Error);
  EXPECT_NO_THROW(tenants.begin("bob", free));
  first = {};
  auto third = tenants.begin("ann", free);
  std::thread waits([&] { tenants.beginWhenFree("ann", free, [] {}); });
  second = {};
  waits.join();
  EXPECT_THROW(
      {
        auto fourth = tenants.begin("ann", free);
        tenants.beginWhenFree("ann", free, [] { throw Error("cancelled"); });
      },
      Error);
  for (const auto& t : tenants.statistics()) EXPECT_EQ(t["frames in flight"], t["tenant"] == "ann" ? 1 : 0);
}

TEST(Tenants, AreCountedWithTheFramesThatTheyMade) {
  Tenants tenants(4);
  const auto statisticsOf = [&](const std::string& tenant) {
    for (const auto& t : tenants.statistics())
      if (t["tenant"] == tenant) return t;
    return nlohmann::json();
  };
  auto first = tenants.begin("ann", free), second = tenants.begin("ann", free),
       other = tenants.begin("bob", free);
  const auto begin = std::chrono::steady_clock::now();
  std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_EQ(statisticsOf("ann")["frames"], 0);
  first = {};
  EXPECT_EQ(statisticsOf("ann")["frames"], 1);
  EXPECT_EQ(statisticsOf("ann")["frames in flight"], 1);
  second = {};
  EXPECT_EQ(statisticsOf("ann")["frames"], 2);
  EXPECT_GE(statisticsOf("ann")["frame seconds"], 2 * seconds);
  EXPECT_EQ(statisticsOf("bob")["frames"], 0);
  for (const char* tenant : {"ann", "bob"}) EXPECT_EQ(tenants.name(tenants.number(tenant)), tenant);
}

TEST(Tenants, HaveSoManyLongRequestsAtOnceAndNoMore) {
  Tenants tenants(1);
  std::vector<std::shared_ptr<void>> running;
  for (int i = 0; i < Tenants::kAside; i++) running.push_back(tenants.beginAside("ann"));
  EXPECT_THROW((void)tenants.beginAside("ann"), Error);
  EXPECT_NO_THROW((void)tenants.beginAside("bob"));
  running.pop_back();
  EXPECT_NO_THROW((void)tenants.beginAside("ann"));
}

}  // namespace
}  // namespace gxy
