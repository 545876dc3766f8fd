// SPDX-License-Identifier: Apache-2.0
// Galaxy as a guest: in a program that has initialised MPI by itself, on communicators that it passes in.
#include <gtest/gtest.h>
#include <mpi.h>

#include <atomic>
#include <future>

#include "core/comm/completion.h"
#include "core/comm/mpi_environment.h"
#include "core/comm/mpi_transport.h"
#include "tests/comm/work_checks.h"

using namespace gxy;

namespace {

int worldRank() {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

int worldSize() {
  int size = 0;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  return size;
}

/// Even and odd ranks of the world, each with as many as there are; ranks of the second half in reverse order.
class Half {
 public:
  Half() : odd_(worldRank() % 2) {
    MPI_Comm_split(MPI_COMM_WORLD, odd_, odd_ ? -worldRank() : worldRank(), &communicator_);
  }
  ~Half() { MPI_Comm_free(&communicator_); }
  Half(const Half&) = delete;
  Half& operator=(const Half&) = delete;

  int odd() const { return odd_; }
  const MPI_Comm& communicator() const { return communicator_; }
  MpiTransport::Options options() const {
    MpiTransport::Options options;
    options.communicator = &communicator_;
    options.threads = 1;
    return options;
  }

 private:
  const int odd_;
  MPI_Comm communicator_ = MPI_COMM_NULL;
};

/// Sets whose items make three hops each, around the ranks; how many items ended on this rank.
uint64_t runSets(MpiTransport& transport, Collective& collective, SetId sets, int items) {
  Completion completion(transport);
  const int ranks = transport.size(), me = transport.rank();
  std::atomic<uint64_t> ended = 0;
  std::atomic<SetId> done = 0;
  std::promise<void> allDone;
  transport.onMessage(Channel::Test, [&](int, Bytes message) {
    Reader reader(message, "item");
    const auto set = reader.read<SetId>();
    const auto hops = reader.read<int32_t>();
    const Completion::Active active(completion, set);
    if (hops > 0) {
      completion.created(set, 1);
      transport.send((me + hops) % ranks, Channel::Test, Writer().write(set).write(hops - 1).take());
    }
    ++ended;
    completion.retired(set, 1);
  });
  for (SetId set = 0; set < sets; ++set) {
    if (me == 0)
      completion.begin(set, [&] {
        if (++done == sets) allDone.set_value();
      });
    for (int i = 0; i < items; ++i) {
      completion.created(set, 1);
      transport.send(i % ranks, Channel::Test, Writer().write(set).write(int32_t(3)).take());
    }
    completion.spawned(set);
  }
  if (me == 0) allDone.get_future().wait();
  collective.barrier(1);
  transport.onMessage(Channel::Test, {});
  return ended;
}

uint64_t sumOver(Collective& collective, uint64_t mine) {
  uint64_t sum = 0;
  for (const auto& part : collective.allGather(2, Writer().write(mine).take()))
    sum += Reader(part, "count").read<uint64_t>();
  return sum;
}

}  // namespace

TEST(PassedInCommunicator, ItsRanksAreTheTransports) {
  const Half half;
  const MpiTransport transport(half.options());
  int rank = -1, size = -1;
  MPI_Comm_rank(half.communicator(), &rank);
  MPI_Comm_size(half.communicator(), &size);
  EXPECT_EQ(transport.rank(), rank);
  EXPECT_EQ(transport.size(), size);
  EXPECT_LT(transport.size(), worldSize());
}

TEST(PassedInCommunicator, TwoHalvesOfTheWorldWorkAtOnceAndApart) {
  const Half half;
  // Each half does what the other does not expect: other numbers of sets and items, other results.
  const SetId sets = half.odd() ? 7 : 40;
  const int items = half.odd() ? 30 : 9;
  MPI_Barrier(MPI_COMM_WORLD);  // both at once
  for (int round = 0; round < 5; ++round) {
    MpiTransport transport(half.options());
    Collective collective(transport);
    const uint64_t ended = runSets(transport, collective, sets, items);
    EXPECT_EQ(sumOver(collective, ended), sets * uint64_t(items) * 4 * uint64_t(transport.size()));
    Work work(transport);
    work.add("half", [&](const Work::Call& call) {
      return nlohmann::json{half.odd(), transport.rank(), call.sender};
    });
    collective.barrier(3);
    const auto results = work.callAll("half", {});
    ASSERT_EQ(results.size(), size_t(transport.size()));
    for (int r = 0; r < transport.size(); ++r)
      EXPECT_EQ(results[size_t(r)], (nlohmann::json{half.odd(), r, transport.rank()}));
    collective.barrier(3);
  }
}

TEST(PassedInCommunicator, AFailureInOneHalfStaysThere) {
  const Half half;
  MpiTransport transport(half.options());
  Collective collective(transport);
  Work work(transport);
  work.add("fails on the odd", [&](const Work::Call&) -> nlohmann::json {
    if (half.odd()) throw Error("odd");
    return 1;
  });
  collective.barrier(1);
  if (half.odd())
    EXPECT_THROW(work.callAll("fails on the odd", {}), Error);
  else
    EXPECT_EQ(work.callAll("fails on the odd", {}).size(), size_t(transport.size()));
  collective.barrier(1);
}

TEST(PassedInCommunicator, TransportsOfTheWorldAndOfAHalfLiveSideBySide) {
  const Half half;
  MpiTransport world, ofHalf(half.options());
  Collective all(world), mine(ofHalf);
  std::promise<uint64_t> inner;
  world.postWaiting([&] { inner.set_value(runSets(ofHalf, mine, 20, 10)); });
  const uint64_t outer = runSets(world, all, 20, 10);
  EXPECT_EQ(sumOver(all, outer), 20u * 10 * 4 * uint64_t(world.size()));
  EXPECT_EQ(sumOver(mine, inner.get_future().get()), 20u * 10 * 4 * uint64_t(ofHalf.size()));
}

// The host's own messages, on the very communicator that Galaxy got, with any source and tag.
TEST(PassedInCommunicator, TheHostsMessagesAndGalaxysDoNotMix) {
  constexpr int rounds = 200;
  const Half half;
  int rank = 0, size = 1;
  MPI_Comm_rank(half.communicator(), &rank);
  MPI_Comm_size(half.communicator(), &size);
  MpiTransport transport(half.options());
  Collective collective(transport);
  std::promise<uint64_t> ended;
  transport.postWaiting([&] { ended.set_value(runSets(transport, collective, 20, 10)); });
  int wrong = 0;
  for (int i = 0; i < rounds; ++i) {
    const int sent = 1000 * rank + i;
    int received = -1;
    MPI_Status status;
    MPI_Sendrecv(&sent, 1, MPI_INT, (rank + 1) % size, 0, &received, 1, MPI_INT, MPI_ANY_SOURCE, MPI_ANY_TAG,
                 half.communicator(), &status);
    wrong += received != 1000 * ((rank + size - 1) % size) + i;
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(sumOver(collective, ended.get_future().get()), 20u * 10 * 4 * uint64_t(size));
}

TEST(PassedInCommunicator, StaysTheHosts) {
  const Half half;
  { MpiTransport transport(half.options()); }
  int size = 0, sum = 0;
  const int one = 1;
  MPI_Comm_size(half.communicator(), &size);
  MPI_Allreduce(&one, &sum, 1, MPI_INT, MPI_SUM, half.communicator());
  EXPECT_EQ(sum, size);
}

int main(int argc, char** argv) {
  int level = 0, finalised = 1;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_MULTIPLE, &level);
  testing::InitGoogleTest(&argc, argv);
  int result = RUN_ALL_TESTS();
  { const MpiEnvironment guest; }
  MPI_Finalized(&finalised);
  if (finalised || level != MPI_THREAD_MULTIPLE) {
    std::fprintf(stderr, "FAILED: MPI, initialised by its host, was %s\n",
                 finalised ? "finalised by Galaxy" : "not started with MPI_THREAD_MULTIPLE");
    result = 1;
  }
  if (!finalised) MPI_Finalize();
  return result;
}
