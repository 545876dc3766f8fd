// SPDX-License-Identifier: Apache-2.0
#include "core/comm/thread_pool.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <latch>
#include <thread>

namespace gxy {
namespace {

size_t threadsOfThisProcess() {
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return size_t(std::distance(begin(tasks), end(tasks)));
}

TEST(ThreadPool, RunsAllTasksAtOnceThatWaitForEachOther) {
  constexpr int kTasks = 100;
  std::latch all(kTasks + 1);  // outlives the tasks, as do those below: who waits may look once more
  ThreadPool pool;
  for (int i = 0; i < kTasks; i++) pool.run([&] { all.arrive_and_wait(); });
  all.arrive_and_wait();
}

TEST(ThreadPool, KeepsFewThreadsAfterManyTasksAtOnce) {
  const size_t before = threadsOfThisProcess();
  std::latch bursts[] = {std::latch(101), std::latch(101), std::latch(101)};
  ThreadPool pool;
  for (std::latch& all : bursts) {
    for (int i = 0; i < 100; i++) pool.run([&] { all.arrive_and_wait(); });
    EXPECT_GE(threadsOfThisProcess(), before + 100);
    all.arrive_and_wait();
    while (threadsOfThisProcess() > before + ThreadPool::kKept) std::this_thread::yield();
  }
}

TEST(ThreadPool, OfLowPriorityLeavesTheProcessorsToOthers) {
  const auto niceValue = [] { return getpriority(PRIO_PROCESS, 0); };  // of the thread that asks
  const int own = niceValue();
  std::latch all(9);
  std::atomic<int> ordinary = 0, low = 0;
  const auto count = [&](std::atomic<int>& pool, int expected) {
    if (niceValue() == expected) pool++;
    all.arrive_and_wait();
  };
  ThreadPool first, second(ThreadPool::unlimited, ThreadPool::Priority::Low);
  for (int i = 0; i < 4; i++) {
    first.run([&] { count(ordinary, own); });
    second.run([&] { count(low, std::min(own + ThreadPool::kLower, 19)); });
  }
  all.arrive_and_wait();
  EXPECT_EQ(ordinary, 4);
  EXPECT_EQ(low, 4);
  EXPECT_EQ(niceValue(), own);
}

TEST(ThreadPool, RunsWhatIsQueuedBeforeItEnds) {
  std::atomic<int> ran = 0;
  {
    ThreadPool pool(2);
    for (int i = 0; i < 1000; i++) pool.run([&] { ran++; });
  }
  EXPECT_EQ(ran, 1000);
}

/// While it lives, the system starts no thread of this process: none has room for its stack.
class NoMoreThreads {
 public:
  NoMoreThreads() {
    pthread_getattr_default_np(&before_);
    pthread_attr_t none = before_;
    pthread_attr_setstacksize(&none, size_t(1) << 60);
    pthread_setattr_default_np(&none);
  }
  ~NoMoreThreads() { pthread_setattr_default_np(&before_); }

 private:
  pthread_attr_t before_;
};

TEST(ThreadPool, RunsTasksOnTheThreadsItHasWhereTheSystemGivesNoMore) {
  std::atomic<int> ran = 0;
  std::latch begun(2), release(2);
  {
    ThreadPool pool;
    pool.run([&] {
      begun.arrive_and_wait();
      release.arrive_and_wait();
    });
    begun.arrive_and_wait();
    {
      const NoMoreThreads now;
      EXPECT_ANY_THROW(std::thread([] {}).join());
      for (int i = 0; i < 10; i++) EXPECT_NO_THROW(pool.run([&] { ran++; }));
    }
    release.arrive_and_wait();
  }
  EXPECT_EQ(ran, 10);
}

}  // namespace
}  // namespace gxy
