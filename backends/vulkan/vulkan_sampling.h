// SPDX-License-Identifier: Apache-2.0
// VulkanSampling: what the act of a sampling (shaders/sample.comp) reads and writes.
#pragma once
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "backends/vulkan/scene_upload.h"
#include "core/rays/compiled_sampling.h"

namespace gxy::vulkan {

/// A sampling on a device. Immutable, thread safe.
class VulkanSampling {
 public:
  /// Brings the fields to the device, in the given partitions of a rank. Throws Error if it has no room for them.
  VulkanSampling(const Device& device, const Pipelines& pipelines, SharedData& shared,
                 std::shared_ptr<const CompiledSampling> sampling, std::span<const int> partitions, int rank);

  /// What the act reads of a partition: its fields are those of the scene's operators, then those of the sampling.
  const PartitionOnDevice& part(int partition) const { return parts_.at(partition); }
  /// What it reads anywhere, for FRAME_BINDING: a SamplingView and its arrays.
  std::vector<int32_t> view() const;
  /// The number of words of a sample that the act writes.
  size_t words() const;
  /// Adds samples that it has written, in a partition.
  void take(std::span<const int32_t> written, int partition, SampleList& samples) const;

 private:
  const std::shared_ptr<const CompiledSampling> sampling_;
  std::map<int, PartitionOnDevice> parts_;
};

}  // namespace gxy::vulkan
