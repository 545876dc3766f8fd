// SPDX-License-Identifier: Apache-2.0
// What all ranks do together takes few messages of each rank, however many ranks there are.
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <memory>
#include <vector>

#include "core/comm/collective.h"
#include "core/comm/in_process.h"
#include "core/comm/work.h"

namespace gxy {
namespace {

constexpr int kRanks = 64, kLog = 6;

/// Counts what one rank sends to others and gets from them.
class Counted final : public Transport {
 public:
  explicit Counted(Transport& to) : to_(to) {}
  int rank() const override { return to_.rank(); }
  int size() const override { return to_.size(); }
  void send(int destination, Channel channel, Bytes message) override {
    if (destination != rank()) sent++;
    to_.send(destination, channel, std::move(message));
  }
  void onMessage(Channel channel, Handler handler) override {
    if (!handler) return to_.onMessage(channel, {});
    to_.onMessage(channel, [this, handler](int source, Bytes message) {
      if (source != rank()) {
        received++;
        bytesReceived += int(message.size());
      }
      handler(source, std::move(message));
    });
  }
  void post(Task task) override { to_.post(std::move(task)); }
  void postWaiting(Task task) override { to_.postWaiting(std::move(task)); }
  Counters counters() const override { return to_.counters(); }

  std::atomic<int> sent = 0, received = 0, bytesReceived = 0;

 private:
  Transport& to_;
};

using Counts = std::vector<std::unique_ptr<Counted>>;

/// What `act` takes of each rank.
Counts countsOf(const std::function<void(Collective&, int rank)>& act) {
  InProcessWorld::Options options;
  options.threaded = true;
  InProcessWorld world(kRanks, 1, options);
  Counts counts;
  std::vector<std::unique_ptr<Collective>> collectives;
  for (int r = 0; r < kRanks; ++r) {
    counts.push_back(std::make_unique<Counted>(world.rank(r)));
    collectives.push_back(std::make_unique<Collective>(*counts.back()));
  }
  for (int r = 0; r < kRanks; ++r)
    counts[size_t(r)]->postWaiting([&, r] { act(*collectives[size_t(r)], r); });
  world.run();
  return counts;
}

TEST(FewMessages, OfGatheringAndReducingThreeEachWay) {
  for (uint64_t key = 0; key < 3; ++key)
    for (const auto& c : countsOf([key](Collective&collective, int) { collective.barrier(key); })) {
      EXPECT_LE(c->sent, 3);
      EXPECT_LE(c->received, 3);
    }
  for (const auto& c : countsOf([](Collective&collective, int rank) {
         EXPECT_EQ(collective.allGather(5, Bytes(1, std::byte(rank))).size(), size_t(kRanks));
       })) {
    EXPECT_LE(c->sent, 3);
    EXPECT_LE(c->received, 3);
  }
}

TEST(FewMessages, OfRanksThatAgreeHardlyAnyBytes) {
  for (const auto& c : countsOf([](Collective&collective, int) { collective.agree(5, {}); }))
    EXPECT_LE(c->bytesReceived, 100);
}

TEST(FewMessages, OfAnExchangeThoseThatHaveSomethingInThemAndTheLogarithm) {
  for (const auto& c : countsOf([](Collective&collective, int rank) {
         std::vector<Bytes> toNext(kRanks);
         toNext[size_t(rank + 1) % kRanks] = Bytes(3, std::byte(rank));
         const auto came = collective.allToAll(5, std::move(toNext));
         for (int r = 0; r < kRanks; ++r)
           EXPECT_EQ(came[size_t(r)], (r + 1) % kRanks == rank ? Bytes(3, std::byte(r)) : Bytes());
       })) {
    EXPECT_EQ(c->sent, kLog + 1);
    EXPECT_EQ(c->received, kLog + 1);
  }
}

TEST(FewMessages, OfAWorkForAllThreeEachWayAndEqualResultsOnce) {
  for (const int caller : {0, 41}) {
    InProcessWorld world(kRanks, uint64_t(caller));
    Counts counts;
    std::vector<std::unique_ptr<Work>> works;
    for (int r = 0; r < kRanks; ++r) {
      counts.push_back(std::make_unique<Counted>(world.rank(r)));
      works.push_back(std::make_unique<Work>(*counts.back()));
      works.back()->add("tell", [](const Work::Call&) -> nlohmann::json { return std::string(1000, 'x'); });
    }
    size_t replies = 0;
    works[size_t(caller)]->broadcast("tell", nullptr, [&](auto all) { replies = all.size(); });
    world.run();
    EXPECT_EQ(replies, size_t(kRanks));
    for (const auto& c : counts) {
      EXPECT_LE(c->sent, 3);
      EXPECT_LE(c->received, 3);
      EXPECT_LE(c->bytesReceived, 3000);
    }
  }
}

}  // namespace
}  // namespace gxy
