// SPDX-License-Identifier: Apache-2.0
// When the tasks of a Renderer run.
#include "gxy/render/renderer_state.h"

namespace gxy {

void Renderer::post(std::function<void()> task) {
  transport_.post([tasks = tasks_, task = std::move(task)]() mutable { tasks->run(task); });
}

// Runs the task when its turn has come.
void Renderer::post(const Share& share, std::function<void()> task, bool first) {
  ready_.push(share, std::move(task), first);
  startRunner();
}

// Among those of others, if its frame has become one of these meanwhile.
void Renderer::post(const FramePtr& frame, std::function<void()> task, bool first) {
  const Share share = frame->share();
  if (share.interactive)
    task = [this, frame, task = std::move(task)] {
      if (const Share now = frame->share(); now.interactive)
        task();
      else
        post(now, task);
    };
  post(share, std::move(task), first);
}

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

// A runner takes whichever task is next. Where their number is bounded, one that ends makes way for another.
void Renderer::startRunner() {
  if (!begin(runners_, options_.runners)) return;
  post([this] {
    const std::shared_ptr<void> ended(nullptr, [this](void*) {
      runners_--;
      if (options_.runners > 0 && !ready_.empty()) startRunner();
    });
    if (const auto next = ready_.pop()) next();
  });
}

void Renderer::startHandOut() {
  if (!begin(handOuts_, options_.handOuts)) return;
  std::function<void()> task = [this] {
    const std::shared_ptr<void> ended(nullptr, [this](void*) {
      handOuts_--;
      if (options_.handOuts > 0 && !pictures_.empty()) startHandOut();
    });
    if (const auto next = pictures_.pop()) next();
  };
  transport_.postLong([tasks = tasks_, task = std::move(task)]() mutable { tasks->run(task); });
}

}  // namespace gxy
