// SPDX-License-Identifier: Apache-2.0
// EmbreeSampling: a sampling in the form that the ISPC kernels read.
#pragma once
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "core/kernels/single_views.h"
#include "core/rays/backend.h"

namespace gxy {

/// What is recorded where sampling rays meet surfaces, for the local partitions. Immutable, thread safe.
class EmbreeSampling {
 public:
  EmbreeSampling(std::shared_ptr<const CompiledSampling> sampling, std::span<const int> partitions);

  /// Records the hits of the rays `which`, which have met surfaces in the partition, and sets `next` of each: END_ACTIVE if it
  /// goes on behind the surface, else END_DONE.
  void record(const single::SceneView& scene, int partition, RayView& rays, std::span<const int> which,
              SampleList& samples) const;

 private:
  struct Part {
    single::SamplingView view{};
    std::vector<single::VolumeView> fields;
  };

  const std::shared_ptr<const CompiledSampling> sampling_;
  std::map<int, Part> parts_;
};

}  // namespace gxy
