// SPDX-License-Identifier: Apache-2.0
// The filter RaySampler: points where rays meet surfaces.
#pragma once
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/analysis/filter.h"
#include "core/analysis/ray_source.h"

namespace gxy {

/// Rays of a camera, rays that are given one by one, rays from points in one direction, or uniformly distributed lines. Where
/// they meet isosurfaces, planes or triangles, and conditions on other fields hold, there is a point.
struct RaySampler {
  /// A range of values of a field.
  struct Condition {
    std::string field;  ///< an input
    double least = 0, largest = 0;
  };
  /// What is met in one dataset.
  struct Target {
    std::string dataset;  ///< an input
    std::optional<int> component;
    std::vector<double> isovalues;
    std::vector<Plane> planes, clipPlanes;
    std::vector<Condition> conditions;
    int hits = 1;  ///< a ray that has as many hits ends here
  };

  std::vector<Target> operators;
  // One of these says where rays begin:
  int lines = 0;
  std::vector<SampleRay> rays;
  std::string points;             ///< an input
  glm::dvec3 direction{0, 0, 1};  ///< of rays from points
  std::optional<Camera> camera;
  std::vector<std::string> values;  ///< the inputs whose values the points get; the first is shown
  bool gradient = false;            ///< points get the gradient of the volume that was met
  int seed = 0;                     ///< of lines

  static FilterInfo info();
  static std::vector<KeyRow<RaySampler>> properties();
  FilterResult run(FilterRun& run) const;
};

}  // namespace gxy
