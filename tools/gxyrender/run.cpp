// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyrender/run.h"

#include <condition_variable>
#include <mutex>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/error_text.h"

namespace gxy {

std::string textOfRoot(Collective& collective, bool root, const std::function<std::string()>& make) {
  std::string said;
  if (root) {
    try {
      said = " " + make();
    } catch (const std::exception& e) {
      said = "!" + textOf(e);
    }
  }
  const auto* begin = reinterpret_cast<const std::byte*>(said.data());
  const Bytes heard = collective.broadcast(kRunKey, 0, Bytes(begin, begin + said.size()));
  const std::string text(reinterpret_cast<const char*>(heard.data()), heard.size());
  if (text.at(0) == '!') throw Error(text.substr(1));
  return text.substr(1);
}

void renderFrames(const Frames& frames, Renderer& renderer, const Place& at) {
  std::mutex mutex;
  std::condition_variable changed;
  int inFlight = 0;
  size_t done = 0;
  std::string ending;                // the first error of a frame, on the root
  std::optional<std::string> error;  // of a picture, on this rank
  renderer.onPicture([&](FrameId id, const FrameRequest& request, Picture picture) {
    std::optional<std::string> failed;
    try {
      frames.take(size_t(id - frames.before - 1), request, std::move(picture));
    } catch (const std::exception& e) {
      failed = textOf(e);
    }
    const std::lock_guard lock(mutex);
    if (!error) error = failed;
  });
  for (size_t i = 0; at.root && i < frames.count; i++) {
    {
      std::unique_lock lock(mutex);
      changed.wait(lock, [&] { return inFlight < frames.concurrent; });
      inFlight++;
    }
    const auto ended = [&](const std::string& text) {
      const std::lock_guard lock(mutex);
      if (ending.empty()) ending = text;
      inFlight--;
      frames.show(++done);
      changed.notify_all();
    };
    try {
      renderer.render(frames.request(i), [ended](FrameId, const Renderer::Ending& e) { ended(e.error); });
    } catch (const std::exception& e) {
      ended(textOf(e));
    }
  }
  if (at.root) {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return done == frames.count; });
  }
  at.collective.barrier(kRunKey);
  renderer.onPicture({});
  const std::lock_guard lock(mutex);
  at.collective.agree(kRunKey, error);
  // It names the rank where a frame failed, so it is told as it is.
  textOfRoot(at.collective, at.root, [&] {
    if (!ending.empty()) throw Error(ending);
    return std::string();
  });
}

}  // namespace gxy
