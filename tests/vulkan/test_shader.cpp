// SPDX-License-Identifier: Apache-2.0
#include "tests/vulkan/test_shader.h"

#include <algorithm>

#include "shaders/layout.h"

namespace gxy::vulkan_test {

using namespace vulkan;

TestShader::TestShader(const Device& device, const Pipelines& pipelines, std::span<const uint32_t> spirv,
                       const Special& wanted)
    : device_(device), pipelines_(pipelines) {
  Special special = wanted;
  special.roundsRight = device.roundsRight();
  VkShaderModuleCreateInfo moduleInfo{};
  moduleInfo.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
  moduleInfo.codeSize = spirv.size_bytes();
  moduleInfo.pCode = spirv.data();
  VkShaderModule module = VK_NULL_HANDLE;
  check(vkCreateShaderModule(device.get(), &moduleInfo, nullptr, &module), "loading the shader");
  const ShaderHandle ownModule(device.get(), module);
  std::array<VkSpecializationMapEntry, sizeof(Special) / 4> entries;
  for (uint32_t i = 0; i < entries.size(); i++) entries[i] = {i, 4 * i, 4};
  const VkSpecializationInfo constants{uint32_t(entries.size()), entries.data(), sizeof(Special), &special};
  VkComputePipelineCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  info.stage.pSpecializationInfo = &constants;
  info.layout = pipelines.layout();
  VkPipeline pipeline = VK_NULL_HANDLE;
  check(vkCreateComputePipelines(device.get(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
        "compiling the shader");
  pipeline_ = PipelineHandle(device.get(), pipeline);
}

void TestShader::run(VkDescriptorSet scene, std::span<const Buffer> buffers, int32_t count,
                     std::array<uint32_t, 2> groups, VkDescriptorSet frame) const {
  std::array<Binding, LANE_BINDINGS> bindings;  // those without a buffer have the last one
  for (size_t i = 0; i < bindings.size(); i++) {
    const Buffer& buffer = buffers[std::min(i, buffers.size() - 1)];
    bindings[i].buffer = {buffer.get(), 0, buffer.bytes()};
    if (i == RAY_WORDS_BINDING || i == TILES_BINDING) bindings[i].texels = VK_FORMAT_R32_UINT;
  }
  const DescriptorSet lane(device_, pipelines_.setLayout(LANE_SET), bindings);
  Commands commands(device_);
  const VkCommandBuffer c = commands.begin();
  vkCmdBindPipeline(c, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
  const auto bind = [&](uint32_t number, VkDescriptorSet set) {
    vkCmdBindDescriptorSets(c, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.layout(), number, 1, &set, 0,
                            nullptr);
  };
  if (scene) bind(SCENE_SET, scene);
  if (frame) bind(FRAME_SET, frame);
  bind(LANE_SET, lane.get());
  vkCmdPushConstants(c, pipelines_.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof count, &count);
  vkCmdDispatch(c, groups[0], groups[1], 1);
  commands.barrier();
  commands.submit();
  commands.wait();
}

}  // namespace gxy::vulkan_test
