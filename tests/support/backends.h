// SPDX-License-Identifier: Apache-2.0
// The backend that a test program's frames are rendered on: Embree, or with `--backend=vulkan` the Vulkan
// backend, on the tests' device (vulkan/test_device.h) and under the validation layers.
#pragma once
#include <glm/vec2.hpp>

#include "core/rays/backend.h"

namespace gxy::test {

/// Each is made once per program.
const Backend& embree();
const Backend& testedBackend();

/// What pictures must have in common to be called the same: all bits; or what is left where a GPU rounds otherwise
/// (close_pictures.h).
enum class Sameness { Bits, Close };
/// Of testedBackend()'s pictures with Embree's: bits, but of a GPU.
Sameness testedSameness();

/// A size of pictures of which a test makes many: `size` on Embree, less on Vulkan, whose software device
/// takes far longer.
glm::ivec2 affordable(glm::ivec2 size);

}  // namespace gxy::test
