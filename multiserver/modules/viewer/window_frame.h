// SPDX-License-Identifier: Apache-2.0
// What a Window keeps of a frame; for its own sources only.
#pragma once
#include "multiserver/modules/viewer/window.h"

namespace gxy::viewer {

/// What a frame that begins now would show.
struct Window::Snapshot {
  State state;
  ShownSoFar shown;
  Camera camera;  ///< of the window's size
  ScenePtr scene;
  ScenePtr edited;  ///< shown before an edit; held until the new scene has taken over what it may
  uint64_t updates = 0;
};

/// One frame: its stages are its levels, then the further passes of the last.
struct Window::Frame {
  uint64_t number = 0;
  FrameOptions options;
  State state;     ///< of one that waits, until it begins
  ScenePtr scene;  ///< none: its data were updated while it waited, so it gets one when it begins
  Camera camera;   ///< of the window's size
  std::vector<Pin> pins;
  Tenants::Frame slot;
  std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();

  size_t level = 0;
  uint32_t pass = 0, passesSent = 0;
  FrameId rendering = 0;
  Picture arrived;  ///< the sums of the pass that was rendered last
  Picture sum;      ///< of all passes; of the stages only
  LedgerEntry sumMemory;
  int samples = 1;  ///< of each pass
  Background background{glm::dvec4(0)};
  const char* over = nullptr;  ///< "superseded", "cancelled", or "failed" because of `why`
  std::string why;             ///< it is to be refined no further: it ends with its first whole picture
  bool dropped = false;        ///< a tile found no room

  bool whole() const { return passesSent > 0; }  ///< there is a picture of all pixels, and it is only refined
  bool last() const { return level + 1 == options.levels.size(); }
  /// That it shows, by name; of one that has not begun, none.
  nlohmann::json generations() const {
    nlohmann::json shown = nlohmann::json::object();
    if (scene)
      for (const NamedDataset& d : scene->data) shown[d.name] = d.generation;
    return shown;
  }
  protocol::PixelHeader header(uint32_t window) const {
    protocol::PixelHeader h;
    h.window = window;
    h.frame = number;
    h.scale = options.levels[level];
    h.pass = pass;
    h.width = (uint32_t(camera.dimensions.x) + h.scale - 1) / h.scale;
    h.height = (uint32_t(camera.dimensions.y) + h.scale - 1) / h.scale;
    return h;
  }
};

}  // namespace gxy::viewer
