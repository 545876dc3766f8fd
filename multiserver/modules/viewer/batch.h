// SPDX-License-Identifier: Apache-2.0
// Many pictures at once, to files or to the client.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "core/scene/scene.h"
#include "multiserver/modules/viewer/window.h"
#include "multiserver/server/session.h"

namespace gxy::viewer {

struct BatchRender {
  State state;
  bool toClient = false;
  std::string prefix = "picture", format = "png";
  int concurrent = 4;
};

/// Reads and makes what the document has and the tenant has not, then renders every visualization with every camera, cameras
/// outermost; returns `pictures`, `seconds` and `warnings`. Pictures of data that filters make show all data of one moment. Waits; tells
/// the request its progress, and ends when it is cancelled. Throws Error.
nlohmann::json renderBatch(Services& services, Request& request, const BatchRender& batch);

}  // namespace gxy::viewer
