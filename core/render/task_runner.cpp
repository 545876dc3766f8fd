// SPDX-License-Identifier: Apache-2.0
#include "core/render/task_runner.h"

#include <condition_variable>
#include <mutex>
#include <utility>

namespace gxy {

namespace {

// Counts one more, unless `most` are running (0: no limit). Returns whether it did.
bool begin(std::atomic<int>& running, int most) {
  int now = running;
  do {
    if (most > 0 && now >= most) return false;
  } while (!running.compare_exchange_weak(now, now + 1));
  return true;
}

}  // namespace

/// Lets tasks in until it is closed, and counts those inside. A task may still run when what it was for has
/// been reported, and a device may still be at work; close() waits for both.
class TaskRunner::Gate : public std::enable_shared_from_this<Gate> {
 public:
  void run(Task& task) {
    {
      std::lock_guard lock(mutex_);
      if (closed_) return;
      inside_++;
    }
    const std::shared_ptr<void> leave(nullptr, [&](void*) {
      task = nullptr;  // what the task holds is destroyed while its owner still lives
      left();
    });
    task();
  }
  std::shared_ptr<void> stay() {
    std::lock_guard lock(mutex_);
    inside_++;
    return {this, [self = shared_from_this()](void*) { self->left(); }};
  }
  void close() {
    std::unique_lock lock(mutex_);
    closed_ = true;
    empty_.wait(lock, [this] { return inside_ == 0; });
  }

 private:
  void left() {
    std::lock_guard lock(mutex_);
    if (--inside_ == 0) empty_.notify_all();
  }
  std::mutex mutex_;
  std::condition_variable empty_;
  size_t inside_ = 0;
  bool closed_ = false;
};

TaskRunner::TaskRunner(Transport& transport, Options options)
    : transport_(transport),
      options_(std::move(options)),
      gate_(std::make_shared<Gate>()),
      queue_(options_.queue) {}

void TaskRunner::push(const Priority& priority, uint64_t set, Task task, bool first) {
  queue_.push(priority, set, std::move(task), first);
  start();
}

// A runner takes whichever task or tile is next. When it ends it starts another one if there is work. Without
// a limit there is a runner for each task already.
void TaskRunner::start() {
  if (!begin(running_, options_.most)) return;
  Task runner = [this] {
    const std::shared_ptr<void> ended(nullptr, [this](void*) {
      running_--;
      if (options_.most > 0 && queue_.ready()) start();
    });
    runNext();
  };
  Task inside = [gate = gate_, runner = std::move(runner)]() mutable { gate->run(runner); };
  if (options_.longTasks)
    transport_.postLong(std::move(inside));
  else
    transport_.post(std::move(inside));
}

std::shared_ptr<void> TaskRunner::stay() { return gate_->stay(); }

void TaskRunner::close() { gate_->close(); }

void TaskRunner::runNext() {
  const ReadyQueue::Next next = queue_.pop();
  if (!next) return;
  const auto begin = options_.processorTime();
  const std::shared_ptr<void> ran(nullptr,
                                  [&](void*) { queue_.ran(next, options_.processorTime() - begin); });
  next.task();
}

}  // namespace gxy
