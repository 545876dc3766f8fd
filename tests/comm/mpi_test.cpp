// SPDX-License-Identifier: Apache-2.0
// The same promises as in the in-process world, between real processes. Every rank runs every test.
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <memory>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

#include "core/comm/completion.h"
#include "core/comm/mpi_transport.h"
#include "core/comm/parallel_for.h"
#include "tests/comm/collective_checks.h"
#include "tests/comm/work_checks.h"

using namespace gxy;

namespace {

/// Adds up what comes, and knows when a number of messages is there.
class Sink {
 public:
  explicit Sink(uint64_t expected) : expected_(expected) {}
  void take(const Bytes& message) {
    bytes_ += message.size();
    Random random(message.size());
    for (const auto byte : message) intact_ = intact_ && byte == std::byte(random.next());
    if (++messages_ == expected_) done_.set_value();
  }
  void wait() { done_.get_future().wait(); }
  uint64_t bytes() const { return bytes_; }
  bool intact() const { return intact_; }

 private:
  const uint64_t expected_;
  uint64_t messages_ = 0, bytes_ = 0;
  bool intact_ = true;
  std::promise<void> done_;
};

/// Bytes that only their number decides.
Bytes pattern(size_t size) {
  Random random(size);
  Bytes bytes(size);
  for (auto& byte : bytes) byte = std::byte(random.next());
  return bytes;
}

/// Each rank sends messages of these sizes to each rank, itself included; all arrive with their bytes.
void exchange(MpiTransport::Options options, const std::vector<size_t>& sizes, int repeat) {
  MpiTransport transport(options);
  uint64_t total = 0;
  for (const size_t size : sizes) total += size;
  Sink sink(sizes.size() * size_t(repeat) * size_t(transport.size()));
  transport.onMessage(Channel::Test, [&](int, Bytes message) { sink.take(message); });
  for (int i = 0; i < repeat; ++i)
    for (const size_t size : sizes)
      for (int r = 0; r < transport.size(); ++r) transport.send(r, Channel::Test, pattern(size));
  sink.wait();
  EXPECT_TRUE(sink.intact());
  EXPECT_EQ(sink.bytes(), total * size_t(repeat) * size_t(transport.size()));
}

}  // namespace

TEST(MpiTransport, MessagesOfAllSizesArriveWhole) {
  exchange({}, {0, 1, 17, 1000, 32 << 10, 40000, 65535, 65536, 65537, 1 << 20}, 20);
}

TEST(MpiTransport, SmallPacketsAndChunksChangeNothing) {
  MpiTransport::Options options;
  options.packetBytes = 256;
  options.chunkBytes = 1000;
  exchange(options, {0, 1, 111, 112, 113, 127, 128, 255, 256, 257, 999, 1000, 1001, 2000, 54321}, 30);
}

TEST(MpiTransport, AMessageOf100MegabytesArrives) {
  MpiTransport::Options options;
  options.chunkBytes = 16 << 20;
  MpiTransport transport(options);
  constexpr size_t size = 100'000'000;
  const int last = transport.size() - 1;
  std::promise<Bytes> arrived;
  if (transport.rank() == last)
    transport.onMessage(Channel::Test, [&](int, Bytes message) { arrived.set_value(std::move(message)); });
  if (transport.rank() == 0) transport.send(last, Channel::Test, pattern(size));
  if (transport.rank() != last) return;
  EXPECT_TRUE(arrived.get_future().get() == pattern(size));
}

TEST(MpiTransport, SmallMessagesAreCoalesced) {
  constexpr uint64_t messages = 20000;
  MpiTransport transport;
  Sink sink(messages * uint64_t(transport.size() - 1));
  transport.onMessage(Channel::Test, [&](int, Bytes message) { sink.take(message); });
  Collective collective(transport);
  // Queued from a handler: the progress thread finds them all at once.
  transport.onMessage(Channel::Frame, [&](int, Bytes) {
    for (uint64_t i = 0; i < messages; ++i)
      for (int r = 0; r < transport.size(); ++r)
        if (r != transport.rank()) transport.send(r, Channel::Test, pattern(16));
  });
  transport.send(transport.rank(), Channel::Frame, {});
  sink.wait();
  collective.barrier(1);
  const auto counters = transport.counters();
  EXPECT_GE(counters.messagesSent, messages * uint64_t(transport.size() - 1));
  EXPECT_LT(counters.packetsSent, counters.messagesSent / 100);
}

TEST(MpiTransport, TheDestructorDeliversWhatIsUnderWayAndWhatThatStarts) {
  const std::vector<size_t> sizes{0, 10, 70000};
  for (int round = 0; round < 10; ++round) {
    std::atomic<uint64_t> first = 0, second = 0, tasks = 0;
    int ranks = 0;
    {
      MpiTransport transport;
      ranks = transport.size();
      transport.onMessage(Channel::Test, [&](int source, Bytes message) {
        ++first;
        transport.post([&transport, &tasks, source, message = std::move(message)] {
          ++tasks;
          transport.send(source, Channel::Frame, message);
        });
      });
      transport.onMessage(Channel::Frame, [&](int, Bytes) { ++second; });
      for (const size_t size : sizes)
        for (int r = 0; r < ranks; ++r) transport.send(r, Channel::Test, pattern(size));
    }
    EXPECT_EQ(first, sizes.size() * size_t(ranks));
    EXPECT_EQ(tasks, sizes.size() * size_t(ranks));
    EXPECT_EQ(second, sizes.size() * size_t(ranks));
  }
}

