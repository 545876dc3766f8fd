// SPDX-License-Identifier: Apache-2.0
#include "core/rays/compiled_frame.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace gxy {

namespace {

// In sizes of what is seen: from this distance on a float cannot tell the directions of a light at the two
// ends apart. A single sphere may be larger than the domain, which is the box of centres, so its size counts
// as well; but squares must not overflow.
constexpr double kFarAway = 1e9, kFarthest = 1e18;

}  // namespace

CompiledFrame compileFrame(const CompiledScene& scene, const Camera& camera, uint32_t number, bool depth) {
  const CameraBasis world = cameraBasis(camera);
  const RenderSpace& space = scene.space;
  CompiledFrame frame;
  frame.basis = world;
  frame.basis.eye = space.toRender(world.eye);
  if (world.orthographic) {
    frame.basis.corner = space.toRender(world.corner);
    frame.basis.du = world.du * space.scale;
    frame.basis.dv = world.dv * space.scale;
  }
  frame.width = camera.dimensions.x;
  frame.height = camera.dimensions.y;
  frame.samples = scene.settings.raysPerPixel;
  frame.number = number;
  frame.depth = depth;
  frame.worldPerRender = 1 / space.scale;

  const glm::dvec3 seen = scene.hi - scene.lo;
  const double farAway = std::min(kFarAway * std::max({1.0, seen.x, seen.y, seen.z}), kFarthest);
  const glm::dvec3 right = glm::normalize(world.du), up = glm::normalize(world.dv);
  for (const Light& light : scene.visualization.lighting.sources) {
    if (light.type == LightType::Directional) {
      const glm::dvec3 v =
          glm::length(light.v) > 0 ? glm::normalize(light.v) : glm::dvec3(1 / std::sqrt(3.0));
      frame.lights.push_back({0.f, float(v.x), float(v.y), float(v.z)});
    } else {
      const glm::dvec3 at = light.type == LightType::Point
                                ? light.v
                                : world.eye + light.v.x * right + light.v.y * up + light.v.z * world.view;
      const glm::dvec3 p = space.toRender(at);
      if (std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) < farAway) {
        frame.lights.push_back({1.f, float(p.x), float(p.y), float(p.z)});
      } else {
        // p cannot be used here, as it may be infinite.
        const double farthest = std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z)});
        const glm::dvec3 v = -glm::normalize(at / farthest - space.centre / farthest);
        frame.lights.push_back({0.f, float(v.x), float(v.y), float(v.z)});
      }
    }
  }
  return frame;
}

}  // namespace gxy
