// SPDX-License-Identifier: Apache-2.0
#include "tests/agreement/draw.h"

#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>

#include "core/comm/error.h"

namespace gxy::agreement {

namespace {

/// What a device has answered, on any thread, and how much it has yet to.
class Answers {
 public:
  DeviceScene::Done ask() {
    std::lock_guard lock(mutex_);
    open_++;
    return [this](TraceResult result) {
      std::lock_guard lock(mutex_);
      open_--;
      results_.push_back(std::move(result));
      changed_.notify_one();
    };
  }
  /// The next; none if there is none to come.
  std::optional<TraceResult> next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !results_.empty() || open_ == 0; });
    if (results_.empty()) return {};
    TraceResult result = std::move(results_.front());
    results_.pop_front();
    return result;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<TraceResult> results_;
  size_t open_ = 0;
};

}  // namespace

Picture draw(const Backend& backend, const TestScene& scene, uint32_t frameNumber, int packetRays) {
  const auto compiled = scene.compile();
  const auto device = backend.makeScene(compiled, 0);
  const CompiledFrame frame = compileFrame(*compiled, scene.camera, frameNumber, true);
  const auto deviceFrame = device->makeFrame(frame);
  Framebuffer framebuffer(frame.width, frame.height, frame.samples, true);
  Answers answers;
  for (int sample = 0; sample < frame.samples; sample++)
    for (int y = 0; y < frame.height; y += kTile)
      for (int x = 0; x < frame.width; x += kTile)
        device->spawn(*deviceFrame,
                      {x, y, std::min(x + kTile, frame.width), std::min(y + kTile, frame.height), sample},
                      answers.ask());
  std::string error;
  while (auto result = answers.next()) {
    if (error.empty()) error = result->error;
    framebuffer.add(result->contributions);
    framebuffer.addDepths(result->depths);
    for (LeavingRays& l : result->leaving)
      for (RayList& packet : l.rays.split(packetRays))
        device->trace(*deviceFrame, l.partition, l.primary, std::move(packet), answers.ask());
  }
  if (!error.empty()) throw Error(error);
  return framebuffer.picture(scene.settings);
}

}  // namespace gxy::agreement
