// SPDX-License-Identifier: Apache-2.0
#include "core/reference/shade.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace gxy::reference {

std::vector<glm::dvec3> cosineHemisphere(glm::dvec3 normal, int count) {
  const glm::dvec3 other = std::abs(normal.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 tangent = glm::normalize(glm::cross(normal, other)),
                   bitangent = glm::cross(normal, tangent);
  std::vector<glm::dvec3> directions;
  for (int i = 0; i < count; i++) {
    const double squared = (i + 0.5) / count;
    const double angle = 2 * std::numbers::pi * (i * (std::numbers::phi - 1));
    const double r = std::sqrt(squared);
    directions.push_back(r * std::cos(angle) * tangent + r * std::sin(angle) * bitangent +
                         std::sqrt(1 - squared) * normal);
  }
  return directions;
}

Lights::Lights(const Lighting& lighting, const View& view, AoDirections directions, double tolerance)
    : lighting_(lighting), directions_(std::move(directions)), tolerance_(tolerance) {
  for (const Light& light : lighting.sources) {
    if (light.type == LightType::Directional) {
      // A zero direction of travel stands for light along (1, 1, 1).
      const glm::dvec3 travel = light.v == glm::dvec3(0) ? glm::dvec3(1) : light.v;
      placed_.push_back({true, -glm::normalize(travel)});
    } else {
      placed_.push_back({false, light.type == LightType::Camera ? view.position(light.v) : light.v});
    }
  }
}

namespace {

/// The fraction of light that reaches a surface from a direction, from up to `limit`. Where the shading normal is not that of the surface,
/// the light may come from its other side, and passes it first.
double lightFrom(const World& world, const SurfaceHit& hit, glm::dvec3 direction, double limit,
                 double tolerance) {
  const bool isBehind = glm::dot(hit.geometric, direction) < 0;
  const glm::dvec3 start = hit.position + (isBehind ? -hit.slack : hit.slack) * hit.geometric;
  const double passed = isBehind ? 1 - hit.opacity : 1;
  return passed > 0 ? passed * world.transmittance({start, direction}, limit, tolerance) : 0;
}

}  // namespace

double Lights::openSky(const World& world, const SurfaceHit& hit, AoRequest request) const {
  if (lighting_.aoCount <= 0) return 1;
  request.position = hit.position;
  request.normal = hit.normal;
  const auto directions = directions_(request);
  if (directions.empty()) return 1;
  double open = 0;
  for (const glm::dvec3& d : directions) open += lightFrom(world, hit, d, lighting_.aoRadius, tolerance_);
  return open / double(directions.size());
}

glm::dvec3 Lights::shade(const World& world, const Ray& ray, const SurfaceHit& hit, AoRequest request) const {
  glm::dvec3 lit = lighting_.Ka * hit.colour * openSky(world, hit, request);
  for (const Placed& light : placed_) {
    const glm::dvec3 path = light.directional ? light.v : light.v - hit.position;
    const double distance = glm::length(path);
    if (!(distance > 0)) continue;
    const glm::dvec3 l = path / distance;
    const double cosine = glm::dot(hit.normal, l);
    if (!(cosine > 0)) continue;
    const glm::dvec3 reflected = 2 * cosine * hit.normal - l;
    const double mirror = std::max(0.0, -glm::dot(reflected, ray.direction));
    const double n = double(placed_.size());
    glm::dvec3 share = lighting_.Kd / n * cosine * hit.colour;
    if (lighting_.Ks > 0) share += glm::dvec3(lighting_.Ks / n * std::pow(mirror, lighting_.shininess));
    if (lighting_.shadows)
      share *= lightFrom(world, hit, l, light.directional ? kInfinity : distance, tolerance_);
    lit += share;
  }
  return lit;
}

}  // namespace gxy::reference
