// SPDX-License-Identifier: Apache-2.0
// Particles, path lines and triangle meshes, kept per local partition.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <string>
#include <vector>

#include "gxy/data/box.h"

namespace gxy {

/// Named per-point scalars, one value a point. `values` runs parallel to the points of its block.
struct PointArray {
  std::string name;
  std::vector<float> values;
};

/// The primitives of one partition: every one whose (inflated) box touches the partition, so borders cut
/// nothing. Positions are world coordinates in double. Ids are global: the same primitive has the same id
/// wherever it is.
struct GeometryBlock {
  std::vector<glm::dvec3> points;
  std::vector<glm::vec3> normals;  ///< per point, unit length; empty when the file has none
  std::vector<float> values;       ///< per point, the mapped scalar; empty when the file has none
  std::vector<std::array<uint32_t, 3>> triangles;  ///< Triangles: point indices
  std::vector<std::array<uint32_t, 2>> segments;   ///< PathLines: point indices
  std::vector<std::array<uint32_t, 2>>
      neighbours;             ///< PathLines: per segment, point before and after (own end if none)
  std::vector<uint64_t> ids;  ///< per primitive (Particles: per point), ascending
};

enum class GeometryKind : uint8_t { Particles, PathLines, Triangles };

/// A distributed set of primitives. Immutable once complete; safe to read from any thread.
struct Geometry {
  std::string name;
  GeometryKind kind = GeometryKind::Particles;
  Box box;                              ///< of all points, world
  Range range;                          ///< of all values
  uint64_t primitives = 0;              ///< over all partitions, each counted once
  uint64_t droppedPrimitives = 0;       ///< with non-finite coordinates, or degenerate
  std::map<int, GeometryBlock> blocks;  ///< by local partition
};

}  // namespace gxy
