// SPDX-License-Identifier: Apache-2.0
#include "core/comm/work.h"

#include <gtest/gtest.h>

#include <optional>

#include "core/comm/error.h"
#include "core/comm/in_process.h"
#include "tests/comm/tap.h"
#include "tests/comm/work_checks.h"

using namespace gxy;

namespace {

/// Work on each rank of a seeded world, with the works of work_checks.h.
struct Ranks {
  Ranks(int ranks, uint64_t seed) : world(ranks, seed) {
    for (int r = 0; r < ranks; ++r) {
      works.push_back(std::make_unique<Work>(world.rank(r)));
      addWorks(*works[r], r);
    }
  }
  std::vector<Work::Reply> broadcast(int from, const std::string& name, const nlohmann::json& parameters,
                                     const Bytes& attachment = {}) {
    std::optional<std::vector<Work::Reply>> replies;
    works[from]->broadcast(
        name, parameters, [&](auto got) { replies = std::move(got); }, attachment);
    world.run();
    return replies.value();
  }
  InProcessWorld world;
  std::vector<std::unique_ptr<Work>> works;
};

}  // namespace

TEST(Work, ABroadcastRunsOnEveryRankOnceAndBringsEveryResult) {
  for (uint64_t seed = 0; seed < 300; ++seed) {
    Ranks ranks(1 + int(seed % 8), seed);
    const int from = int(seed / 8) % ranks.world.size();
    const auto replies = ranks.broadcast(from, "sum", {{"a", 0.1}, {"b", 7}}, Bytes(3, std::byte(1)));
    ASSERT_EQ(replies.size(), size_t(ranks.world.size()));
    for (int r = 0; r < ranks.world.size(); ++r) {
      EXPECT_TRUE(replies[r].ok());
      EXPECT_EQ(replies[r].rank, r);
      EXPECT_EQ(replies[r].result["sum"], 0.1 + 7 + r);
      EXPECT_EQ(replies[r].result["sender"], from);
      EXPECT_EQ(replies[r].result["bytes"], 3);
    }
  }
}

TEST(Work, OneRankCanBeMeant) {
  Ranks ranks(4, 1);
  std::vector<Work::Reply> replies;
  ranks.works[1]->send(3, "sum", {{"a", 1}, {"b", 2}}, [&](auto got) { replies = std::move(got); });
  ranks.world.run();
  ASSERT_EQ(replies.size(), 1u);
  EXPECT_EQ(replies[0].rank, 3);
  EXPECT_EQ(replies[0].result["sum"], 6);
}

TEST(Work, AnErrorCarriesTheRankAndTheReason) {
  Ranks ranks(4, 1);
  const auto replies = ranks.broadcast(2, "fail on odd ranks", {});
  EXPECT_TRUE(replies[0].ok());
  EXPECT_EQ(replies[1].error, "rank 1: no object 'density'");
  EXPECT_TRUE(replies[2].ok());
  EXPECT_EQ(replies[3].error, "rank 3: no object 'density'");
}

TEST(Work, AnUnknownNameIsAnErrorOfEveryRank) {
  Ranks ranks(2, 1);
  for (const auto& reply : ranks.broadcast(0, "nothing", {}))
    EXPECT_EQ(reply.error, "rank " + std::to_string(reply.rank) + ": no work named 'nothing' is registered");
}

TEST(Work, AnExceptionOfAnyKindIsAnErrorReply) {
  Ranks ranks(2, 1);
  for (const auto& reply : ranks.broadcast(0, "throw a number", {})) EXPECT_FALSE(reply.ok());
  for (const auto& reply : ranks.broadcast(0, "sum", {{"a", "text"}})) EXPECT_FALSE(reply.ok());
}

TEST(Work, TextThatIsNotUtf8AndNumbersThatJsonLacksDoNoHarm) {
  Ranks ranks(2, 1);
  for (const auto& reply : ranks.broadcast(0, "echo", {{"text", "\xff\xfe"}, {"nan", std::nan("")}})) {
    EXPECT_TRUE(reply.ok());
    EXPECT_TRUE(reply.result["nan"].is_null());
  }
}

TEST(Work, DeepParametersAreRefused) {
  Ranks ranks(2, 1);
  nlohmann::json deep = 1;
  for (int i = 0; i < 1000; ++i) deep = nlohmann::json::array({deep});
  for (const auto& reply : ranks.broadcast(0, "echo", deep)) EXPECT_FALSE(reply.ok());
}

TEST(Work, ANameIsRegisteredOnce) {
  InProcessWorld world(1, 1);
  Work work(world.rank(0));
  addWorks(work, 0);
  EXPECT_THROW(work.add("sum", nullptr), Error);
}

