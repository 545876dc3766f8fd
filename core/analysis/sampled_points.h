// SPDX-License-Identifier: Apache-2.0
// Samples of rays become particles.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "core/analysis/filter.h"
#include "core/analysis/recorded_fields.h"
#include "core/analysis/sampler.h"

namespace gxy {

/// Collective. Makes particles of the samples of all ranks that have the `most` smallest keys (sample_order.h). Particle i is the
/// i-th of all keys, so ids do not depend on where samples are. Particles stay on the ranks of their samples. `recorded` says what
/// the sampling has recorded: their values and fields. A gradient becomes the field "gradient". Throws the same Error on all ranks.
std::shared_ptr<Dataset> sampledPoints(FilterRun& run, const std::string& name, TakenSamples samples,
                                       uint64_t most, std::shared_ptr<const Partitioning> partitioning,
                                       const SampledVolumes& recorded, bool gradient);

}  // namespace gxy
