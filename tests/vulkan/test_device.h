// SPDX-License-Identifier: Apache-2.0
// The device that all tests of the Vulkan backend use: GALAXY_TEST_DEVICE of the build (cmake
// -DGALAXY_TEST_DEVICE=...), a number or a part of a name as --device takes it. It is Mesa's software device
// unless told, on which bits are promised; real GPUs may round divisions otherwise.
#pragma once
#include "backends/vulkan/vulkan_backend.h"

namespace gxy::vulkan_test {

/// Options for it, under the validation layers (core and synchronization, between submissions, too): whatever they say fails the
/// test that runs.
VulkanOptions testDevice();

/// Its backend, made once per program. Throws Error where there is no such device.
const Backend& testedVulkan();

/// What it is, and whether it is software: then its pictures have Embree's bits, the host sees all of its memory, and what is
/// known of Mesa's holds.
const VulkanDeviceInfo& testedInfo();
bool isSoftware();

}  // namespace gxy::vulkan_test
