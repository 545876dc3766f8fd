// SPDX-License-Identifier: Apache-2.0
// Whether pictures let go of their data when an update needs the room.
#pragma once
#include <chrono>
#include <string>

#include "multiserver/rendering/scene_cache.h"

namespace gxy {

/// How a picture under way holds a generation whose room an update needs (ObjectEvent::Kind::Wanted).
struct DataHold {
  const NamedDataset* dataset =
      nullptr;  ///< the dataset of that generation that the picture shows; null: none
  /// The dataset belongs to another tenant, and the picture has been under way for longer than
  /// ServerRankOptions::longestHold. The picture must end now, unfinished.
  bool tooLong = false;
};

/// Rank 0: how a picture of `tenant` that began at `begin` and shows `scene` holds the generation. `scene` may be null.
DataHold dataHold(const ScenePtr& scene, Key key, Generation generation, const std::string& tenant,
                  std::chrono::steady_clock::time_point begin);

/// Rank 0: takes away a scene that is kept for the next picture if it shows the generation. The next picture then shows newer
/// data. Returns the scene, which the caller must destroy without holding locks, or null if it does not show the generation.
ScenePtr takeIfShown(ScenePtr& scene, Key key, Generation generation);

}  // namespace gxy
