// SPDX-License-Identifier: Apache-2.0
#include "core/space/directory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>
#include <unordered_set>

#include "core/comm/error.h"

namespace gxy {
namespace {

TEST(Keys, NoTwoAreEqualOverRanksAndThreads) {
  std::vector<std::vector<Key>> made(6);
  KeySource sources[3] = {KeySource(0), KeySource(1), KeySource(4096)};
  std::vector<std::thread> threads;
  for (size_t t = 0; t < made.size(); ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 1000; ++i) made[t].push_back(sources[t % 3].next());
    });
  }
  for (std::thread& t : threads) t.join();
  std::unordered_set<Key> all;
  for (const auto& keys : made) all.insert(keys.begin(), keys.end());
  EXPECT_EQ(all.size(), 6000u);
  EXPECT_FALSE(all.contains(Key{}));
}

TEST(Directory, PrivateNamesComeBeforeSharedOnes) {
  Directory d;
  d.bind("density", Scope::Shared, {{1}, "Volume", "ann", false});
  EXPECT_EQ(d.get("bob", "density").key, Key{1});
  d.bind("density", Scope::Private, {{2}, "Volume", "bob", false});
  EXPECT_EQ(d.get("bob", "density").key, Key{2});
  EXPECT_EQ(d.get("ann", "density").key, Key{1});
  EXPECT_EQ(d.remove("bob", "density", Scope::Private).key, Key{2});
  EXPECT_EQ(d.get("bob", "density").key, Key{1});
}

TEST(Directory, PrivateNamesAreSeenByTheirTenantOnly) {
  Directory d;
  d.bind("mine", Scope::Private, {{1}, "Volume", "ann", false});
  EXPECT_FALSE(d.find("bob", "mine"));
  EXPECT_THROW(d.get("bob", "mine"), Error);
  EXPECT_THROW(d.remove("bob", "mine", Scope::Private), Error);
  EXPECT_TRUE(d.list("bob").empty());
  EXPECT_EQ(d.list("ann").size(), 1u);
}

TEST(Directory, ANameChangesOnlyIfItMeansWhatIsExpected) {
  Directory d;
  const DirectoryEntry first{{1}, "Volume", "ann"}, second{{2}, "Volume", "ann"};
  EXPECT_FALSE(d.bindIf("name", second, first)) << "there is none";
  EXPECT_TRUE(d.bindIf("name", std::nullopt, first));
  EXPECT_FALSE(d.bindIf("name", std::nullopt, second));
  EXPECT_FALSE(d.removeIf("ann", "name", second));
  EXPECT_TRUE(d.bindIf("name", first, second));
  EXPECT_EQ(d.get("ann", "name"), second);
  EXPECT_FALSE(d.removeIf("bob", "name", second));
  EXPECT_TRUE(d.removeIf("ann", "name", second));
  EXPECT_FALSE(d.find("ann", "name"));
}

TEST(Directory, ReadOnlyNamesChangeByTheirOwnerOnly) {
  Directory d;
  d.bind("atlas", Scope::Shared, {{1}, "Volume", "ann", true});
  EXPECT_THROW(d.bind("atlas", Scope::Shared, {{2}, "Volume", "bob", false}), Error);
  EXPECT_THROW(d.remove("bob", "atlas", Scope::Shared), Error);
  EXPECT_EQ(d.get("bob", "atlas").key, Key{1});
  const auto before = d.bind("atlas", Scope::Shared, {{3}, "Volume", "ann", false});
  ASSERT_TRUE(before);
  EXPECT_EQ(before->key, Key{1});
  EXPECT_NO_THROW(d.bind("atlas", Scope::Shared, {{4}, "Volume", "bob", false}));
}

TEST(Directory, ListsByNameWithHiddenSharedOnes) {
  Directory d;
  d.bind("b", Scope::Shared, {{1}, "Volume", "ann", false});
  d.bind("a", Scope::Shared, {{2}, "Triangles", "ann", false});
  d.bind("b", Scope::Private, {{3}, "Particles", "bob", false});
  const auto list = d.list("bob");
  ASSERT_EQ(list.size(), 3u);
  EXPECT_EQ(list[0].name, "a");
  EXPECT_EQ(list[1].entry.key, Key{3});
  EXPECT_EQ(list[2].entry.key, Key{1});
  EXPECT_THROW(d.bind("", Scope::Shared, {}), Error);
}

}  // namespace
}  // namespace gxy
