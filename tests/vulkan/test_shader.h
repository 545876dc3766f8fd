// SPDX-License-Identifier: Apache-2.0
// A shader of a test's own, with the backend's layout of bindings and constants.
#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "backends/vulkan/pipelines.h"

namespace gxy::vulkan_test {

/// Compiled once; `device` and `pipelines` outlive it.
class TestShader {
 public:
  TestShader(const vulkan::Device& device, const vulkan::Pipelines& pipelines,
             std::span<const uint32_t> spirv, const vulkan::Special& special = {});

  /// Runs so many workgroups and returns when they have ended. `scene` is SCENE_SET, `frame` FRAME_SET, null where the shader
  /// reads none; `buffers`, at most LANE_BINDINGS, are bound in order from 0 of LANE_SET; `count` is push[0].
  void run(VkDescriptorSet scene, std::span<const vulkan::Buffer> buffers, int32_t count,
           std::array<uint32_t, 2> groups, VkDescriptorSet frame = VK_NULL_HANDLE) const;

 private:
  const vulkan::Device& device_;
  const vulkan::Pipelines& pipelines_;
  vulkan::PipelineHandle pipeline_;
};

}  // namespace gxy::vulkan_test
