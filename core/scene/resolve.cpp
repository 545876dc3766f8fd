// SPDX-License-Identifier: Apache-2.0
#include "core/scene/resolve.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "core/scene/camera.h"

namespace gxy {
namespace {

/// A name that is no further field is that of the values, or there is no such array, which is told where it is shown.
Range rangeOf(const Vis& vis, const DataFacts& facts) {
  const auto field = facts.fields.find(vis.array);
  const std::vector<Range>& ranges = field == facts.fields.end() ? facts.ranges : field->second;
  if (ranges.empty()) return {};
  const bool ofComponent = vis.component && (vis.type == VisType::Volume || !vis.array.empty());
  const size_t chosen = ofComponent ? size_t(*vis.component) : ranges.size() - 1;
  return chosen < ranges.size() ? ranges[chosen] : Range{};
}

double longestSide(const Box& box) {
  const glm::dvec3 side = box.hi - box.lo;
  return std::max({side.x, side.y, side.z});
}

void resolveRadius(Vis& vis, const DataFacts& facts) {
  double radius = facts.spacing * kRadiusOfSpacing;
  if (!(radius > 0)) radius = facts.middle.empty() ? 1 : longestSide(facts.middle) / 50;
  if (!(radius > 0)) radius = 1;  // There is only one point.
  vis.radius0 = vis.radius1 = radius;
  vis.value0 = vis.value1 = 0;
}

Box inflated(Box box, double by) {
  if (!box.empty() && by > 0) box.lo -= by, box.hi += by;
  return box;
}

/// The eye positions from which all points passed to see() are inside the field of view, in one direction across
/// the view. An eye at (across, depth) sees them all if a + tangent * depth <= across <= b - tangent * depth.
/// depth() is the largest depth along the view at which that is possible, and across() the position there.
struct Side {
  double tangent;
  double a = -std::numeric_limits<double>::infinity(), b = std::numeric_limits<double>::infinity();

  void see(double across, double depth) {
    a = std::max(a, across - tangent * depth);
    b = std::min(b, across + tangent * depth);
  }
  double depth() const { return (b - a) / (2 * tangent); }
  double across() const { return (a + b) / 2; }
};

}  // namespace

Visualization resolved(Visualization visualization, std::span<const DataFacts> facts, ShownSoFar& shown) {
  shown.ranges.resize(visualization.operators.size());
  for (size_t i = 0; i < visualization.operators.size(); i++) {
    Vis& vis = visualization.operators[i];
    const bool round = vis.type == VisType::Particles || vis.type == VisType::PathLines;
    Range& range = shown.ranges[i];
    range.extend(rangeOf(vis, facts[i]));
    if (vis.rangeOfData) {
      if (!range.empty()) vis.dataRange = {range.min, range.max};
      vis.rangeOfData = false;
    }
    if (vis.radiusOfData) {
      if (round) resolveRadius(vis, facts[i]);
      vis.radiusOfData = false;
    }
    shown.box.extend(inflated(facts[i].middle, round ? std::max(vis.radius0, vis.radius1) : 0));
  }
  return visualization;
}

Camera fitted(Camera camera, const Box& box) {
  if (!camera.fit) return camera;
  camera.fit = false;
  Box seen = box.empty() ? Box{glm::dvec3(-0.5), glm::dvec3(0.5)} : box;
  if (longestSide(seen) == 0) seen = inflated(seen, 0.5);
  const CameraBasis basis = cameraBasis(camera);
  const glm::dvec3 right = glm::normalize(basis.du), up = glm::normalize(basis.dv);
  const glm::dvec3 centre = (seen.lo + seen.hi) / 2.0;
  const glm::dvec2 aspect =
      glm::dvec2(camera.dimensions) / double(std::min(camera.dimensions.x, camera.dimensions.y));

  const double tangent = basis.orthographic ? 1 : std::tan(camera.aov * (std::numbers::pi / 180) / 2);
  Side x{tangent * aspect.x * kFittedPart}, y{tangent * aspect.y * kFittedPart};
  double nearest = std::numeric_limits<double>::infinity();
  glm::dvec2 half(0);
  for (int corner = 0; corner < 8; corner++) {
    const glm::dvec3 p = glm::dvec3(corner & 1 ? seen.hi.x : seen.lo.x, corner & 2 ? seen.hi.y : seen.lo.y,
                                    corner & 4 ? seen.hi.z : seen.lo.z) -
                         centre;
    const double depth = glm::dot(p, basis.view);
    x.see(glm::dot(p, right), depth);
    y.see(glm::dot(p, up), depth);
    nearest = std::min(nearest, depth);
    half = glm::max(half, glm::abs(glm::dvec2(glm::dot(p, right), glm::dot(p, up))));
  }
  if (basis.orthographic) {
    const double extent = 2 * std::max(half.x / aspect.x, half.y / aspect.y) / kFittedPart;
    camera.height = extent > 0 ? extent : longestSide(seen);  // The box is a line seen from its end.
    camera.viewpoint = centre + basis.view * (nearest - longestSide(seen));
  } else {
    const double depth = std::min({x.depth(), y.depth(), nearest - longestSide(seen) / 100});
    camera.viewpoint = centre + right * x.across() + up * y.across() + basis.view * depth;
  }
  return camera;
}

Camera defaultCamera() {
  Camera camera;
  camera.fit = true;
  camera.viewdirection = {-0.45, -0.35, -0.8};
  return camera;
}

}  // namespace gxy
