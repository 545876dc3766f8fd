// SPDX-License-Identifier: Apache-2.0
// The frame of a ray, in which the ray is the z axis.
#pragma once
#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>

#include "core/reference/ray.h"

namespace gxy::reference {

/// a d - b c to within two ulps of the result, so that its sign is that of the exact number (Jeannerod, Louvet and Muller 2013, after
/// Kahan).
inline double determinant(double a, double b, double c, double d) {
  const double product = b * c;
  return std::fma(a, d, -product) - std::fma(b, c, -product);
}

/// Shears space so that a ray becomes the axis on which it is longest.
class RayFrame {
 public:
  explicit RayFrame(const Ray& ray)
      : ray_(ray), z_(std::abs(ray.direction.x) >= std::abs(ray.direction.y) ? 0 : 1) {
    const glm::dvec3 d = ray.direction;
    if (std::abs(d.z) > std::abs(d[z_])) z_ = 2;
    x_ = (z_ + 1) % 3, y_ = (z_ + 2) % 3;
    sx_ = d[x_] / d[z_], sy_ = d[y_] / d[z_];
  }

  /// The point's place across the ray, and the ray's t there.
  glm::dvec3 sheared(const glm::dvec3& point) const {
    const glm::dvec3 p = point - ray_.origin;
    return {p[x_] - sx_ * p[z_], p[y_] - sy_ * p[z_], p[z_] / ray_.direction[z_]};
  }

 private:
  Ray ray_;
  int x_, y_, z_;
  double sx_, sy_;
};

/// The edge from p to q, of points in a ray's frame, as the ray sees it.
struct SeenEdge {
  double area;  ///< twice the area of the triangle of p, q and the ray
  /// > 0 if the ray is left of the edge and < 0 if it is right of it. A ray that meets an edge counts as one beside it: a little to x,
  /// and less to y.
  double side;

  SeenEdge(const glm::dvec3& p, const glm::dvec3& q)
      : area(determinant(p.x, p.y, q.x, q.y)),
        side(area != 0    ? area
             : p.y != q.y ? p.y - q.y
                          : q.x - p.x) {}
};

}  // namespace gxy::reference
