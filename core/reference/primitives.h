// SPDX-License-Identifier: Apache-2.0
// Hits of a ray with spheres, round cones and triangles.
#pragma once
#include <array>
#include <glm/vec3.hpp>

#include "core/reference/ray.h"

namespace gxy::reference {

/// The t at which a ray enters and leaves a closed convex body; they may be negative.
struct Crossing {
  bool hit = false;
  double in = 0, out = 0;
};

struct Ball {
  glm::dvec3 centre{0};
  double radius = 0;
};

/// The convex hull of two balls: a tube whose radius changes linearly, with round ends. If one ball holds the
/// other, the hull is that ball.
struct RoundCone {
  Ball a, b;

  /// The depth of p inside the body: the signed distance to the surface, positive inside.
  double depth(glm::dvec3 p) const;
  glm::dvec3 normal(glm::dvec3 p) const;
  /// The place of the ball that touches the surface at p: from 0 at a's centre to 1 at b's.
  double axial(glm::dvec3 p) const;
};

/// The discriminant is taken from the distance between centre and line, which does not cancel for far rays
/// (Haines et al., Precision improvements for ray/sphere intersection, Ray Tracing Gems, chapter 7). A ball
/// of radius 0 is never hit.
Crossing cross(const Ball& ball, const Ray& ray);
Crossing cross(const RoundCone& cone, const Ray& ray);

struct TriangleHit {
  bool hit = false;
  double t = 0;
  glm::dvec3 weights{0};  ///< barycentric
};

/// Watertight: two triangles that share an edge leave no gap (Woop, Benthin, Wald, Watertight Ray/Triangle
/// Intersection, JCGT 2013). A ray that meets an edge or a vertex exactly counts as one right beside it, and
/// so meets one triangle where they continue each other. `t` may be negative. A degenerate triangle is never
/// hit.
TriangleHit cross(const std::array<glm::dvec3, 3>& triangle, const Ray& ray);

}  // namespace gxy::reference
