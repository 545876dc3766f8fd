// SPDX-License-Identifier: Apache-2.0
#include "core/space/publication.h"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "core/comm/error.h"
#include "tests/support/thread_ranks.h"

namespace gxy {
namespace {

constexpr int kThree = 3;
constexpr Key kOld{7}, kOther{8}, kNew{9};

struct RankObjects {
  Observers observers;
  Objects objects{observers};
};

/// Three ranks that hold generation 1 of two objects.
struct ThreeRanks {
  std::array<RankObjects, kThree> ranks;
  test::ThreadRanks threads{kThree};

  ThreeRanks() {
    for (RankObjects& rank : ranks)
      for (const Key key : {kOld, kOther}) rank.objects.add(key, makePayload<int>(1));
  }
  Objects& objects(int rank) { return ranks[size_t(rank)].objects; }

  using Act = std::function<void(Publication&, Collectives&)>;
  /// The second generations of both objects and a new one, as far as `act` goes. Returns the ranks' errors.
  std::vector<std::string> publish(const Act& act) {
    return threads.run([&](Collectives& mine) {
      Publication publication(
          objects(mine.rank()), mine,
          {{kOld, 2, "dataset \"old\""}, {kOther, 2, "dataset \"other\""}, {kNew, 1, "dataset \"new\""}});
      act(publication, mine);
    });
  }
  /// Whether every rank has what it had at first, and could begin anew.
  void expectNothingHasChanged() {
    for (RankObjects& rank : ranks) {
      for (const Key key : {kOld, kOther}) {
        EXPECT_EQ(rank.objects.pin(key).generation(), 1u);
        EXPECT_TRUE(rank.objects.reserve(key));
        rank.objects.abandon(key);
      }
      EXPECT_FALSE(rank.objects.contains(kNew));
    }
  }
};

void stageAll(Publication& publication) {
  for (size_t i = 0; i < publication.items().size(); i++) publication.stage(i, makePayload<int>(2));
}

TEST(Publication, MakesAllItemsCurrentOnAllRanksAndRankZeroLast) {
  ThreeRanks world;
  const auto errors = world.publish([&](Publication& publication, Collectives&) {
    publication.reserve();
    stageAll(publication);
    publication.commit({[&] { EXPECT_EQ(world.objects(1).pin(kOld).generation(), 1u); },
                        [&] {
                          for (int rank = 1; rank < kThree; rank++) {
                            EXPECT_EQ(world.objects(rank).pin(kOld).generation(), 2u);
                            EXPECT_TRUE(world.objects(rank).contains(kNew));
                          }
                        }});
  });
  EXPECT_EQ(errors, std::vector<std::string>(kThree));
  for (RankObjects& rank : world.ranks) {
    for (const Key key : {kOld, kOther}) EXPECT_EQ(rank.objects.pin(key).generation(), 2u);
    EXPECT_EQ(rank.objects.pin(kNew).generation(), 1u);
    for (const Key key : {kOld, kOther, kNew}) EXPECT_EQ(*rank.objects.pin(key).get<int>(), 2);
  }
}

TEST(Publication, WhereRankZeroHasNoRoomNoRankGivesAGenerationUp) {
  ThreeRanks world;
  for (RankObjects& rank : world.ranks) {
    ASSERT_TRUE(rank.objects.reserve(kOther));
    rank.objects.stage(kOther, makePayload<int>(2));
  }
  const Pin first = world.objects(0).pin(kOther);
  for (RankObjects& rank : world.ranks) rank.objects.commit(kOther, 2);
  const auto errors = world.threads.run([&](Collectives& mine) {
    Publication publication(world.objects(mine.rank()), mine,
                            {{kOld, 2, "dataset \"old\""}, {kOther, 3, "dataset \"other\""}});
    publication.reserve();
  });
  EXPECT_EQ(errors, std::vector<std::string>(
                        kThree,
                        "rank 0: dataset \"other\": both its generations are in use, so this step is "
                        "left out"));
  for (RankObjects& rank : world.ranks) EXPECT_NO_THROW(rank.objects.pin(kOther, 1)) << "it is still there";
}

TEST(Publication, IsGivenUpOnAllRanksWhateverFailsWhere) {
  for (int failing = 0; failing < kThree; failing++) {
    ThreeRanks world;
    const std::vector<ThreeRanks::Act> acts{
        [&](Publication&, Collectives& mine) {  // before anything
          agree(mine, [&] {
            if (mine.rank() == failing) throw Error("a file is damaged");
          });
        },
        [&](Publication& publication, Collectives& mine) {  // no room
          Objects& objects = world.objects(mine.rank());
          if (mine.rank() == failing) {
            EXPECT_TRUE(objects.reserve(kOther));
          }
          try {
            publication.reserve();
          } catch (const Error&) {
            if (mine.rank() == failing) objects.abandon(kOther);
            throw;
          }
        },
        [&](Publication& publication, Collectives& mine) {  // a key that is in use
          if (mine.rank() == failing) world.objects(failing).add(kNew, makePayload<int>(0));
          publication.reserve();
          stageAll(publication);
          try {
            publication.commit();
          } catch (const Error&) {
            if (mine.rank() == failing) world.objects(failing).drop(kNew);
            throw;
          }
        },
        [&](Publication& publication, Collectives& mine) {  // while data are made
          publication.reserve();
          agree(mine, [&] {
            if (mine.rank() == failing) throw Error("memory is short");
          });
        },
        [&](Publication& publication, Collectives& mine) {  // nothing staged
          publication.reserve();
          if (mine.rank() != failing) stageAll(publication);
          publication.commit();
        },
        [&](Publication& publication, Collectives&) {  // rank 0 refuses
          publication.reserve();
          stageAll(publication);
          publication.commit({[] { throw Error("the name was taken back"); }, {}});
        }};
    for (size_t i = 0; i < acts.size(); i++) {
      for (const std::string& error : world.publish(acts[i])) EXPECT_NE(error, "") << i << " on " << failing;
      world.expectNothingHasChanged();
    }
  }
}

TEST(Publication, IsGivenUpWhereAnObjectIsDroppedMeanwhile) {
  ThreeRanks world;
  const auto errors = world.publish([&](Publication& publication, Collectives& mine) {
    publication.reserve();
    stageAll(publication);
    world.objects(mine.rank()).drop(kOld);
    publication.commit();
  });
  for (const std::string& error : errors) EXPECT_NE(error.find("there is none"), std::string::npos) << error;
  for (RankObjects& rank : world.ranks) {
    EXPECT_FALSE(rank.objects.contains(kOld));
    EXPECT_FALSE(rank.objects.contains(kNew));
    EXPECT_EQ(rank.objects.pin(kOther).generation(), 1u);
    EXPECT_TRUE(rank.objects.reserve(kOther));
  }
}

}  // namespace
}  // namespace gxy
