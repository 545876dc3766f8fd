// SPDX-License-Identifier: Apache-2.0
#include "core/comm/thread_pool.h"

#include <sys/resource.h>

#include <algorithm>
#include <system_error>
#include <utility>

namespace gxy {

ThreadPool::ThreadPool(size_t limit, Priority priority)
    : limit_(limit), priority_(priority), nice_(std::min(getpriority(PRIO_PROCESS, 0) + kLower, 19)) {
  std::lock_guard lock(mutex_);
  threads_.emplace_back([this] { serve(); });
}

ThreadPool::~ThreadPool() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  std::unique_lock lock(mutex_);
  while (!threads_.empty()) {
    std::thread thread = std::move(threads_.front());
    threads_.pop_front();
    lock.unlock();
    thread.join();
    lock.lock();
  }
  if (left_.joinable()) left_.join();
}

void ThreadPool::run(std::function<void()> task) {
  std::lock_guard lock(mutex_);
  queue_.push_back(std::move(task));
  if (idle_ < queue_.size() && threads_.size() < limit_) {
    try {
      threads_.emplace_back([this] { serve(); });
    } catch (const std::system_error&) {  // No more threads: an existing one will run the task.
    }
  }
  changed_.notify_one();
}

void ThreadPool::serve() {
  if (priority_ == Priority::Low) setpriority(PRIO_PROCESS, 0, nice_);  // on Linux: of this thread only
  std::thread before;
  {
    std::unique_lock lock(mutex_);
    while (stopping_ || !queue_.empty() || idle_ < kKept) {
      ++idle_;
      changed_.wait(lock, [this] { return stopping_ || !queue_.empty(); });
      --idle_;
      if (queue_.empty()) return;
      auto task = std::move(queue_.front());
      queue_.pop_front();
      lock.unlock();
      task();
      task = nullptr;
      lock.lock();
    }
    const auto own = std::find_if(threads_.begin(), threads_.end(),
                                  [](const auto& t) { return t.get_id() == std::this_thread::get_id(); });
    before = std::exchange(left_, std::move(*own));
    threads_.erase(own);
  }
  if (before.joinable()) before.join();
}

}  // namespace gxy
