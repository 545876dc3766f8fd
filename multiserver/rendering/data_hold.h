// SPDX-License-Identifier: Apache-2.0
// Pictures whose data have to make room for an update.
#pragma once
#include <chrono>
#include <string>

#include "multiserver/rendering/scene_cache.h"

namespace gxy {

/// What a picture under way means for an update that needs the room of a generation (ObjectEvent::Kind::Wanted).
struct DataHold {
  const NamedDataset* dataset =
      nullptr;  ///< of that generation, which the picture shows; null: it shows none
  /// The dataset is another tenant's, and the picture has been under way for longer than NodeOptions::longestHold: it is to end
  /// without having been finished.
  bool tooLong = false;
};

/// Rank 0: that of a picture of `tenant` that began at `begin` and shows `scene`, which may be null.
DataHold dataHold(const ScenePtr& scene, Key key, Generation generation, const std::string& tenant,
                  std::chrono::steady_clock::time_point begin);

/// Rank 0: takes a scene that is kept for the next picture, if it shows the generation, so that the next picture shows newer data.
/// The caller lets go of what is returned without holding locks; null: the scene stays.
ScenePtr takeIfShown(ScenePtr& scene, Key key, Generation generation);

}  // namespace gxy
