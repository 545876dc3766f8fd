// SPDX-License-Identifier: Apache-2.0
#include "core/render/check_rays.h"

#include <algorithm>
#include <cmath>

namespace gxy {

RayLimits limitsOf(const CompiledScene& scene, const CompiledFrame& frame) {
  double reach = 1;  // origins lie in the visible domain, except for their offset from a surface
  for (int k = 0; k < 3; k++) reach = std::max({reach, std::abs(scene.lo[k]), std::abs(scene.hi[k])});
  return {uint64_t(frame.width) * uint64_t(frame.height), uint32_t(frame.firstSample + frame.samples),
          uint32_t(scene.operators.size()), float(2 * reach)};
}

const char* wrongIn(const RayList& rays, bool primary, const RayLimits& limits) {
  const RayView& r = rays.view();
  for (int i = 0; i < rays.size(); i++) {
    if (r.pixel[i] >= limits.pixels) return "a ray's pixel lies outside the picture";
    if (RAY_SAMPLE_NUMBER(r.info[i]) >= limits.samples)
      return "a ray has a sample that the frame does not have";
    const uint32_t kind = RAY_KIND(r.info[i]);
    if (primary ? kind != RAY_PRIMARY : kind != RAY_SHADOW && kind != RAY_OCCLUSION)
      return "a ray is of another kind than the message";
    if (!(r.tLast[i] >= -1 && std::isfinite(r.tLast[i]))) return "a ray's last surface is not on the ray";
    if (!(r.tResume[i] >= -1 && std::isfinite(r.tResume[i])))
      return "a ray's march begins nowhere on the ray";
    if (primary) {
      if (!std::isfinite(r.r[i]) || !std::isfinite(r.g[i]) || !std::isfinite(r.b[i]))
        return "a ray's radiance is not finite";
      continue;
    }
    if (RAY_START(r.info[i]) != START_NONE && r.start[i] >> 16 >= limits.operators)
      return "a ray starts on an operator that the scene does not have";
    for (float x : {r.ox[i], r.oy[i], r.oz[i]})
      if (!(std::abs(x) <= limits.reach)) return "a ray starts outside the visible domain";
    const float length2 = r.dx[i] * r.dx[i] + r.dy[i] * r.dy[i] + r.dz[i] * r.dz[i];
    if (!(std::abs(length2 - 1) < 1e-3f)) return "a ray's direction is not of unit length";
    if (!(r.tMax[i] >= 0)) return "a ray ends before it begins";
  }
  return nullptr;
}

}  // namespace gxy
