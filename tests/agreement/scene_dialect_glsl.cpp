// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstring>

#include "backends/vulkan/scene_upload.h"
#include "backends/vulkan/shader_views.h"
#include "core/rays/fill_views.h"
#include "scene_probes_spirv.h"
#include "shaders/layout.h"
#include "tests/agreement/scene_dialect.h"
#include "tests/vulkan/test_device.h"
#include "tests/vulkan/test_shader.h"

namespace gxy::agreement {

using namespace vulkan;

std::vector<float> sceneProbesInGlsl(const CompiledScene& scene, const CompiledFrame& frame, int probes,
                                     int inputs) {
  const Device device(vulkan_test::testDevice());
  const Pipelines pipelines(device);
  SharedData shared;
  const PartitionOnDevice part = uploadPart(device, pipelines, shared, scene, 0, 0);
  shader::FrameView view{};
  fillFrameView(view, scene, frame);
  const Buffer frameBuffer(device, sizeof view + frame.lights.size() * 16, Place::Written, "a frame");
  std::memcpy(frameBuffer.mapped(), &view, sizeof view);
  std::memcpy(frameBuffer.mapped() + sizeof view, frame.lights.data(), frame.lights.size() * 16);
  const Binding binding{{frameBuffer.get(), 0, VK_WHOLE_SIZE}};
  const DescriptorSet frameSet(device, pipelines.setLayout(FRAME_SET), std::span(&binding, 1));
  uint32_t volumes = 0;
  for (const CompiledOperator& op : scene.operators) volumes += op.vis.volumeRendering;
  const size_t rows = scene.operators.size() * size_t(probes);
  std::vector<float> found(rows * size_t(inputs));
  const uint32_t numbers[2] = {uint32_t(part.volumeList), volumes};
  std::vector<Buffer> buffers;
  buffers.emplace_back(device, sizeof numbers, Place::Device, "numbers");
  buffers.emplace_back(device, found.size() * sizeof(float), Place::Readback, "probes");
  upload(device, buffers[0], 0, std::as_bytes(std::span(numbers)));
  Special special = part.special;
  special.mapAhead = 0;  // probes look at several maps
  vulkan_test::TestShader(device, pipelines, scene_probes_spirv, special)
      .run(part.set.get(), buffers, inputs, {uint32_t(inputs + BLOCK_RAYS - 1) / BLOCK_RAYS, uint32_t(rows)},
           frameSet.get());
  std::memcpy(found.data(), buffers[1].mapped(), found.size() * sizeof(float));
  return found;
}

}  // namespace gxy::agreement
