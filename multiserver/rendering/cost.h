// SPDX-License-Identifier: Apache-2.0
// Limits on what a client may ask to be rendered, and the memory that its description takes.
#pragma once
#include <cstdint>
#include <glm/vec2.hpp>

#include "core/scene/scene.h"

namespace gxy {

/// These throw Error if rendering it would take more of the server than any client may have (docs/protocol.md, section 8).
/// `size` is in pixels.
void checkCost(const Visualization& visualization);
void checkCost(const RenderSettings& settings, glm::ivec2 size);
/// The same for the number of operators of a visualization.
void checkOperators(size_t count);

/// Bytes that these take in memory, or somewhat less.
int64_t bytesOf(const Visualization& visualization);
int64_t bytesOf(const State& state);

}  // namespace gxy