TEST(MpiTransport, AnExceptionOutOfAHandlerOrTaskIsReportedWithItsRank) {
  std::mutex mutex;
  std::vector<std::pair<int, std::string>> reports;
  MpiTransport::Options options;
  options.onError = [&](int rank, const std::string& message) {
    std::lock_guard lock(mutex);
    reports.emplace_back(rank, message);
  };
  int rank = 0;
  {
    MpiTransport transport(options);
    rank = transport.rank();
    transport.onMessage(Channel::Test, [](int, Bytes) { throw Error("no such frame"); });
    transport.send((rank + 1) % transport.size(), Channel::Test, {});
    transport.post([] { throw Error("no such object"); });
  }
  ASSERT_EQ(reports.size(), 2u);
  for (const auto& report : reports) EXPECT_EQ(report.first, rank);
}

TEST(MpiTransport, OptionsOutOfRangeAreErrors) {
  MpiTransport::Options options;
  options.packetBytes = 10;
  EXPECT_THROW(MpiTransport{options}, Error);
  options = {};
  options.chunkBytes = size_t(1) << 31;
  EXPECT_THROW(MpiTransport{options}, Error);
}

TEST(MpiTransport, TasksRunOnAsManyThreadsAsAskedFor) {
  MpiTransport::Options options;
  options.threads = 3;
  MpiTransport transport(options);
  EXPECT_EQ(transport.threads(), 3);
  // Each waits for the others: it ends only when all three run at once.
  std::atomic<int> running = 0;
  std::promise<void> done;
  for (int i = 0; i < 3; ++i)
    transport.post([&] {
      const int place = ++running;
      while (running < 3) std::this_thread::yield();
      if (place == 3) done.set_value();
    });
  done.get_future().wait();
}

TEST(MpiCompletion, SetsInFlightAreNeverDoneEarlyAndAlwaysReached) {
  constexpr int sets = 50, items = 20;
  MpiTransport transport;
  const int ranks = transport.size(), me = transport.rank();
  Collective collective(transport);
  Completion completion(transport);
  std::atomic<uint64_t> ended = 0;
  std::atomic<int> setsDone = 0;
  std::promise<void> allDone;
  transport.onMessage(Channel::Test, [&](int, Bytes message) {
    Reader reader(message, "item");
    const auto set = reader.read<SetId>();
    const auto hops = reader.read<int32_t>();
    auto active = std::make_shared<Completion::Active>(completion, set);
    transport.post([&, set, hops, active] {
      if (hops > 0) {
        completion.created(set, 1);
        transport.send((me + hops) % ranks, Channel::Test, Writer().write(set).write(hops - 1).take());
      }
      ++ended;
      completion.retired(set, 1);
    });
  });
  for (SetId set = 0; set < sets; ++set) {
    if (me == 0)
      completion.begin(set, [&] {
        if (++setsDone == sets) allDone.set_value();
      });
    for (int i = 0; i < items; ++i) {
      completion.created(set, 1);
      transport.send(i % ranks, Channel::Test, Writer().write(set).write(int32_t(3)).take());
    }
    completion.spawned(set);
  }
  if (me == 0) allDone.get_future().wait();
  collective.broadcast(1, 0, {});
  const auto all = collective.allGather(1, Writer().write(ended.load()).take());
  uint64_t total = 0;
  for (const auto& part : all) total += Reader(part, "count").read<uint64_t>();
  EXPECT_EQ(total, uint64_t(sets) * items * 4 * uint64_t(ranks));
}

TEST(MpiCollective, EachOneBringsWhatWasGiven) {
  MpiTransport transport;
  Collective collective(transport);
  for (uint64_t key = 0; key < 5; ++key) checkCollectives(collective, transport, key);
  checkAgreement(collective, transport, 100);
}

TEST(MpiCollective, RequestsInAnyOrderOnEachRankNeitherMixNorDeadlock) {
  MpiTransport transport;
  Collective collective(transport);
  std::atomic<int> left = 12;
  std::promise<void> done;
  for (uint64_t i = 0; i < 12; ++i)
    transport.postWaiting([&, i] {
      checkCollectives(collective, transport, (i * 5 + uint64_t(transport.rank()) * 7) % 12);
      if (--left == 0) done.set_value();
    });
  done.get_future().wait();
  collective.barrier(50);
}

TEST(MpiTransport, CountsTheRanksOfANodeByTheirRole) {
  const auto numberOf = [](int role) {
    MpiTransport::Options options;
    options.role = role;
    return MpiTransport(options).rankOnNode();
  };
  const int rank = MpiTransport().rank();
  EXPECT_EQ(numberOf(0), rank);
  EXPECT_EQ(numberOf(rank == 1), rank == 1 ? 0 : rank > 1 ? rank - 1 : rank);
}

// Threads that they started would have their low priority.
TEST(MpiTransport, LoopsOfLongTasksRunOnTheirOwnThread) {
  MpiTransport transport;
  std::promise<std::set<std::thread::id>> threads;
  transport.postLong([&] {
    std::mutex mutex;
    std::set<std::thread::id> used;
    parallelFor(0, 10000, [&](int) {
      const std::lock_guard lock(mutex);
      used.insert(std::this_thread::get_id());
    });
    used.insert(std::this_thread::get_id());
    threads.set_value(used);
  });
  const size_t used = threads.get_future().get().size();
#ifdef __SANITIZE_THREAD__  // where loops have threads of their own
  EXPECT_GE(used, 1u);
#else
  EXPECT_EQ(used, 1u);
#endif
}

TEST(MpiWork, CallsBringResultsAndErrorsOfAllRanks) {
  MpiTransport transport;
  Collective collective(transport);
  Work work(transport);
  addWorks(work, transport.rank());
  addCollectiveWork(work, collective);
  for (int r = 0; r < transport.size(); ++r) {
    if (transport.rank() == r) checkWaitingCalls(work, transport.size());
    collective.barrier(1);
  }
}
