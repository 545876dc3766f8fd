// SPDX-License-Identifier: Apache-2.0
// When the tasks of a Renderer run.
#include "core/render/renderer_state.h"

namespace gxy {

namespace {

// One more, unless there are as many as there may be; 0: any number.
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

// Runs the task when its turn has come.
void Renderer::post(const Share& share, FrameId frame, std::function<void()> task, bool first) {
  ready_.push(share, frame, std::move(task), first);
  startRunner();
}

void Renderer::post(const FramePtr& frame, std::function<void()> task, bool first) {
  post(frame->share(), frame->id, std::move(task), first);
}

void Renderer::runNext(ReadyQueue& queue) {
  const ReadyQueue::Next next = queue.pop();
  if (!next) return;
  const auto begin = options_.processorTime();
  const std::shared_ptr<void> ran(nullptr, [&](void*) { queue.ran(next, options_.processorTime() - begin); });
  next.task();
}

// A runner takes whichever task or tile is next. One that ends makes way for another.
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
