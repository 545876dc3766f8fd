// SPDX-License-Identifier: Apache-2.0
#include "backends/embree/embree_sampling.h"

#include <utility>

#include "act_sample_ispc.h"
#include "core/rays/fill_views.h"
#include "core/rays/view_pointers.h"

namespace gxy {

namespace {

uint64_t numberOf(const RayView& rays, int i) {
  return uint64_t(rays.pixel[i]) | uint64_t(uint32_t(rays.sr[i])) << 32;
}

}  // namespace

EmbreeSampling::EmbreeSampling(std::shared_ptr<const CompiledSampling> sampling,
                               std::span<const int> partitions)
    : sampling_(std::move(sampling)) {
  ViewPointers pointers;
  const CompiledSampling& s = *sampling_;
  for (const int p : partitions) {
    Part& part = parts_[p];
    part.fields.resize(s.views.size());
    for (size_t f = 0; f < s.views.size(); f++) {
      const auto found = s.views[f].parts.find(p);
      fillVolumeView(part.fields[f], s.views[f], found == s.views[f].parts.end() ? nullptr : &found->second,
                     pointers);
    }
    part.view.fields = int(part.fields.size());
    part.view.field = part.fields.data();
    part.view.isovalueOf = s.isovalueOf.data();
    part.view.gradient = s.gradient;
    part.view.conditions = int(s.conditionField.size());
    part.view.conditionOperator = s.conditionOperator.data();
    part.view.conditionField = s.conditionField.data();
    part.view.conditionRange = s.conditionRange.data();
    part.view.hits = s.hits.data();
  }
}

void EmbreeSampling::record(const single::SceneView& scene, int partition, RayView& rays,
                            std::span<const int> which, SampleList& samples) const {
  const CompiledSampling& s = *sampling_;
  const size_t n = which.size();
  std::vector<float> values(s.views.size() * n), gradients(s.gradient ? 3 * n : 0);
  std::vector<int32_t> hit(n);
  ispc::sampleHits(&scene, &parts_.at(partition).view, &rays, which.data(), int(n), values.data(),
                   gradients.data(), hit.data());
  for (size_t k = 0; k < n; k++) {
    if (hit[k] < 0) continue;
    const int i = which[k];
    addSample(s,
              {numberOf(rays, i),
               uint32_t(hit[k]),
               uint32_t(rays.sg[i]),
               uint32_t(rays.hitOperator[i]),
               rays.tHit[i],
               {{rays.ox[i], rays.oy[i], rays.oz[i]},
                {rays.dx[i], rays.dy[i], rays.dz[i]},
                uint32_t(rays.hitKind[i]),
                rays.hitPrimitive[i],
                partition},
               values.empty() ? nullptr : values.data() + k,
               n,
               gradients.empty() ? nullptr : gradients.data() + 3 * k},
              samples);
  }
}

}  // namespace gxy
