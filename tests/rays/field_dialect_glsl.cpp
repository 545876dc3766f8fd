// SPDX-License-Identifier: Apache-2.0
#include "tests/rays/field_dialect_glsl.h"

#include <gtest/gtest.h>

#include <cstring>
#include <map>

#include "backends/vulkan/scene_upload.h"
#include "field_dialect_spirv.h"
#include "shaders/layout.h"
#include "tests/vulkan/test_device.h"
#include "tests/vulkan/test_shader.h"

namespace gxy::test {

namespace {

/// The field as the one volume of a scene in one piece.
CompiledScene sceneOf(const Field& f, const Shown& shown) {
  CompiledScene scene;
  scene.partitioning = std::make_shared<const Partitioning>(Partitioning::single(f.grid.box()));
  for (std::vector<float>& faces : scene.faces) faces = {-1e30f, 1e30f};
  scene.cellPartition = {0};
  scene.visible = {1};
  CompiledOperator& op = scene.operators.emplace_back();
  op.vis.type = VisType::Volume;
  op.vis.volumeRendering = true;
  if (f.component >= 0) op.vis.component = f.component;
  auto volume = std::make_shared<Volume>();
  volume->grid = f.grid;
  volume->stored = f.stored;
  volume->components = f.components;
  op.data.volume = volume;
  op.map = shown.map;
  for (int a = 0; a < 3; a++) {
    op.gridOrigin[size_t(a)] = float(f.grid.origin[a]);
    op.gridInverse[size_t(a)] = float(1 / f.grid.spacing[a]);
  }
  op.isovalues = shown.isovalues;
  OperatorInPartition& part = op.parts[0];
  part.block = &f.block;
  part.plan = shown.plan;
  part.isoMask = isoMask(f.block, f.stored, f.components, f.component, f.macrocells(), shown.isovalues);
  return scene;
}

/// The probes' shader by what it is compiled for, which takes long.
class Gpu {
 public:
  const vulkan::Device device{vulkan_test::testDevice()};
  const vulkan::Pipelines pipelines{device};

  const vulkan_test::TestShader& shader(const vulkan::Special& special) {
    return shaders_.try_emplace(special, device, pipelines, field_dialect_spirv, special).first->second;
  }

 private:
  std::map<vulkan::Special, vulkan_test::TestShader> shaders_;
};

}  // namespace

std::vector<float> fieldProbesInGlsl(const Field& f, const Shown& shown, std::span<const float> rays,
                                     int probes) {
  static Gpu gpu;
  vulkan::SharedData shared;
  const vulkan::PartitionOnDevice part =
      vulkan::uploadPart(gpu.device, gpu.pipelines, shared, sceneOf(f, shown), 0, 0);
  const size_t count = rays.size() / 8;
  std::vector<float> found(size_t(probes) * count);
  std::vector<vulkan::Buffer> buffers;
  buffers.emplace_back(gpu.device, rays.size_bytes(), vulkan::Place::Device, "rays");
  buffers.emplace_back(gpu.device, found.size() * sizeof(float), vulkan::Place::Readback, "probes");
  vulkan::upload(gpu.device, buffers[0], 0, std::as_bytes(rays));
  // As the backend would, but for one of all maps and plans: software devices take seconds to compile each.
  vulkan::Special wanted;
  wanted.sampleKind = part.special.sampleKind;
  wanted.scalars = part.special.scalars;
  wanted.byCells = 1;
  if (wanted.sampleKind == SAMPLE_F32 && wanted.scalars) wanted.mapAhead = part.special.mapAhead;
  gpu.shader(wanted).run(part.set.get(), buffers, int32_t(count),
                         {uint32_t(count + BLOCK_RAYS - 1) / BLOCK_RAYS, uint32_t(probes)});
  std::memcpy(found.data(), buffers[1].mapped(), found.size() * sizeof(float));
  return found;
}

}  // namespace gxy::test
