// SPDX-License-Identifier: Apache-2.0
// What a rendering may ask for, and what its description takes.
#pragma once
#include <cstdint>
#include <glm/vec2.hpp>

#include "core/scene/scene.h"

namespace gxy {

/// Throws Error for what would take more of the server than any client may have (docs/protocol.md section 8).
void checkCost(const Visualization& visualization);
void checkCost(const RenderSettings& settings, glm::ivec2 size);

/// Memory that these take, or somewhat less.
int64_t bytesOf(const Visualization& visualization);
int64_t bytesOf(const State& state);

}  // namespace gxy
