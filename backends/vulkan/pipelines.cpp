// SPDX-License-Identifier: Apache-2.0
#include "backends/vulkan/pipelines.h"

#include <algorithm>
#include <vector>

#include "begin_spirv.h"
#include "bound_spirv.h"
#include "depth_spirv.h"
#include "finish_spirv.h"
#include "geometry_spirv.h"
#include "groups_spirv.h"
#include "integrate_mesh_spirv.h"
#include "integrate_spirv.h"
#include "integrate_volumes_spirv.h"
#include "isosurfaces_spirv.h"
#include "regenerate_spirv.h"
#include "sample_spirv.h"
#include "shade_spirv.h"
#include "shaders/layout.h"
#include "slices_spirv.h"
#include "spawn_spirv.h"
#include "take_spirv.h"

namespace gxy::vulkan {

namespace {

std::span<const uint32_t> codeOf(Stage stage) {
  switch (stage) {
    case Stage::Spawn:
      return spawn_spirv;
    case Stage::Begin:
      return begin_spirv;
    case Stage::Regenerate:
      return regenerate_spirv;
    case Stage::Bound:
      return bound_spirv;
    case Stage::Geometry:
      return geometry_spirv;
    case Stage::Slices:
      return slices_spirv;
    case Stage::Isosurfaces:
      return isosurfaces_spirv;
    case Stage::Integrate:
      return integrate_spirv;
    case Stage::IntegrateVolumes:
      return integrate_volumes_spirv;
    case Stage::IntegrateMesh:
      return integrate_mesh_spirv;
    case Stage::Shade:
      return shade_spirv;
    case Stage::Sample:
      return sample_spirv;
    case Stage::Depth:
      return depth_spirv;
    case Stage::Finish:
      return finish_spirv;
    case Stage::Take:
      return take_spirv;
    default:
      return groups_spirv;
  }
}

// Keeps only the constants that a stage reads, so that scenes share pipelines that are the same for them.
Special specialFor(Stage stage, const Special& special) {
  Special s;
  s.addressed = special.addressed;
  s.limited = special.limited;
  const bool reads = stage == Stage::Slices || stage == Stage::Isosurfaces || stage == Stage::Integrate ||
                     stage == Stage::IntegrateVolumes || stage == Stage::Sample ||
                     (stage == Stage::Shade && (special.surfaces & SURFACE_FIELDS) != 0);
  if (reads) s.sampleKind = special.sampleKind, s.scalars = special.scalars;
  if (stage == Stage::Integrate || stage == Stage::IntegrateVolumes || stage == Stage::IntegrateMesh ||
      stage == Stage::Shade)
    s.mapKind = special.mapKind;
  if (reads || stage == Stage::IntegrateMesh || stage == Stage::Geometry || stage == Stage::Shade ||
      stage == Stage::Finish)
    s.operators = special.operators;
  if (stage == Stage::Spawn || stage == Stage::Begin || stage == Stage::Integrate || stage == Stage::Shade)
    s.routes = special.routes | ROUTE_ON;
  if (stage == Stage::Finish) s.routes = special.routes, s.surfaces = special.surfaces & SURFACE_SAMPLED;
  if (stage == Stage::Geometry) s.routes = special.routes & ROUTE_ON;
  if (stage == Stage::Shade || stage == Stage::Geometry) s.surfaces = special.surfaces;
  if (stage == Stage::Isosurfaces) s.surfaces = special.surfaces & SURFACE_STARTS;
  if (stage == Stage::IntegrateMesh) s.surfaces = special.surfaces & SURFACE_HEXES;
  if (stage == Stage::Geometry || stage == Stage::Isosurfaces) s.anyHit = special.anyHit;
  if (stage == Stage::Integrate || stage == Stage::IntegrateMesh) s.mapAhead = special.mapAhead;
  if (stage == Stage::Integrate || stage == Stage::IntegrateVolumes) s.byCells = special.byCells;
  return s;
}

VkDescriptorType typeOf(bool texels) {
  return texels ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

SetLayoutHandle makeSetLayout(const Device& device, uint32_t set, uint32_t bindings) {
  std::vector<VkDescriptorSetLayoutBinding> all(bindings);
  for (uint32_t i = 0; i < bindings; i++) {
    const bool texels =
        (set == SCENE_SET && ((i >= TABLES_BINDING && i <= GEOMETRY_BINDING) || i == TABLE_QUADS_BINDING ||
                              i == GEOMETRY_QUADS_BINDING || i == SAMPLE_QUADS_BINDING)) ||
        (set == LANE_SET && (i == RAY_WORDS_BINDING || i == TILES_BINDING));
    all[i] = {i, typeOf(texels), 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
  }
  VkDescriptorSetLayoutCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
  info.bindingCount = bindings;
  info.pBindings = all.data();
  VkDescriptorSetLayout layout = VK_NULL_HANDLE;
  check(vkCreateDescriptorSetLayout(device.get(), &info, nullptr, &layout), "describing buffers");
  return {device.get(), layout};
}

}  // namespace

DescriptorSet::DescriptorSet(const Device& device, VkDescriptorSetLayout layout,
                             std::span<const Binding> bindings) {
  const auto count = [&](bool texels) {
    return uint32_t(std::count_if(bindings.begin(), bindings.end(), [&](const Binding& b) {
      return (b.texels != VK_FORMAT_UNDEFINED) == texels;
    }));
  };
  const VkDescriptorPoolSize sizes[] = {{typeOf(false), count(false)}, {typeOf(true), count(true)}};
  VkDescriptorPoolCreateInfo pool{};
  pool.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
  pool.maxSets = 1;
  pool.poolSizeCount = count(true) > 0 ? 2 : 1;
  pool.pPoolSizes = sizes;
  VkDescriptorPool made = VK_NULL_HANDLE;
  check(vkCreateDescriptorPool(device.get(), &pool, nullptr, &made), "making room for descriptors");
  pool_ = DescriptorPoolHandle(device.get(), made);
  VkDescriptorSetAllocateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
  info.descriptorPool = made;
  info.descriptorSetCount = 1;
  info.pSetLayouts = &layout;
  check(vkAllocateDescriptorSets(device.get(), &info, &set_), "making descriptors");
  std::vector<VkWriteDescriptorSet> writes(bindings.size());
  std::vector<VkBufferView> views(bindings.size(), VK_NULL_HANDLE);
  for (size_t i = 0; i < bindings.size(); i++) {
    const bool texels = bindings[i].texels != VK_FORMAT_UNDEFINED;
    if (texels) {
      const VkDeviceSize each = bindings[i].texels == VK_FORMAT_R32_UINT ? 4 : 16;
      VkBufferViewCreateInfo view{};
      view.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO;
      view.buffer = bindings[i].buffer.buffer;
      view.format = bindings[i].texels;
      view.offset = bindings[i].buffer.offset;
      view.range = bindings[i].buffer.range / each * each;
      check(vkCreateBufferView(device.get(), &view, nullptr, &views[i]), "making a view of a buffer");
      views_.emplace_back(device.get(), views[i]);
    }
    writes[i].sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    writes[i].dstSet = set_;
    writes[i].dstBinding = uint32_t(i);
    writes[i].descriptorCount = 1;
    writes[i].descriptorType = typeOf(texels);
    writes[i].pBufferInfo = &bindings[i].buffer;
    writes[i].pTexelBufferView = &views[i];
  }
  vkUpdateDescriptorSets(device.get(), uint32_t(writes.size()), writes.data(), 0, nullptr);
}

Pipelines::Pipelines(const Device& device, size_t most)
    : device_(device),
      most_(most),
      sets_{makeSetLayout(device, SCENE_SET, SCENE_BINDINGS),
            makeSetLayout(device, FRAME_SET, FRAME_BINDINGS),
            makeSetLayout(device, LANE_SET, LANE_BINDINGS)} {
  const VkDescriptorSetLayout sets[3] = {setLayout(0), setLayout(1), setLayout(2)};
  const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, PUSH_WORDS * sizeof(int32_t)};
  VkPipelineLayoutCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
  info.setLayoutCount = 3;
  info.pSetLayouts = sets;
  info.pushConstantRangeCount = 1;
  info.pPushConstantRanges = &push;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  check(vkCreatePipelineLayout(device.get(), &info, nullptr, &layout), "making a pipeline layout");
  layout_ = PipelineLayoutHandle(device.get(), layout);
}

std::vector<Stage> Pipelines::stages() const {
  std::lock_guard lock(mutex_);
  std::vector<Stage> stages;
  for (const auto& [key, compiled] : made_) stages.push_back(key.first);
  return stages;
}

// Forgets the pipelines that nobody holds and that were asked for longest ago, beyond `most_`. (Locked.)
void Pipelines::forget() {
  std::vector<decltype(made_)::iterator> unused;
  for (auto it = made_.begin(); it != made_.end(); ++it)
    if (it->second.use_count() == 1) unused.push_back(it);
  std::sort(unused.begin(), unused.end(),
            [](auto a, auto b) { return a->second->wanted > b->second->wanted; });
  for (size_t i = most_; i < unused.size(); i++) made_.erase(unused[i]);
}

Pipeline Pipelines::get(Stage stage, const Special& wanted) {
  Special special = specialFor(stage, wanted);
  special.roundsRight = device_.roundsRight();
  std::shared_ptr<Compiled> compiled;
  {
    std::lock_guard lock(mutex_);
    auto& entry = made_[{stage, special}];
    if (!entry) entry = std::make_shared<Compiled>();
    entry->wanted = ++calls_;
    if (made_.size() > most_) forget();
    compiled = entry;
  }
  const Pipeline pipeline(compiled, &compiled->pipeline);
  std::lock_guard lock(compiled->mutex);
  if (compiled->pipeline) return pipeline;
  const std::span<const uint32_t> code = codeOf(stage);
  VkShaderModuleCreateInfo module{};
  module.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
  module.codeSize = code.size_bytes();
  module.pCode = code.data();
  VkShaderModule shader = VK_NULL_HANDLE;
  check(vkCreateShaderModule(device_.get(), &module, nullptr, &shader), "loading a shader");
  const ShaderHandle owned(device_.get(), shader);
  std::array<VkSpecializationMapEntry, sizeof(Special) / 4> entries;
  for (uint32_t i = 0; i < entries.size(); i++) entries[i] = {i, 4 * i, 4};
  const VkSpecializationInfo constants{uint32_t(entries.size()), entries.data(), sizeof(Special), &special};
  VkComputePipelineCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = shader;
  info.stage.pName = "main";
  info.stage.pSpecializationInfo = &constants;
  info.layout = layout_.get();
  VkPipeline made = VK_NULL_HANDLE;
  check(vkCreateComputePipelines(device_.get(), VK_NULL_HANDLE, 1, &info, nullptr, &made),
        "compiling a shader");
  compiled->pipeline = PipelineHandle(device_.get(), made);
  return pipeline;
}

}  // namespace gxy::vulkan
