// SPDX-License-Identifier: Apache-2.0
// The software device on which bits are promised, Mesa's lavapipe; real GPUs may round divisions otherwise.
#pragma once
#include <string>
#include <vector>

#include "gxy/vulkan/vulkan_backend.h"

namespace gxy::vulkan_test {

/// Options for it, under the validation layers. Throws where it is not installed.
VulkanOptions softwareDevice();

/// Its backend, made once per program.
const Backend& softwareVulkan();

/// What the validation layers have said of softwareVulkan() since the last call.
std::vector<std::string> newMessages();

}  // namespace gxy::vulkan_test
