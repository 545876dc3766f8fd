// SPDX-License-Identifier: Apache-2.0
// The backend that renders a test program's frames. It is Embree, or with `--backend=vulkan` the Vulkan
// backend, on the tests' device (tests/vulkan/test_device.h) and under the validation layers.
#pragma once
#include <glm/vec2.hpp>

#include "core/rays/backend.h"

namespace gxy::test {

/// Each backend is made once per program.
const Backend& embree();
const Backend& testedBackend();

/// The meaning of "the same picture": equal in all bits, or, for a GPU that rounds otherwise, as close as
/// close_pictures.h demands.
enum class Sameness { Bits, Close };
/// The sameness of testedBackend()'s pictures and Embree's: Bits, or Close on a GPU.
Sameness testedSameness();

/// Returns a size for pictures of which a test makes many: `size` on Embree, and a third of it in each
/// direction on Vulkan, whose software device takes far longer.
glm::ivec2 affordable(glm::ivec2 size);

}  // namespace gxy::test
