// SPDX-License-Identifier: Apache-2.0
// A partition of a compiled scene in device memory.
#pragma once
#include <vector>

#include "gxy/rays/compiled_scene.h"
#include "gxy/vulkan/pipelines.h"

namespace gxy::vulkan {

/// What the stages read of a partition, or, without one, of the scene as a whole, for spawning.
struct PartOnDevice {
  Buffer scene, samples, geometry;
  DescriptorSet set;
  int partition = -1;
  Special special;             ///< for all stages, but `surfaces` and `anyHit`
  int32_t geometryKinds = 0;   ///< bits SURFACE_* of its geometry
  uint32_t volumeList = 0;     ///< place of the rendered volumes' list in the tables
  uint32_t mine = 0;           ///< and of whether each partition is this rank's and seen
  std::vector<bool> hasBlock;  ///< by operator
};

/// partition < 0: none. Throws Error where the device has no room for it.
PartOnDevice uploadPart(const Device& device, const Pipelines& pipelines, const CompiledScene& scene,
                        int partition, int rank);

}  // namespace gxy::vulkan