TEST(Work, MalformedMessagesAreRefusedOrAnswered) {
  Random random(17);
  for (int i = 0; i < 3000; ++i) {
    Ranks ranks(2, uint64_t(i));
    // A real request, caught on its way, then broken.
    Bytes request;
    ranks.works[1] = nullptr;
    ranks.world.rank(1).onMessage(Channel::Work, [&](int, Bytes message) { request = std::move(message); });
    int answers = 0;
    ranks.works[0]->send(1, "sum", {{"a", 1}, {"b", 2}}, [&](auto) { ++answers; });
    ranks.world.run();
    ASSERT_FALSE(request.empty());
    if (random.oneIn(3)) request.resize(random.below(request.size()));
    for (uint64_t n = random.below(4); n > 0 && !request.empty(); --n)
      request[random.below(request.size())] = std::byte(random.next());
    ranks.works[1] = std::make_unique<Work>(ranks.world.rank(1));
    addWorks(*ranks.works[1], 1);
    ranks.world.rank(0).send(1, Channel::Work, std::move(request));
    try {
      ranks.world.run();
    } catch (const Error&) {
    }
    EXPECT_LE(answers, 1);
    EXPECT_EQ(ranks.broadcast(0, "echo", 5).at(1).result, 5);
  }
}

// A rank passes on what the ranks below it reply, so what it spoils is theirs, too.
TEST(Work, ACorruptReplyIsAnErrorOfEachRankThatItCouldBeOf) {
  using test::Tap;
  constexpr int kRanks = 7,
                kCaller = 2;  // the tree of rank 2: its children are 3 and 4, and those of 3 are 5 and 6
  Random random(5);
  for (uint64_t seed = 0; seed < 500; ++seed) {
    InProcessWorld::Options options;
    std::vector<std::string> errors;
    options.onError = [&](int, const std::string& error) { errors.push_back(error); };
    InProcessWorld world(kRanks, seed, options);
    const size_t header = 1 + 4 + 8 + 1;  // says whose call it is
    const auto spoil = [&](int, Channel, Bytes& message) {
      if (message[0] != std::byte(1)) return;  // not a reply
      message.resize(header + random.below(message.size() - header));
      if (seed % 2 == 0) message.resize(message.size() + 1 + random.below(99), std::byte(random.next()));
    };
    std::vector<std::unique_ptr<Tap>> taps;
    std::vector<std::unique_ptr<Work>> works;
    for (int r = 0; r < kRanks; ++r) {
      taps.push_back(std::make_unique<Tap>(
          world.rank(r), r == 3 ? Tap::Look(spoil) : [](int, Channel, Bytes&) {}));
      works.push_back(std::make_unique<Work>(*taps.back()));
      addWorks(*works.back(), r);
    }
    std::optional<std::vector<Work::Reply>> all, one;
    works[kCaller]->broadcast("echo", "x", [&](auto got) { all = std::move(got); });
    works[0]->send(3, "echo", "x", [&](auto got) { one = std::move(got); });
    world.run();
    ASSERT_TRUE(all && one) << "seed " << seed;
    ASSERT_EQ(all->size(), size_t(kRanks));
    for (int r = 0; r < kRanks; ++r) {
      const Work::Reply& reply = all->at(size_t(r));
      EXPECT_EQ(reply.rank, r);
      const bool spoilt = r == 3 || r == 5 || r == 6;
      EXPECT_EQ(reply.ok(), !spoilt) << "rank " << r << ", seed " << seed;
      if (spoilt) {
        EXPECT_EQ(reply.error.rfind("rank " + std::to_string(r) + ": its reply came by rank 3: ", 0), 0u)
            << reply.error;
      }
    }
    ASSERT_EQ(one->size(), 1u);
    EXPECT_EQ(one->front().rank, 3);
    EXPECT_FALSE(one->front().ok());
    EXPECT_EQ(errors, std::vector<std::string>{});
  }
}

TEST(Work, AReplyThatComesTwiceIsRefused) {
  InProcessWorld::Options options;
  std::vector<std::string> errors;
  options.onError = [&](int, const std::string& error) { errors.push_back(error); };
  InProcessWorld world(4, 3, options);
  test::Tap twice(world.rank(1), [&](int destination, Channel channel, Bytes& message) {
    if (message[0] == std::byte(1)) world.rank(1).send(destination, channel, message);
  });
  std::vector<std::unique_ptr<Work>> works;
  for (int r = 0; r < 4; ++r) {
    works.push_back(std::make_unique<Work>(r == 1 ? static_cast<Transport&>(twice) : world.rank(r)));
    addWorks(*works.back(), r);
  }
  size_t replies = 0;
  works[0]->broadcast("echo", "x", [&](auto got) { replies = got.size(); });
  world.run();
  EXPECT_EQ(replies, 4u);
  EXPECT_EQ(errors.size(), 1u);
}

TEST(Work, WaitingCallsThrowTheErrorsOfAllRanks) {
  InProcessWorld::Options options;
  options.threaded = true;
  InProcessWorld world(4, 1, options);
  std::vector<std::unique_ptr<Work>> works;
  std::vector<std::unique_ptr<Collective>> collectives;
  for (int r = 0; r < 4; ++r) {
    works.push_back(std::make_unique<Work>(world.rank(r)));
    collectives.push_back(std::make_unique<Collective>(world.rank(r)));
    addWorks(*works[r], r);
    addCollectiveWork(*works[r], *collectives[r]);
  }
  checkWaitingCalls(*works[2], 4);
}
