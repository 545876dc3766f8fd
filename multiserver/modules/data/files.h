// SPDX-License-Identifier: Apache-2.0
// Verb `files`: what of the data folders can be opened.
#pragma once
#include <nlohmann/json.hpp>

#include "multiserver/server/module.h"

namespace gxy {

/// Verb `files`, on rank 0.
nlohmann::json files(Request& request, protocol::Arguments arguments);

}  // namespace gxy
