// SPDX-License-Identifier: Apache-2.0
#include "core/scene/first_look.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "core/scene/colormaps.h"

namespace gxy {
namespace {

constexpr double kFlat = 0.02;  // A side up to this fraction of the longest one is flat.

double diagonal(const Box& box) { return box.empty() ? 1 : std::max(glm::length(box.hi - box.lo), 1e-300); }

/// Adds the three slices through the middle, or for an image the one slice that shows it.
void showSlices(Vis& vis, const LookFacts& facts) {
  const glm::dvec3 centre = (facts.data.box.lo + facts.data.box.hi) / 2.0;
  for (int a = 0; a < 3; a++) {
    if (a != facts.thin.value_or(a)) continue;
    Plane plane{glm::dvec3(0), centre[a]};
    plane.normal[a] = 1;
    vis.slices.push_back(plane);
  }
}

void showVolume(Vis& vis, const LookFacts& facts, const LookOptions& options) {
  const FirstMaps maps = firstMaps(facts.values, diagonal(facts.data.box) / std::sqrt(3));
  vis.colormap = maps.colors;
  vis.rangeOfData = !facts.values.empty();
  vis.isovalues = options.isovalues;
  if (options.autoIsovalue) vis.isovalues.push_back(firstIsovalue(facts.values));
  if (options.slice || (facts.thin && vis.isovalues.empty())) showSlices(vis, facts);
  vis.volumeRendering = vis.isovalues.empty() && vis.slices.empty();
  if (vis.volumeRendering) {
    vis.opacitymap = maps.opacities;
    vis.referenceLength = maps.referenceLength;
  } else if (vis.isovalues.size() == 1 && vis.slices.empty()) {
    vis.colormap.points = {
        {vis.isovalues[0], glm::dvec3(0.95, 0.87, 0.73)}};  // The dark end of the map would hide the shape.
    vis.rangeOfData = false;
  } else if (vis.slices.empty()) {
    vis.colormap = *shippedColorMap("Viridis");
  }
}

void showGeometry(Vis& vis, const LookFacts& facts) {
  vis.radiusOfData = vis.type != VisType::Triangles;
  vis.colormap = firstSurfaceColors(facts.values);
  vis.rangeOfData = vis.colormap.points.size() > 1;
}

/// Surfaces are lit by a light at the camera and by a little ambient light.
Lighting firstLighting(const Box& box) {
  Lighting lighting;
  const double far = diagonal(box);
  lighting.sources = {{LightType::Camera, glm::dvec3(-0.3, 0.4, 0) * far}};
  lighting.Ka = 0.3;
  lighting.Kd = 0.75;
  lighting.aoCount = 4;
  lighting.aoRadius = far / 10;
  return lighting;
}

/// Flat data are seen along their flat side. If the only dataset is an image, `image` is its thin axis.
Camera firstCamera(const Box& box, std::optional<int> image) {
  Camera camera = defaultCamera();
  if (box.empty()) return camera;
  const glm::dvec3 side = box.hi - box.lo;
  const double longest = std::max({side.x, side.y, side.z});
  const auto flat = [&](int a) { return image ? a == *image : side[a] <= kFlat * longest; };
  if (flat(2)) {
    camera.viewdirection = {0, 0, -1};
  } else if (flat(1)) {
    camera.viewdirection = {0, -1, 0};
    camera.viewup = {0, 0, -1};
  } else if (flat(0)) {
    camera.viewdirection = {-1, 0, 0};
  }
  return camera;
}

}  // namespace

State firstLook(std::span<const LookFacts> data, const LookOptions& options) {
  State state;
  Visualization& visualization = state.visualizations.emplace_back();
  Box box;
  bool surfaces = false;
  for (const LookFacts& facts : data) {
    state.datasets.push_back(facts.dataset);
    Vis& vis = visualization.operators.emplace_back();
    vis.type = VisType(facts.dataset.type);
    vis.dataset = facts.dataset.name;
    if (vis.type == VisType::Volume)
      showVolume(vis, facts, options);
    else
      showGeometry(vis, facts);
    surfaces = surfaces || !vis.volumeRendering;
    box.extend(facts.data.middle);
  }
  if (surfaces) visualization.lighting = firstLighting(box);
  state.settings.raysPerPixel = surfaces ? 9 : 4;
  state.settings.background = {0.1, 0.1, 0.11, 1};
  state.cameras.push_back(firstCamera(box, data.size() == 1 ? data[0].thin : std::nullopt));
  return state;
}

}  // namespace gxy
