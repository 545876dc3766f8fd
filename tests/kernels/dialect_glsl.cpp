// SPDX-License-Identifier: Apache-2.0
// One text, the same bits: probe.h in C++ against GLSL on lavapipe.
#include <gtest/gtest.h>

#include <cstring>

#include "dialect.h"
#include "dialect_probe.h"
#include "gxy/vulkan/pipelines.h"
#include "vulkan/software_device.h"

namespace gxy {
namespace {

using namespace vulkan;

constexpr int kProbes = 32;

std::vector<float> probesInGlsl() {
  const Device device(vulkan_test::softwareDevice());
  const VkDevice d = device.get();
  const Buffer out(device, size_t(kProbes) * kProbeInputs * sizeof(float), Place::Readback, "probes");

  const VkDescriptorSetLayoutBinding binding{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1,
                                             VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
  VkDescriptorSetLayoutCreateInfo setInfo{};
  setInfo.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
  setInfo.bindingCount = 1;
  setInfo.pBindings = &binding;
  VkDescriptorSetLayout setLayout = VK_NULL_HANDLE;
  check(vkCreateDescriptorSetLayout(d, &setInfo, nullptr, &setLayout), "describing buffers");
  const SetLayoutHandle ownSetLayout(d, setLayout);
  const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, 4};
  VkPipelineLayoutCreateInfo layoutInfo{};
  layoutInfo.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
  layoutInfo.setLayoutCount = 1;
  layoutInfo.pSetLayouts = &setLayout;
  layoutInfo.pushConstantRangeCount = 1;
  layoutInfo.pPushConstantRanges = &push;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  check(vkCreatePipelineLayout(d, &layoutInfo, nullptr, &layout), "making a layout");
  const PipelineLayoutHandle ownLayout(d, layout);

  VkShaderModuleCreateInfo moduleInfo{};
  moduleInfo.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
  moduleInfo.codeSize = sizeof dialect_spirv;
  moduleInfo.pCode = dialect_spirv;
  VkShaderModule module = VK_NULL_HANDLE;
  check(vkCreateShaderModule(d, &moduleInfo, nullptr, &module), "loading the shader");
  const ShaderHandle ownModule(d, module);
  VkComputePipelineCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  info.layout = layout;
  VkPipeline pipeline = VK_NULL_HANDLE;
  check(vkCreateComputePipelines(d, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline), "compiling the shader");
  const PipelineHandle ownPipeline(d, pipeline);

  const Binding buffer{{out.get(), 0, VK_WHOLE_SIZE}};
  const DescriptorSet descriptors(device, setLayout, std::span(&buffer, 1));
  const VkDescriptorSet set = descriptors.get();
  Commands commands(device);
  const VkCommandBuffer c = commands.begin();
  const int count = kProbeInputs;
  vkCmdBindPipeline(c, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
  vkCmdBindDescriptorSets(c, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, nullptr);
  vkCmdPushConstants(c, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, 4, &count);
  vkCmdDispatch(c, (kProbeInputs + 63) / 64, 1, 1);
  commands.barrier();
  commands.submit();
  commands.wait();
  std::vector<float> results(size_t(kProbes) * kProbeInputs);
  std::memcpy(results.data(), out.mapped(), results.size() * sizeof(float));
  EXPECT_EQ(device.instance().messages(), std::vector<std::string>());
  return results;
}

TEST(Dialect, GlslHasTheBitsOfCpp) { expectSameProbes(probesInCpp(), probesInGlsl()); }

}  // namespace
}  // namespace gxy
