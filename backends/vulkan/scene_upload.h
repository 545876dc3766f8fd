// SPDX-License-Identifier: Apache-2.0
// A partition of a compiled scene in device memory.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "gxy/rays/compiled_scene.h"
#include "gxy/vulkan/pipelines.h"

namespace gxy::vulkan {

/// What the stages read of a partition, or, without one, of the scene as a whole, for spawning.
struct PartOnDevice {
  Buffer scene, geometry;
  std::shared_ptr<const Buffer> samples;  ///< of the volumes, also of other scenes that look at the same
  DescriptorSet set;
  int partition = -1;
  Special special;                            ///< for all stages, but `surfaces` and `anyHit`
  int32_t geometryKinds = 0;                  ///< bits SURFACE_* of its geometry
  uint32_t volumeList = 0;                    ///< place of the rendered volumes' list in the tables
  uint32_t mine = 0;                          ///< and of whether each partition is this rank's and seen
  std::vector<bool> hasBlock, hasIsosurface;  ///< by operator

  size_t bytes() const { return scene.bytes() + geometry.bytes(); }  ///< that are its own
};

/// Samples on the device, by the blocks that they are of, in their order. Scenes that look at the same volumes share them. (Those
/// of which only some are the same do not.) Thread safe.
class SharedSamples {
 public:
  using Blocks = std::vector<const VolumeBlock*>;
  using Buffers = std::shared_ptr<const Buffer>;
  /// Those that there are, else what `make` makes.
  Buffers get(const Blocks& blocks, const std::function<Buffer()>& make);

 private:
  std::mutex mutex_;
  std::map<Blocks, std::weak_ptr<const Buffer>> known_;
};

/// Throws Error where a block has more points, or numbers of all components, than the shaders tell apart in 32 bits.
void checkNumbering(const Index3& points, int components);

/// partition < 0: none. Throws Error where the device has no room for it.
PartOnDevice uploadPart(const Device& device, const Pipelines& pipelines, SharedSamples& samples,
                        const CompiledScene& scene, int partition, int rank);

}  // namespace gxy::vulkan
