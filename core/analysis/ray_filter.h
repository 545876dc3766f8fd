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

/// Rays of a camera, rays that are given one by one, rays from points, or uniformly distributed lines. Where they meet isosurfaces,
/// planes or triangles, or at equal distances, and conditions on other fields hold, there is a point. Other rays may begin there
/// (next_rays.h): they follow in generations, of which each begins when the one before has ended.
struct RaySampler {
  /// A range of values of a field.
  struct Condition {
    std::string field;  ///< an input
    double least = 0, largest = 0;
  };
  /// What follows the hit with which a ray ends; nothing unless it says so.
  struct Next {
    bool goesOn = false;   ///< it ends only with the most hits that it may have
    std::string redirect;  ///< the way that it goes on (ray_filter_keys.cpp)
    int spawn = 0;         ///< rays that begin there
    std::string field;     ///< an input: of gradients, or a vector field
    double n1 = 0, n2 = 0;
    glm::dvec3 direction{0};
    bool sphere = false, uniform = false;  ///< as in NextRule
  };
  /// What is met in one dataset.
  struct Target {
    std::string dataset;  ///< an input
    std::optional<int> component;
    std::vector<double> isovalues;
    std::vector<Plane> planes, clipPlanes;
    std::vector<Condition> conditions;
    double every = 0;         ///< world units; 0: none
    std::optional<int> hits;  ///< a ray that has as many hits ends here
    Next next;
  };

  std::vector<Target> operators;
  // One of these says where rays begin:
  int lines = 0;
  std::vector<SampleRay> rays;
  std::string points;             ///< an input
  glm::dvec3 direction{0, 0, 1};  ///< of rays from points, unless it is that of the field
  std::string directionField;     ///< an input; empty: none
  std::optional<Camera> camera;
  std::vector<std::string> values;  ///< the inputs whose values the points get; the first is shown
  bool gradient = false;            ///< points get the gradient of the volume that was met
  int depth = 1;                    ///< generations of rays that follow others
  int seed = 0;                     ///< of lines, and of rays that are spawned

  static FilterInfo info();
  static std::vector<KeyRow<RaySampler>> properties();
  FilterResult run(FilterRun& run) const;
};

}  // namespace gxy
