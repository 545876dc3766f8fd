// SPDX-License-Identifier: Apache-2.0
// Checks rays that arrived in a message. Kernels use the fields as indices, so wrong ones must not reach
// them.
#pragma once
#include <cstdint>

#include "core/rays/compiled_frame.h"
#include "core/rays/ray_list.h"

namespace gxy {

struct RayLimits {
  uint64_t pixels = 0;
  uint32_t samples = 0, operators = 0;
  float reach = 0;  ///< largest absolute coordinate of a secondary ray's origin, render space
};
RayLimits limitsOf(const CompiledScene& scene, const CompiledFrame& frame);

/// Checks the fields that came over the wire; `primary` tells which kind of rays the message holds. Returns
/// what is wrong with the first bad ray (a static text), or null if all are good.
const char* wrongIn(const RayList& rays, bool primary, const RayLimits& limits);

}  // namespace gxy
