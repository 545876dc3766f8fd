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

/// Whether the tested backend is Embree.
bool onReference();

/// What the commit decides (`--seed=N`; 1 unless told), for what CI takes a part of.
uint64_t seedOfTheCommit();

/// Whether all is to be tested that CI takes a part of (`--all`).
bool allIsAsked();

/// Returns how many schedules or rounds a test makes: `many` on Embree, which is fast, and a tenth of them (two at least) on
/// Vulkan: how frames come to their end is the same on every backend. All of them with `--all`.
int affordable(int many);

/// Returns a size for pictures of which a test makes many: `size` on Embree, and a third of it in each
/// direction on Vulkan, whose software device takes far longer.
glm::ivec2 affordable(glm::ivec2 size);

}  // namespace gxy::test
