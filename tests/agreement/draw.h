// SPDX-License-Identifier: Apache-2.0
// A picture straight from a backend, without ranks or messages.
#pragma once
#include "core/rays/backend.h"
#include "core/render/framebuffer.h"
#include "tests/agreement/scenes.h"

namespace gxy::agreement {

/// Spawns and traces until no ray is left, in packets of at most `packetRays`. Throws Error where the device fails.
Picture draw(const Backend& backend, const TestScene& scene, uint32_t frameNumber = 0, int packetRays = 1024);

}  // namespace gxy::agreement
