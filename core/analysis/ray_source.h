// SPDX-License-Identifier: Apache-2.0
// Where the rays of a sampling begin.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/data/box.h"
#include "core/rays/compiled_scene.h"
#include "core/rays/ray_list.h"
#include "core/scene/scene.h"

namespace gxy {

/// A ray of a sampling as it begins, in render space.
struct BeginningRay {
  uint64_t number = 0;
  uint32_t depth = 0;                       ///< how many rays it descends from
  glm::vec3 origin{0}, direction{0, 0, 1};  ///< of length 1
  float length = 1e30f;
  uint32_t info = RAY_SAMPLE << 16, start = 0;  ///< as in ray_fields.h
};

/// Sets the fields of ray i that DeviceScene::spawnRays() reads.
void setRay(const RayView& view, int i, const BeginningRay& ray);

/// The rays that one rank begins, in chunks. All ranks together begin all rays of a sampling, each of them once. Immutable, thread
/// safe.
class RaySource {
 public:
  /// The most rays of a chunk.
  static constexpr int kChunk = 1024;

  virtual ~RaySource() = default;
  virtual size_t chunks() const = 0;
  /// The number of rays of a chunk, at most kChunk.
  virtual int raysOf(size_t chunk) const = 0;
  /// Makes the rays of a chunk, as DeviceScene::spawnRays() takes them.
  virtual RayList rays(size_t chunk, const RenderSpace& space) const = 0;
};

/// Lines through a box that are uniformly distributed (core/kernels/random_line.h), with numbers from `first` to before `end`.
/// Line i depends on the box, the seed and i alone. Ranks take turns in making chunks.
class UniformLines final : public RaySource {
 public:
  UniformLines(const Box& box, uint64_t seed, uint64_t first, uint64_t end, int rank, int ranks)
      : box_(box), seed_(seed), first_(first), end_(end), rank_(uint64_t(rank)), ranks_(uint64_t(ranks)) {}
  size_t chunks() const override;
  int raysOf(size_t chunk) const override;
  RayList rays(size_t chunk, const RenderSpace& space) const override;

 private:
  uint64_t firstOf(size_t chunk) const { return first_ + (chunk * ranks_ + rank_) * kChunk; }

  const Box box_;
  const uint64_t seed_, first_, end_, rank_, ranks_;
};

/// A ray of the user's.
struct SampleRay {
  uint64_t number = 0;                                      ///< different from that of all other rays
  glm::dvec3 origin{0};                                     ///< world
  glm::dvec3 direction{0, 0, 1};                            ///< of any length but 0
  double length = std::numeric_limits<double>::infinity();  ///< world units
};

/// Rays of this rank by their places, 0 to before `count`. Those that miss the box `within`, outside of which there is nothing, are
/// left out. Those that begin outside begin where they enter it, in double, so that a far origin loses nothing; their t is 0 there.
class MappedRays : public RaySource {
 public:
  using RayAt = std::function<SampleRay(uint64_t place)>;

  /// `rayAt` is called by any thread, and several at once.
  MappedRays(uint64_t count, RayAt rayAt, const Box& within)
      : count_(count), rayAt_(std::move(rayAt)), within_(within) {}
  size_t chunks() const override { return size_t((count_ + kChunk - 1) / kChunk); }
  int raysOf(size_t chunk) const override { return int(std::min<uint64_t>(kChunk, count_ - chunk * kChunk)); }
  RayList rays(size_t chunk, const RenderSpace& space) const override;

 private:
  const uint64_t count_;
  const RayAt rayAt_;
  const Box within_;
};

/// Rays that are given one by one.
class GivenRays final : public MappedRays {
 public:
  GivenRays(std::vector<SampleRay> rays, const Box& within)
      : GivenRays(std::make_shared<const std::vector<SampleRay>>(std::move(rays)), within) {}

 private:
  GivenRays(std::shared_ptr<const std::vector<SampleRay>> rays, const Box& within)
      : MappedRays(
            rays->size(), [rays](uint64_t place) { return (*rays)[place]; }, within) {}
};

/// The rays through the middles of a camera's pixels, numbered by pixel. Ranks take turns in making chunks.
MappedRays cameraRays(const Camera& camera, const Box& within, int rank, int ranks);

}  // namespace gxy
