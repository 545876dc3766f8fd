// SPDX-License-Identifier: Apache-2.0
// A partition of a compiled scene in device memory.
#pragma once
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "backends/vulkan/pipelines.h"
#include "backends/vulkan/shader_views.h"
#include "core/rays/compiled_sampling.h"
#include "core/space/shared_by.h"

namespace gxy::vulkan {

/// Device memory that a scene accounts for itself (DeviceScene::bytes), while this lives.
class Charge {
 public:
  Charge() = default;
  Charge(const Device& device, size_t bytes) : device_(&device), bytes_(bytes) {
    device.chargeElsewhere(int64_t(bytes_));
  }
  Charge(Charge&& other) noexcept
      : device_(std::exchange(other.device_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}
  Charge& operator=(Charge other) noexcept {
    std::swap(device_, other.device_);
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~Charge() {
    if (device_) device_->chargeElsewhere(-int64_t(bytes_));
  }
  size_t bytes() const { return bytes_; }

 private:
  const Device* device_ = nullptr;
  size_t bytes_ = 0;
};

/// Samples of volumes.
struct SamplesOnDevice {
  Buffer buffer;
  Charge charge;
};

/// The primitives and cells of a partition's operators, and the hierarchies over them.
struct GeometryOnDevice {
  Buffer buffer;
  Charge charge;
  uint32_t hierarchy = 0;  ///< place of the hierarchy in the buffer
  /// Per operator: places of its primitives' arrays; no other member is set.
  std::vector<shader::OperatorView> places;
};

/// The data that the stages read of a partition or, without a partition, of the scene as a whole, for
/// spawning.
struct PartitionOnDevice {
  Buffer scene;
  std::shared_ptr<const SamplesOnDevice> samples;    ///< null if there are none
  std::shared_ptr<const GeometryOnDevice> geometry;  ///< null if there is none
  DescriptorSet set;
  int partition = -1;
  Special special;            ///< for all stages, without `surfaces` and `anyHit`
  int32_t geometryKinds = 0;  ///< SURFACE_* bits of its geometry
  uint32_t volumeList = 0;    ///< place of the rendered volumes' list in the tables
  uint32_t mine = 0;          ///< place in the tables: per partition, whether it is this rank's and visible
  std::vector<bool> hasBlock, hasIsosurface, hasCells;  ///< per operator
};

/// Device data shared between scenes. The key is the list of blocks or of primitives in their order. Scenes
/// that have only some of the data in common share nothing.
struct SharedData {
  SharedBy<std::vector<const VolumeBlock*>, SamplesOnDevice> samples;
  SharedBy<std::vector<const GeometryInPartition*>, GeometryOnDevice> geometry;
};

/// Throws Error if a block has more points, or numbers of all components, than the shaders can index in 32
/// bits.
void checkNumbering(const Index3& points, int components);

/// Throws Error if the device has no room for the volumes and the geometry (without its hierarchies) of these
/// partitions together, less what other scenes have there already. It is called before any of them is there.
/// Small arrays are left out.
void expectRoom(const Device& device, const SharedData& shared, const CompiledScene& scene,
                std::span<const int> partitions);

/// Copies a partition to the device; partition < 0: none, for spawning. Throws Error if the device has no
/// room for it, and what `advance` throws.
PartitionOnDevice uploadPart(
    const Device& device, const Pipelines& pipelines, SharedData& shared, const CompiledScene& scene,
    int partition, int rank, const Advance& advance = [](double) {});

/// Copies what the act of a sampling reads of a partition: fields[] are those of the scene's operators, then those of the sampling;
/// there is no geometry. Throws Error if the device has no room for it.
PartitionOnDevice uploadFields(const Device& device, const Pipelines& pipelines, SharedData& shared,
                               const CompiledSampling& sampling, int partition, int rank);

}  // namespace gxy::vulkan
