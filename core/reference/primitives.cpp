// SPDX-License-Identifier: Apache-2.0
#include "core/reference/primitives.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

namespace gxy::reference {
namespace {

void join(Crossing& whole, double in, double out) {
  whole =
      whole.hit ? Crossing{true, std::min(whole.in, in), std::max(whole.out, out)} : Crossing{true, in, out};
}

/// The lateral surface of the cone that touches both balls, between the circles where it touches them.
void joinLateral(Crossing& whole, const RoundCone& cone, glm::dvec3 axis, double length, const Ray& ray) {
  const double k = (cone.a.radius - cone.b.radius) / length;  // sine of the half angle
  const double lowest = cone.a.radius * k, highest = length + cone.b.radius * k;
  // The ray's origin is moved near the cone, so that nothing cancels for far rays.
  const double rebase = glm::dot(cone.a.centre - ray.origin, ray.direction);
  const glm::dvec3 m = ray.at(rebase) - cone.a.centre;
  const double m0 = glm::dot(m, axis), d0 = glm::dot(ray.direction, axis);
  const glm::dvec3 mAcross = m - m0 * axis, dAcross = ray.direction - d0 * axis;
  // rho^2 (1 - k^2) = (ra - k y)^2 with rho the distance from the axis and y the position along it
  const double c2 = 1 - k * k, r = cone.a.radius - k * m0;
  const double square = c2 * glm::dot(dAcross, dAcross) - k * k * d0 * d0;
  const double half = c2 * glm::dot(mAcross, dAcross) + k * d0 * r;
  const double constant = c2 * glm::dot(mAcross, mAcross) - r * r;
  const double discriminant = half * half - square * constant;
  if (!(discriminant >= 0)) return;
  const double q = -(half + std::copysign(std::sqrt(discriminant), half));
  auto consider = [&](double s) {
    const double y = m0 + s * d0;
    if (y >= lowest && y <= highest) join(whole, rebase + s, rebase + s);
  };
  if (square != 0) consider(q / square);
  if (q != 0) consider(constant / q);
}

}  // namespace

Crossing cross(const Ball& ball, const Ray& ray) {
  if (!(ball.radius > 0)) return {};
  const double nearest = glm::dot(ball.centre - ray.origin, ray.direction);
  const glm::dvec3 offset = ray.at(nearest) - ball.centre;
  const double discriminant = ball.radius * ball.radius - glm::dot(offset, offset);
  if (!(discriminant >= 0)) return {};
  const double half = std::sqrt(discriminant);
  return {true, nearest - half, nearest + half};
}

Crossing cross(const RoundCone& cone, const Ray& ray) {
  if (!(cone.a.radius > 0 || cone.b.radius > 0)) return {};
  const glm::dvec3 along = cone.b.centre - cone.a.centre;
  const double length = glm::length(along);
  if (length <= std::abs(cone.a.radius - cone.b.radius)) {
    return cross(cone.a.radius >= cone.b.radius ? cone.a : cone.b, ray);
  }
  Crossing whole;
  for (const Ball& ball : {cone.a, cone.b}) {
    if (const Crossing c = cross(ball, ray); c.hit) join(whole, c.in, c.out);
  }
  joinLateral(whole, cone, along / length, length, ray);
  return whole;
}

double RoundCone::axial(glm::dvec3 p) const {
  const glm::dvec3 along = b.centre - a.centre;
  const double length = glm::length(along), change = a.radius - b.radius;
  if (length <= std::abs(change)) return change >= 0 ? 0 : 1;
  const glm::dvec3 axis = along / length;
  const double y = glm::dot(p - a.centre, axis), k = change / length;
  const double rho = glm::length(p - a.centre - y * axis);
  return std::clamp((y - rho * k / std::sqrt(1 - k * k)) / length, 0.0, 1.0);
}

double RoundCone::depth(glm::dvec3 p) const {
  const double u = axial(p);
  return a.radius + u * (b.radius - a.radius) - glm::length(p - a.centre - u * (b.centre - a.centre));
}

glm::dvec3 RoundCone::normal(glm::dvec3 p) const {
  const double u = axial(p);
  return glm::normalize(p - a.centre - u * (b.centre - a.centre));
}

TriangleHit cross(const std::array<glm::dvec3, 3>& triangle, const Ray& ray) {
  // Shear so that the ray runs along the axis on which it is longest.
  const glm::dvec3 d = ray.direction;
  int z = std::abs(d.x) >= std::abs(d.y) ? 0 : 1;
  if (std::abs(d.z) > std::abs(d[z])) z = 2;
  const int x = (z + 1) % 3, y = (z + 2) % 3;
  const double sx = d[x] / d[z], sy = d[y] / d[z], sz = 1 / d[z];
  std::array<double, 3> px, py, pz;
  for (int i = 0; i < 3; i++) {
    const glm::dvec3 p = triangle[i] - ray.origin;
    px[i] = p[x] - sx * p[z];
    py[i] = p[y] - sy * p[z];
    pz[i] = sz * p[z];
  }
  const glm::dvec3 edge(px[2] * py[1] - py[2] * px[1], px[0] * py[2] - py[0] * px[2],
                        px[1] * py[0] - py[1] * px[0]);
  // A ray that meets an edge counts as one beside it: a little to x, and less to y.
  const auto sign = [&](double e, int from, int to) {
    return e != 0 ? e : py[from] != py[to] ? py[to] - py[from] : px[from] - px[to];
  };
  const double a = sign(edge.x, 1, 2), b = sign(edge.y, 2, 0), c = sign(edge.z, 0, 1);
  if (!(a < 0 && b < 0 && c < 0) && !(a > 0 && b > 0 && c > 0)) return {};
  const double sum = edge.x + edge.y + edge.z;
  const glm::dvec3 weights = edge / sum;
  return {true, weights.x * pz[0] + weights.y * pz[1] + weights.z * pz[2], weights};
}

}  // namespace gxy::reference
