// SPDX-License-Identifier: Apache-2.0
// Rays that begin where other rays have ended: redirected ones, and ones that a hit spawns.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <string>
#include <vector>

#include "core/analysis/ray_source.h"
#include "core/rays/compiled_sampling.h"

namespace gxy {

/// What follows the hit with which a ray ends on an operator.
struct NextRule {
  enum class Way {
    Stop,
    AlongGradient,    ///< of `field`
    AgainstGradient,  ///< of `field`
    AlongField,       ///< `field`, of which all three components are meant
    Mirror,           ///< about the surface's normal
    Refract,          ///< Snell's law; all is mirrored where nothing can be refracted
    Fixed,            ///< `direction`
    Spawn             ///< `rays` directions at random
  };
  Way way = Way::Stop;
  SampledField field;
  /// Refractive indices: n1 where the values are below the isovalue, of a plane where n . p is below its offset, of a triangle on
  /// its back; n2 on the other side.
  double n1 = 1, n2 = 1;
  glm::dvec3 direction{0, 0, 1};
  int rays = 1;
  bool sphere =
      false;  ///< Spawn: in all directions, and not only on the side of the surface that the ray came from
  bool uniform = false;  ///< Spawn: no direction is preferred, else by the cosine with the normal

  /// Whether the normal of a surface is needed.
  bool needsNormal() const {
    return way == Way::Mirror || way == Way::Refract || (way == Way::Spawn && !sphere);
  }
  int children() const { return way == Way::Stop ? 0 : way == Way::Spawn ? rays : 1; }
};

/// The most children of a ray: those of the rule that has the most.
int mostChildren(const std::vector<NextRule>& rules);

/// An upper bound on all rays of `depth` generations that follow `begun` rays, with these; and whether they can be numbered if the
/// first rays have numbers below `numbers`. Throws Error (what, how many, what was expected) if there may be more than
/// kMostFollowingRays, or if they cannot.
uint64_t checkedFollowingRays(uint64_t begun, uint64_t numbers, int children, int depth);
inline constexpr uint64_t kMostFollowingRays = uint64_t(1) << 32;

/// The rays that follow samples of this rank. The number of child c of a ray is that of the ray times mostChildren(), plus c: no two
/// rays of a generation have the same, and it depends on nothing but the ray's ancestors. So do the random numbers, which are
/// Philox's for (seed, generation) and (number of the ray, hit). The directions of a hit's children are evenly spread, and turned at
/// random. Immutable, thread safe.
class NextRays final : public RaySource {
 public:
  /// `rules` are by operator of the sampling, whose SampleList::met is stored. Of the samples only those with which rays have ended
  /// are looked at. The samples are not needed afterwards. `check` is called now and then, and may throw.
  NextRays(
      const CompiledSampling& sampling, const SampleList& samples, const std::vector<NextRule>& rules,
      uint32_t seed, const std::function<void()>& check = [] {});

  size_t chunks() const override { return size_t((rays_ + kChunk - 1) / kChunk); }
  int raysOf(size_t chunk) const override {
    return int(std::min<uint64_t>(kChunk, rays_ - uint64_t(chunk) * kChunk));
  }
  RayList rays(size_t chunk, const RenderSpace& space) const override;

  uint64_t size() const { return rays_; }
  /// The most bytes that the rays after so many samples take.
  static int64_t mostBytes(size_t samples) { return int64_t(samples * sizeof(Parent)); }

 private:
  /// A hit from which rays begin.
  struct Parent {
    uint64_t number, firstRay;  ///< of its children among all here
    uint32_t depth;
    uint32_t shift[2];     ///< random words
    uint32_t start, info;  ///< the surface that they leave, but for the side
    glm::vec3 point,
        geometric;     ///< render space; the normal of the surface itself, to the side of higher values
    glm::vec3 toward;  ///< the direction, or the axis of directions
    float size;        ///< the largest number that the hit was computed from; < 0: it is on no surface
    bool spawns, sphere, uniform;
  };
  class Hits;

  glm::vec3 directionOf(const Parent& parent, uint64_t child) const;

  uint64_t rays_ = 0;
  uint64_t children_ = 1;
  std::vector<Parent> parents_;
};

}  // namespace gxy
