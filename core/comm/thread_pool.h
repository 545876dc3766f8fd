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

/// Runs tasks on threads made when needed, of which kKept stay when idle. Up to `limit` tasks run at once and the others
/// queue; without a limit no task ever waits for another one to end, so tasks may wait for each other: as long as the system
/// gives threads, else tasks queue too.
class ThreadPool {
 public:
  static constexpr size_t unlimited = std::numeric_limits<size_t>::max();
  static constexpr size_t kKept = 16;
  /// Added to the nice value of threads of low priority: beside one that is not, one of them gets a tenth of a processor.
  static constexpr int kLower = 10;

  enum class Priority { Normal, Low };

  /// Starts a first thread, so that there always is one. Throws std::system_error where the system gives none. Low: its
  /// threads, and those that tasks start, leave the processors to those of whoever makes the pool.
  explicit ThreadPool(size_t limit = unlimited, Priority priority = Priority::Normal);

  /// Runs what is queued to its end, and joins.
  ~ThreadPool();

  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  /// Any thread may call it. The task must not throw.
  void run(std::function<void()> task);

 private:
  void serve();

  const size_t limit_;
  const Priority priority_;
  const int nice_;  ///< of threads of low priority
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> queue_;
  std::list<std::thread> threads_;
  std::thread left_;  ///< the one that ended last, not joined yet
  size_t idle_ = 0;
  bool stopping_ = false;
};

}  // namespace gxy
