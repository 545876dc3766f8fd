// SPDX-License-Identifier: Apache-2.0
// A picture that is rendered for saving, in a window of its own on the server, while the user goes on working.
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

/// One lossless frame at full resolution, in passes of one ray per pixel. Thread safe, except canvas(), which
/// may be used only after the frame has ended.
class Still {
 public:
  /// Sends the requests and does not wait. `state` has one visualization and one camera, whose dimensions are
  /// the picture's. `window` is the number of a window that the client does not use.
  static std::shared_ptr<Still> begin(Client& client, uint32_t window, const State& state, uint32_t passes);

  /// Takes pixels for its window.
  void take(const protocol::PixelHeader& header, std::span<const std::byte> data);

  struct Progress {
    uint32_t passes = 0;  ///< number of passes that have come
    bool ended = false;
    std::string error;                            ///< the reason why it has ended without a whole picture
    std::map<std::string, uint64_t> generations;  ///< of the data that it shows, once it has ended
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
