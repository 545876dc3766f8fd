// SPDX-License-Identifier: Apache-2.0
// Light on a surface: ambient light with occlusion, diffuse and specular light with shadows.
#pragma once
#include <functional>

#include "core/reference/camera.h"
#include "core/reference/world.h"

namespace gxy::reference {

/// The hit that asks for ambient-occlusion directions.
struct AoRequest {
  glm::ivec2 pixel{0};
  int sample = 0;  ///< number of the ray within the pixel
  int bounce = 0;  ///< number of surfaces that the ray met before this one
  glm::dvec3 position{0}, normal{0};
};

/// Returns unit directions, distributed over the hemisphere about the normal by its cosine.
using AoDirections = std::function<std::vector<glm::dvec3>(const AoRequest&)>;

/// `count` directions that converge to the cosine-weighted integral: a Fibonacci lattice on the disc, lifted
/// to the hemisphere.
std::vector<glm::dvec3> cosineHemisphere(glm::dvec3 normal, int count);

/// The lights of a scene, placed for a camera.
class Lights {
 public:
  /// `directions` gives the directions for ambient occlusion; it is called only if the scene's aoCount is not
  /// 0.
  Lights(const Lighting& lighting, const View& view, AoDirections directions, double tolerance);

  /// The light that a surface sends to the viewer, for full opacity: Ka C (1 - share of AO rays blocked) +
  /// sum over the lights of visibility * (Kd / lights * max(0, n.l) C + Ks / lights * max(0, r.v)^shininess).
  /// A light behind the surface gives neither diffuse nor specular light.
  glm::dvec3 shade(const World& world, const Ray& ray, const SurfaceHit& hit, AoRequest request) const;

 private:
  struct Placed {
    bool directional;
    glm::dvec3 v;  ///< unit direction to the light, or its position
  };
  double openSky(const World& world, const SurfaceHit& hit, AoRequest request) const;

  Lighting lighting_;
  std::vector<Placed> placed_;
  AoDirections directions_;
  double tolerance_;
};

}  // namespace gxy::reference
