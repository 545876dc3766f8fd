// SPDX-License-Identifier: Apache-2.0
// Plain threads that run tasks.
#pragma once
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <limits>
#include <list>
#include <mutex>
#include <thread>

namespace gxy {

/// Runs tasks on threads that are made when they are needed; kKept of them stay when idle. At most `limit`
/// tasks run at once, and the others queue. Without a limit no task waits for another one to end, so tasks
/// may wait for each other. If the system gives no more threads, tasks queue without a limit too.
class ThreadPool {
 public:
  static constexpr size_t unlimited = std::numeric_limits<size_t>::max();
  static constexpr size_t kKept = 16;
  /// Added to the nice value of threads of low priority. Such a thread gets a tenth of a processor that it
  /// shares with a thread of normal priority.
  static constexpr int kLower = 10;

  enum class Priority { Normal, Low };

  /// Starts a first thread, so that there always is one. Throws std::system_error if the system gives none.
  /// With Priority::Low, the pool's threads and all threads that tasks start have a lower priority than the
  /// thread that makes the pool.
  explicit ThreadPool(size_t limit = unlimited, Priority priority = Priority::Normal);

  /// Runs all queued tasks and joins the threads.
  ~ThreadPool();

  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  /// Any thread may call it. The task must not throw.
  void run(std::function<void()> task);

 private:
  void serve();

  const size_t limit_;
  const Priority priority_;
  const int nice_;  ///< nice value of threads of low priority
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> queue_;
  std::list<std::thread> threads_;
  std::thread left_;  ///< the thread that ended last, not joined yet
  size_t idle_ = 0;
  bool stopping_ = false;
};

}  // namespace gxy
