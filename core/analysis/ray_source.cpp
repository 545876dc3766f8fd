// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/ray_source.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "core/kernels/single.h"

namespace gxy {

namespace {

constexpr float kNoEnd = 1e30f;

void setRay(const RayView& view, int i, uint64_t number, const glm::vec3& origin, const glm::vec3& direction,
            float length) {
  view.pixel[i] = uint32_t(number);
  view.sr[i] = int32_t(uint32_t(number >> 32));
  view.info[i] = RAY_SAMPLE << 16;
  view.start[i] = 0;
  view.ox[i] = origin.x, view.oy[i] = origin.y, view.oz[i] = origin.z;
  view.dx[i] = direction.x, view.dy[i] = direction.y, view.dz[i] = direction.z;
  view.tMax[i] = length;
  view.sg[i] = 0;
  view.sb[i] = 0;
}

// Cuts [t0, t1] to where the ray is in the box; empty if it misses.
void cutTo(const Box& box, const glm::dvec3& origin, const glm::dvec3& direction, double& t0, double& t1) {
  for (int a = 0; a < 3; a++) {
    if (direction[a] == 0) {
      if (origin[a] < box.lo[a] || origin[a] > box.hi[a]) t1 = -1;
      continue;
    }
    const double near = (box.lo[a] - origin[a]) / direction[a], far = (box.hi[a] - origin[a]) / direction[a];
    t0 = std::max(t0, std::min(near, far));
    t1 = std::min(t1, std::max(near, far));
  }
}

}  // namespace

size_t UniformLines::chunks() const {
  const uint64_t all = (end_ - first_ + kChunk - 1) / kChunk;
  return size_t((all + ranks_ - 1 - rank_) / ranks_);
}

int UniformLines::raysOf(size_t chunk) const {
  return int(std::min<uint64_t>(kChunk, end_ - firstOf(chunk)));
}

RayList UniformLines::rays(size_t chunk, const RenderSpace& space) const {
  const int n = raysOf(chunk);
  RayList list(n);
  list.resize(n);
  const glm::vec3 lo = space.toRender(box_.lo), size = (box_.hi - box_.lo) * space.scale;
  for (int i = 0; i < n; i++) {
    const uint64_t number = firstOf(chunk) + uint64_t(i);
    glm::vec3 start, direction;
    single::randomLine(uint32_t(seed_), uint32_t(seed_ >> 32), uint32_t(number), uint32_t(number >> 32), size,
                       start, direction);
    setRay(list.view(), i, number, lo + start, direction, kNoEnd);
  }
  return list;
}

RayList GivenRays::rays(size_t chunk, const RenderSpace& space) const {
  RayList list(raysOf(chunk));
  int n = 0;
  for (size_t k = chunk * kChunk; k < chunk * kChunk + size_t(raysOf(chunk)); k++) {
    const SampleRay& ray = rays_[k];
    const glm::dvec3 direction = glm::normalize(ray.direction);
    double t0 = 0, t1 = ray.length;
    cutTo(within_, ray.origin, direction, t0, t1);
    if (!(t0 <= t1)) continue;
    const double length = (ray.length - t0) * space.scale;
    setRay(list.view(), n++, ray.number, space.toRender(ray.origin + t0 * direction), direction,
           float(std::min(length, double(kNoEnd))));
  }
  list.resize(n);
  return list;
}

}  // namespace gxy
