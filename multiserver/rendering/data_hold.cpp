// SPDX-License-Identifier: Apache-2.0
#include "multiserver/rendering/data_hold.h"

#include <utility>

namespace gxy {

DataHold dataHold(const ScenePtr& scene, Key key, Generation generation, const std::string& tenant,
                  std::chrono::steady_clock::time_point begin) {
  DataHold hold;
  if (scene) hold.dataset = scene->find(key, generation);
  if (hold.dataset && hold.dataset->owner != tenant)
    hold.tooLong = std::chrono::steady_clock::now() - begin > scene->serverRank.options.longestHold;
  return hold;
}

ScenePtr takeIfShown(ScenePtr& scene, Key key, Generation generation) {
  return scene && scene->find(key, generation) ? std::exchange(scene, nullptr) : nullptr;
}

}  // namespace gxy
