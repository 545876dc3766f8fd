// SPDX-License-Identifier: Apache-2.0
// The second backend's pictures against the first's, bit for bit. In builds without Vulkan there is none to compare.
#pragma once
#include "tests/agreement/draw.h"

namespace gxy::agreement {

/// Expects the Vulkan backend, on the tests' device and under the validation layers (core and
/// synchronization), to draw the scene as the first backend has, depths included, and the layers to have said
/// nothing. Where they differ, support/difference.h says where the pictures are.
void expectVulkanDrawsTheSame(const Picture& first, const TestScene& scene, uint32_t frameNumber = 0);

}  // namespace gxy::agreement
