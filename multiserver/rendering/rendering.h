// SPDX-License-Identifier: Apache-2.0
// What modules render with: scenes, and the way of pictures to rank 0.
#pragma once
#include <atomic>
#include <cstdint>
#include <memory>

#include "multiserver/rendering/picture_delivery.h"
#include "multiserver/rendering/scene_cache.h"
#include "multiserver/server/module.h"

namespace gxy {

/// One on each rank, for all modules. Thread safe.
struct Rendering {
  explicit Rendering(Registration& registration) : scenes(registration), pictures(registration.node()) {}

  SceneCache scenes;
  PictureDelivery pictures;

  /// Rank 0: a number for frames that come one after the other, as those of a window or a batch (Share::stream).
  uint64_t nextStream() { return streams_++; }

 private:
  std::atomic<uint64_t> streams_ = 1;
};

/// In a module's body, on every rank: the rank's Rendering, which the first module that asks for it registers.
std::shared_ptr<Rendering> renderingOf(Registration& registration);

}  // namespace gxy
