// SPDX-License-Identifier: Apache-2.0
// Scheduling of a Renderer's tasks.
#include "core/render/renderer_state.h"

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

void Renderer::post(std::function<void()> task) {
  transport_.post([tasks = tasks_, task = std::move(task)]() mutable { tasks->run(task); });
}

// Queues a task, which runs when its turn comes.
void Renderer::post(const Priority& priority, FrameId frame, std::function<void()> task, bool first) {
  ready_.push(priority, frame, std::move(task), first);
  startRunner();
}

void Renderer::post(const FramePtr& frame, std::function<void()> task, bool first) {
  post(frame->priority(), frame->id, std::move(task), first);
}

void Renderer::runNext(ReadyQueue& queue) {
  const ReadyQueue::Next next = queue.pop();
  if (!next) return;
  const auto begin = options_.processorTime();
  const std::shared_ptr<void> ran(nullptr, [&](void*) { queue.ran(next, options_.processorTime() - begin); });
  next.task();
}

// A runner takes whichever task or tile is next. When it ends it starts another one if there is work.
void Renderer::startRunner() {
  if (!begin(runners_, options_.runners)) return;
  post([this] {
    const std::shared_ptr<void> ended(nullptr, [this](void*) {
      runners_--;
      if (ready_.ready()) startRunner();
    });
    runNext(ready_);
  });
}

void Renderer::startHandOut() {
  if (!begin(handOuts_, options_.handOuts)) return;
  std::function<void()> task = [this] {
    const std::shared_ptr<void> ended(nullptr, [this](void*) {
      handOuts_--;
      if (options_.handOuts > 0 && pictures_.ready()) startHandOut();
    });
    runNext(pictures_);
  };
  transport_.postLong([tasks = tasks_, task = std::move(task)]() mutable { tasks->run(task); });
}

}  // namespace gxy
