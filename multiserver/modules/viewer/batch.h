// SPDX-License-Identifier: Apache-2.0
// Many pictures at once, to files or to the client.
#pragma once
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/scene/scene.h"
#include "multiserver/modules/viewer/window.h"
#include "multiserver/server/session.h"

namespace gxy::viewer {

/// What several pictures of a batch show.
struct BatchScene {
  Visualization visualization;
  RenderSettings settings;
  Annotations annotations;
};

struct BatchPicture {
  size_t scene = 0;  ///< index of BatchRender::scenes
  Camera camera;
  std::string name;  ///< of its file, without the extension
};

struct BatchRender {
  /// The paths that a picture goes to, checked by DataFolders.
  struct Files {
    std::string picture;
    std::string depth;  ///< empty: its depths are not wanted
  };

  std::vector<DatasetSpec> datasets;  ///< of the document
  std::vector<BatchScene> scenes;
  std::vector<BatchPicture> pictures;  ///< in the order in which they are begun
  bool toClient = false;
  std::string format = "png";
  int concurrent = 4;
  /// Scenes are made one after the other, as pictures need them, and each is let go of when those of the next begin; else all are made
  /// before the first picture. Either way they show the data of one moment, but those that are made after an update needed the room of
  /// these show newer ones.
  bool sceneByScene = false;
  /// The files of a picture that shows these data; null: its name in a data folder. The batch's thread calls it.
  std::function<Files(size_t picture, const SceneCache::Pinned& data)> filesOf;
  /// Called when a picture has been made and written, from any thread; may be null.
  std::function<void(size_t picture)> made;
};

/// Adds the datasets of a state, and every visualization with every camera, cameras outermost. Throws Error if there are too many.
void addPictures(BatchRender& batch, const State& state, const std::string& prefix);

/// Reads and makes what the document has and the tenant has not, then renders the pictures; returns their names as `pictures`, `seconds`
/// and `warnings`. Pictures of data that filters make show all data of one moment. Waits; tells the request its progress, and ends when
/// it is cancelled. Nothing is under way any more when it returns or throws. Throws Error.
nlohmann::json renderBatch(Services& services, Request& request, const BatchRender& batch);

}  // namespace gxy::viewer
