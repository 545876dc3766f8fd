// SPDX-License-Identifier: Apache-2.0
// Whether rays that came in a message are such as a Renderer sends: kernels use what is in them as indices.
#pragma once
#include <cstdint>

#include "core/rays/compiled_frame.h"
#include "core/rays/ray_list.h"

namespace gxy {

struct RayLimits {
  uint64_t pixels = 0;
  uint32_t samples = 0, operators = 0;
  float reach = 0;  ///< largest absolute coordinate of an origin, render space
};
RayLimits limitsOf(const CompiledScene& scene, const CompiledFrame& frame);

/// Says what is wrong with the fields that came over the wire; null if nothing is.
const char* wrongIn(const RayList& rays, bool primary, const RayLimits& limits);

}  // namespace gxy
