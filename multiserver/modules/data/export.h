// SPDX-License-Identifier: Apache-2.0
// Verb `export`: a dataset becomes a file.
#pragma once
#include <nlohmann/json.hpp>

#include "multiserver/protocol/statement.h"
#include "multiserver/server/module.h"

namespace gxy {

/// `export NAME FILE`: gathers the newest generation of a dataset on rank 0, which writes the file. Waits. Throws Error; then a file of
/// this name is what it was.
nlohmann::json exportDataset(Request& request, protocol::Arguments arguments);

}  // namespace gxy
