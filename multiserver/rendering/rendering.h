// SPDX-License-Identifier: Apache-2.0
// What modules render with: the cache of scenes and the delivery of pictures.
#pragma once
#include <atomic>
#include <cstdint>
#include <memory>

#include "multiserver/rendering/picture_delivery.h"
#include "multiserver/rendering/scene_cache.h"
#include "multiserver/server/module.h"

namespace gxy {

/// There is one on each rank, for all modules. Thread safe.
struct Rendering {
  explicit Rendering(Registration& registration)
      : scenes(registration), pictures(registration.serverRank()) {}

  SceneCache scenes;
  PictureDelivery pictures;

  /// Rank 0: returns a new number for a stream of frames, for instance those of a window or of a batch (Priority::stream).
  uint64_t nextStream() { return streams_++; }

 private:
  std::atomic<uint64_t> streams_ = 1;
};

/// Returns the rank's Rendering. Called in a module's body, on every rank. The first module that calls it registers the works.
std::shared_ptr<Rendering> renderingOf(Registration& registration);

}  // namespace gxy
