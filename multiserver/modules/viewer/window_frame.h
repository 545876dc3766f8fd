// SPDX-License-Identifier: Apache-2.0
// The state of one frame of a Window. Only the sources of Window include this.
#pragma once
#include "multiserver/modules/viewer/window.h"

namespace gxy::viewer {

/// The state of the window when a frame was asked for.
struct Window::Snapshot {
  State state;
  ShownSoFar shown;
  Camera camera;  ///< of the window's size
  ScenePtr scene;
  ScenePtr edited;       ///< the scene before an edit, held until the new scene has taken over what it can
  uint64_t updates = 0;  ///< Window::updates_
  bool ofGraph = false;  ///< `content` says what is shown
  ViewContent content;

  /// The data that the operators have; null: those of their names.
  const SceneCache::GivenData* given() const { return ofGraph ? &content.data : nullptr; }
};

/// One frame: its stages are its levels, then the further passes of the last.
struct Window::Frame {
  uint64_t number = 0;
  FrameOptions options;
  State state;     ///< what a frame that waits is to show; empty once it has begun
  ScenePtr scene;  ///< null: the data changed while the frame waited, and it gets a scene when it begins
  Camera camera;   ///< of the window's size
  std::vector<Pin> pins;
  SceneCache::GivenData given;  ///< keeps the data of a view of a graph
  uint64_t revision = 0;        ///< of the graph's document; 0: none is shown
  Tenants::RenderSlot slot;
  std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();

  size_t level = 0;
  uint32_t pass = 0, passesSent = 0;
  FrameId rendering = 0;
  Picture arrived;  ///< the sums of the pass that was rendered last
  Picture sum;      ///< the sums of all passes; used by one stage at a time
  LedgerEntry sumMemory;
  int samples = 1;  ///< of each pass
  Background background{glm::dvec4(0)};
  const char* over = nullptr;  ///< "superseded", "cancelled", or "failed" because of `why`
  std::string why;       ///< not empty: the frame ends with its first picture of all pixels, for this reason
  bool dropped = false;  ///< the outbox had no room for a tile

  /// The client has been sent a picture of all pixels, which further passes refine.
  bool whole() const { return passesSent > 0; }
  bool last() const { return level + 1 == options.levels.size(); }
  /// The generations that the frame shows, by name; none if it has no scene.
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
