// SPDX-License-Identifier: Apache-2.0
// The verb `cinema`: databases of the pictures of a sweep.
#pragma once
#include <nlohmann/json.hpp>
#include <string_view>

#include "multiserver/modules/viewer/window.h"
#include "multiserver/server/session.h"

namespace gxy::viewer {

/// Makes a Cinema database in a data folder, or adds to it, as docs/protocol.md says. Waits; tells the request its progress, and ends
/// when it is cancelled; the database then has what was made until then. Throws Error.
nlohmann::json cinema(Services& services, Request& request, std::string_view document);

}  // namespace gxy::viewer
