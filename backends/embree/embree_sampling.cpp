// SPDX-License-Identifier: Apache-2.0
#include "backends/embree/embree_sampling.h"

#include <glm/vec3.hpp>
#include <utility>

#include "act_sample_ispc.h"
#include "backends/embree/view_pointers.h"
#include "core/rays/fill_views.h"

namespace gxy {

namespace {

uint64_t numberOf(const RayView& rays, int i) {
  return uint64_t(rays.pixel[i]) | uint64_t(uint32_t(rays.sr[i])) << 32;
}

// In double from the ray alone, so that it has the same bits whatever the partitions.
glm::dvec3 worldAt(const RenderSpace& space, const RayView& rays, int i) {
  const double t = rays.tHit[i];
  const glm::dvec3 p(rays.ox[i] + t * rays.dx[i], rays.oy[i] + t * rays.dy[i], rays.oz[i] + t * rays.dz[i]);
  return space.centre + p / space.scale;
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
  samples.values.resize(size_t(s.recorded));
  for (size_t k = 0; k < n; k++) {
    if (hit[k] < 0) continue;
    const int i = which[k];
    samples.ray.push_back(numberOf(rays, i));
    samples.hit.push_back(uint32_t(hit[k]));
    samples.depth.push_back(uint32_t(rays.sg[i]));
    samples.surface.push_back(uint32_t(rays.hitOperator[i]));
    samples.t.push_back(rays.tHit[i]);
    samples.position.push_back(worldAt(s.scene->space, rays, i));
    for (size_t f = 0; f < samples.values.size(); f++) {
      const Volume& volume = *s.fields[f].volume;
      samples.values[f].push_back(float(volume.shift + volume.scale * values[f * n + k]));
    }
    if (!s.gradient) continue;
    const CompiledOperator& op = s.scene->operators[size_t(rays.hitOperator[i])];
    const double unit = (op.data.volume ? op.data.volume->scale : 1) * s.scene->space.scale;
    const float* g = &gradients[3 * k];
    samples.gradient.emplace_back(glm::dvec3(g[0], g[1], g[2]) * unit);
  }
}

}  // namespace gxy
