// SPDX-License-Identifier: Apache-2.0
// What a window shows at a pixel.
#pragma once
#include <nlohmann/json.hpp>

#include "multiserver/modules/viewer/window.h"
#include "multiserver/server/session.h"

namespace gxy::viewer {

/// Every rank: its part of a pick.
void registerPick(Registration& registration, Services& services);

/// Sends a ray through the middle of a pixel of what the window shows now, and asks all ranks for the surface where it ends: what
/// docs/protocol.md says of `viewer.pick`. The answer does not depend on how data are cut. Waits. Throws Error.
nlohmann::json pick(Services& services, Request& request, Window& window, glm::ivec2 pixel);

}  // namespace gxy::viewer
