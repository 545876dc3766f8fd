// SPDX-License-Identifier: Apache-2.0
#include "core/reference/reference.h"

#include <tbb/task_arena.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <mutex>
#include <string>

#include "core/comm/error.h"
#include "core/comm/parallel_for.h"

namespace gxy::reference {
namespace {

constexpr double kMiss = 1e30;

/// Uniform numbers in [-1, 1] (Steele, Lea, Flood: SplitMix64, OOPSLA 2014).
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  double next() {
    uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return double(int64_t(z ^ (z >> 31))) * 0x1p-63;
  }
  glm::dvec3 next3() {
    const double x = next(), y = next(), z = next();
    return {x, y, z};
  }
  /// A vector whose components are, independently, 0 in a quarter of the cases and else 1.
  glm::dvec3 axes() {
    const glm::dvec3 at = next3();
    return {at.x > -0.5, at.y > -0.5, at.z > -0.5};
  }

 private:
  uint64_t state_;
};

/// The t at which a ray enters a box, at least 0; 0 when it misses.
double entryOf(const Box& box, const Ray& ray) {
  Interval inside;
  for (int a = 0; a < 3; a++) {
    if (ray.direction[a] == 0) continue;
    const double t0 = (box.lo[a] - ray.origin[a]) / ray.direction[a];
    const double t1 = (box.hi[a] - ray.origin[a]) / ray.direction[a];
    inside = inside.intersected({std::min(t0, t1), std::max(t0, t1)});
  }
  return inside.lo <= inside.hi ? inside.lo : 0;
}

double longestSide(const Box& box) {
  const glm::dvec3 size = box.hi - box.lo;
  return box.empty() ? 0 : std::max({size.x, size.y, size.z});
}

/// Moves the point where a ray enters the box, and its direction. Often it does not move along an axis,
/// because a ray in a plane of a grid stays there in float, too.
Ray perturbed(const Ray& ray, const Box& box, double ulps, Random& random) {
  if (box.empty()) return ray;
  const double entry = entryOf(box, ray);
  const glm::dvec3 unit = ulps * 0x1p-24 * random.axes();
  const glm::dvec3 entered = ray.at(entry) + unit * longestSide(box) * random.next3();
  const glm::dvec3 direction = glm::normalize(ray.direction + unit * random.next3());
  return {entered - entry * direction, direction};
}

/// The errors of the hits of a perturbed ray: how far along the normal its secondary rays start, and how far
/// aside it is shaded.
struct Off {
  double slack = 0;
  glm::dvec3 shaded{0};
};

struct PixelValue {
  glm::dvec3 colour{0};
  double alpha = 0, depth = kMiss;
};

class Renderer {
 public:
  Renderer(const ReferenceScene& scene, const Camera& camera, const ReferenceOptions& options)
      : world_(scene),
        view_(camera),
        options_(options),
        rays_(std::max(1, scene.settings.raysPerPixel)),
        lights_(scene.visualization.lighting, view_, directionsFor(scene, options), options.tolerance) {}

  PixelValue pixel(glm::ivec2 at) const {
    PixelValue sum;
    for (int k = 0; k < rays_; k++) {
      const glm::dvec2 position = glm::dvec2(at) + subpixel(k) + options_.subpixelOffset;
      Ray ray = view_.ray(position.x, position.y);
      Off off;
      if (options_.perturbation > 0) {
        const uint64_t index = (uint64_t(uint32_t(at.y)) << 32 | uint32_t(at.x)) * uint64_t(rays_) + k;
        const uint64_t seed = (options_.seed + 1) * 0xd1342543de82ef95u ^ index * 0xff51afd7ed558ccdu;
        Random random(seed);
        ray = perturbed(ray, world_.box(), options_.perturbation, random);
        const double unit = options_.perturbation * 0x1p-24 * longestSide(world_.box());
        // One for all rays, as in renderers.
        off.slack = 6 * unit * std::abs(Random(options_.seed + 1).next());
        off.shaded = unit * random.next3();
      }
      const PixelValue one = trace(ray, {at, k, 0, {}, {}}, off);
      sum.colour += one.colour / double(rays_);
      sum.alpha += one.alpha / double(rays_);
      if (k == 0) sum.depth = one.depth;
    }
    return sum;
  }

 private:
  static AoDirections directionsFor(const ReferenceScene& scene, const ReferenceOptions& options) {
    if (options.aoHook) return options.aoHook;
    const int count = options.aoDirections > 0 ? options.aoDirections : scene.visualization.lighting.aoCount;
    return [count](const AoRequest& request) { return cosineHemisphere(request.normal, count); };
  }

  /// Volumes and surfaces along one ray, front to back.
  PixelValue trace(const Ray& ray, AoRequest request, const Off& off) const {
    PixelValue value;
    const VolumeRay volumes = world_.volumes(ray);
    double through = 1, reached = 0;
    Behind last;
    while (through > 0) {
      auto hit = world_.firstHit(ray, last, kInfinity, off.shaded);
      const RayIntegral part = volumes.integrate({reached, hit ? hit->t : kInfinity}, options_.tolerance);
      value.colour += through * part.colour;
      through *= part.transmittance;
      if (!hit) break;
      value.depth = std::min(value.depth, hit->t);
      hit->slack += off.slack;
      if (through > 0) value.colour += through * hit->opacity * lights_.shade(world_, ray, *hit, request);
      through *= 1 - hit->opacity;
      reached = hit->t;
      last = *hit;
      request.bounce++;
    }
    value.alpha = 1 - through;
    return value;
  }

  World world_;
  View view_;
  ReferenceOptions options_;
  int rays_;
  Lights lights_;
};

}  // namespace

ReferencePicture renderReference(const ReferenceScene& scene, const Camera& camera,
                                 const ReferenceOptions& options) {
  const Renderer renderer(scene, camera, options);
  const glm::ivec2 size = options.size == glm::ivec2(0) ? camera.dimensions : options.size;
  if (size.x <= 0 || size.y <= 0) throw Error("reference: a rectangle of pixels must have a positive size");
  ReferencePicture picture{size.x, size.y, std::vector<double>(size_t(size.x) * size.y * 4),
                           std::vector<double>(size_t(size.x) * size.y)};
  std::mutex mutex;
  int done = 0;
  auto row = [&](int y) {
    for (int x = 0; x < size.x; x++) {
      const PixelValue value = renderer.pixel(options.first + glm::ivec2(x, y));
      const size_t index = size_t(y) * size.x + x;
      for (int c = 0; c < 3; c++) picture.rgba[4 * index + c] = value.colour[c];
      picture.rgba[4 * index + 3] = value.alpha;
      picture.depth[index] = value.depth;
    }
    if (!options.progress) return;
    const std::lock_guard lock(mutex);
    options.progress(double(++done) / size.y);
  };
  tbb::task_arena arena(options.threads > 0 ? options.threads : int(tbb::task_arena::automatic));
  arena.execute([&] { parallelFor(0, size.y, row); });
  return picture;
}

void applyBackground(ReferencePicture& picture, const Background& behind) {
  for (size_t i = 0; i < picture.rgba.size(); i += 4) {
    const glm::dvec4 background = behind.at(int(i / 4) / picture.width, picture.height);
    const double rest = (1 - picture.rgba[i + 3]) * background.a;
    for (int c = 0; c < 3; c++) picture.rgba[i + c] += rest * background[c];
    picture.rgba[i + 3] += rest;
  }
}

}  // namespace gxy::reference
