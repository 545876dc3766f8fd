// SPDX-License-Identifier: Apache-2.0
// A picture that is made to be saved, while the user goes on in another window of the server.
#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>

#include "core/scene/scene.h"
#include "multiserver/client/client.h"
#include "tools/gxyviewer/canvas.h"

namespace gxy {

/// One frame of a window that shows nothing else: without loss, at full resolution, in passes of a ray per pixel. Thread safe,
/// but for the canvas, which is still once the frame has ended.
class Still {
 public:
  /// Asks for it; waits for nothing. `state` has one visualization and one camera, whose dimensions are the picture's; `window`
  /// is one that the client does not use.
  static std::shared_ptr<Still> begin(Client& client, uint32_t window, const State& state, uint32_t passes);

  /// Pixels that come for its window.
  void take(const protocol::PixelHeader& header, std::span<const std::byte> data);

  struct Progress {
    uint32_t passes = 0;  ///< that have come
    bool ended = false;
    std::string error;                            ///< why there is no whole picture, if it has ended so
    std::map<std::string, uint64_t> generations;  ///< that it shows, once it has ended
  };
  Progress progress() const;
  const Canvas& canvas() const { return canvas_; }

 private:
  explicit Still(glm::ivec2 size) : canvas_(size) {}
  void end(const std::string& error);

  mutable std::mutex mutex_;
  Canvas canvas_;
  Progress progress_;
};

}  // namespace gxy
