// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/ray_source.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "core/kernels/single.h"
#include "core/scene/camera.h"

namespace gxy {

namespace {

constexpr float kNoEnd = 1e30f;

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

// How many of the chunks of `rays` rays are the rank's, where ranks take turns.
uint64_t chunksOf(uint64_t rays, uint64_t rank, uint64_t ranks) {
  const uint64_t all = (rays + RaySource::kChunk - 1) / RaySource::kChunk;
  return (all + ranks - 1 - rank) / ranks;
}

}  // namespace

void setRay(const RayView& view, int i, const BeginningRay& ray) {
  view.pixel[i] = uint32_t(ray.number);
  view.sr[i] = int32_t(uint32_t(ray.number >> 32));
  view.info[i] = ray.info;
  view.start[i] = ray.start;
  view.ox[i] = ray.origin.x, view.oy[i] = ray.origin.y, view.oz[i] = ray.origin.z;
  view.dx[i] = ray.direction.x, view.dy[i] = ray.direction.y, view.dz[i] = ray.direction.z;
  view.tMax[i] = ray.length;
  view.sg[i] = int32_t(ray.depth);
  view.sb[i] = 0;
}

size_t UniformLines::chunks() const { return chunksOf(end_ - first_, rank_, ranks_); }

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
    setRay(list.view(), i, {number, 0, lo + start, direction});
  }
  return list;
}

RayList MappedRays::rays(size_t chunk, const RenderSpace& space) const {
  RayList list(raysOf(chunk));
  int n = 0;
  for (int i = 0; i < raysOf(chunk); i++) {
    const SampleRay ray = rayAt_(chunk * kChunk + uint64_t(i));
    const glm::dvec3 direction = glm::normalize(ray.direction);
    double t0 = 0, t1 = ray.length;
    cutTo(within_, ray.origin, direction, t0, t1);
    if (!(t0 <= t1)) continue;
    const double length = (ray.length - t0) * space.scale;
    setRay(list.view(), n++,
           {ray.number, 0, space.toRender(ray.origin + t0 * direction), direction,
            float(std::min(length, double(kNoEnd)))});
  }
  list.resize(n);
  return list;
}

MappedRays cameraRays(const Camera& camera, const Box& within, int rank, int ranks) {
  const CameraBasis basis = cameraBasis(camera);
  const auto width = uint64_t(camera.dimensions.x), all = width * uint64_t(camera.dimensions.y);
  constexpr uint64_t kChunk = RaySource::kChunk;
  const uint64_t chunks = chunksOf(all, uint64_t(rank), uint64_t(ranks));
  const uint64_t last = (chunks - 1) * uint64_t(ranks) + uint64_t(rank);  // of this rank's, among all chunks
  const uint64_t count = chunks == 0 ? 0 : (chunks - 1) * kChunk + std::min(kChunk, all - last * kChunk);
  return {count,
          [=](uint64_t place) {
            const uint64_t pixel =
                (place / kChunk * uint64_t(ranks) + uint64_t(rank)) * kChunk + place % kChunk;
            const uint64_t x = pixel % width, y = pixel / width;
            const CameraRay ray = cameraRay(basis, double(x) + 0.5, double(y) + 0.5);
            return SampleRay{pixel, ray.origin, ray.direction};
          },
          within};
}

}  // namespace gxy
