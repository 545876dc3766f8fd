// SPDX-License-Identifier: Apache-2.0
// Which surface of a scene a point lies on.
#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <tuple>

#include "core/rays/compiled_scene.h"

namespace gxy::viewer {

/// A surface near a point. World units.
struct SurfaceAt {
  double distance = 0;   ///< of the point from the surface, about
  int32_t vis = 0;       ///< the operator's index
  uint64_t id = 0;       ///< of the primitive, or the index of the isovalue or, behind those, of the slice
  double value = 0;      ///< of the data there; NaN where the operator has none
  glm::dvec3 normal{0};  ///< unit; which way it points is left open; zero where the surface has none

  /// Which of two is taken; the same on whichever rank they were found.
  bool operator<(const SurfaceAt& o) const {
    return std::tie(distance, vis, id) < std::tie(o.distance, o.vis, o.id);
  }
};

/// The nearest to a world point of what this rank has: isosurfaces and slices where a block holds the point's cell and the points
/// around it, and geometry anywhere, that which the rank owns where the scene has compiled it. What clip planes or an opacity of 0 hide is left out. None where
/// there is nothing of these. Takes time in proportion to the primitives; in double, by closed forms.
std::optional<SurfaceAt> surfaceAt(const CompiledScene& scene, glm::dvec3 point);

}  // namespace gxy::viewer
