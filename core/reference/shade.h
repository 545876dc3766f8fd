// SPDX-License-Identifier: Apache-2.0
// Light on a surface: ambient with occlusion, diffuse and specular with shadows.
#pragma once
#include <functional>

#include "core/reference/camera.h"
#include "core/reference/world.h"

namespace gxy::reference {

/// Which hit asks for ambient-occlusion directions.
struct AoRequest {
  glm::ivec2 pixel{0};
  int sample = 0;  ///< ray within the pixel
  int bounce = 0;  ///< surfaces that the ray met before this one
  glm::dvec3 position{0}, normal{0};
};

/// Unit directions, distributed over the hemisphere about the normal by its cosine.
using AoDirections = std::function<std::vector<glm::dvec3>(const AoRequest&)>;

/// `count` directions that converge to the cosine-weighted integral: a Fibonacci lattice on the disc, lifted
/// to the hemisphere.
std::vector<glm::dvec3> cosineHemisphere(glm::dvec3 normal, int count);

/// Lights of a scene, placed for a camera.
class Lights {
 public:
  /// `directions` answers for ambient occlusion; it is asked only where the scene's aoCount is not 0.
  Lights(const Lighting& lighting, const View& view, AoDirections directions, double tolerance);

  /// The light that a surface sends to the viewer, for full opacity:
  /// Ka C (1 - share of AO rays blocked) + sum over the lights of visibility *
  /// (Kd / lights * max(0, n.l) C + Ks / lights * max(0, r.v)^shininess), a light behind the surface giving
  /// neither.
  glm::dvec3 shade(const World& world, const Ray& ray, const SurfaceHit& hit, AoRequest request) const;

 private:
  struct Placed {
    bool directional;
    glm::dvec3 v;  ///< direction to the light, unit; or its position
  };
  double openSky(const World& world, const SurfaceHit& hit, AoRequest request) const;

  Lighting lighting_;
  std::vector<Placed> placed_;
  AoDirections directions_;
  double tolerance_;
};

}  // namespace gxy::reference
