// SPDX-License-Identifier: Apache-2.0
// What an import has counted in a mesh, by name.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "core/data/mesh.h"

namespace gxy {

/// Returns the cells of each type and what is remarkable, with the names that users see, without counts that are 0.
std::vector<std::pair<const char*, uint64_t>> namedCounts(const MeshReport& report);

}  // namespace gxy
