// SPDX-License-Identifier: Apache-2.0
// Particles, path lines and triangle meshes, kept per local partition.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/comm/advance.h"
#include "core/data/box.h"

namespace gxy {

/// The primitives of one partition: every one whose (inflated) box touches the partition, so borders cut
/// nothing. Positions are world coordinates in double. Ids are global: the same primitive has the same id
/// wherever it is.
struct GeometryBlock {
  std::vector<glm::dvec3> points;
  std::vector<glm::vec3> normals;   ///< per point, unit length; empty when the file has none
  std::vector<float> values;        ///< per point, the mapped scalar; empty when the file has none
  std::vector<glm::vec3> colors;    ///< per point, instead of values: red, green and blue, each 0 to 1
  std::vector<float> radiusValues;  ///< per point, the scalar that gives the radius; empty: `values` do
  std::vector<std::array<uint32_t, 3>> triangles;  ///< Triangles: point indices
  std::vector<std::array<uint32_t, 2>> segments;   ///< PathLines: point indices
  std::vector<std::array<uint32_t, 2>>
      neighbours;             ///< PathLines: per segment, point before and after (own end if none)
  std::vector<uint64_t> ids;  ///< per primitive (Particles: per point), ascending
  bool operator==(const GeometryBlock&) const = default;
};

enum class GeometryKind : uint8_t { Particles, PathLines, Triangles };

/// A distributed set of primitives. Immutable once complete; safe to read from any thread.
struct Geometry {
  std::string name;
  GeometryKind kind = GeometryKind::Particles;
  Box box;                              ///< of all points, world
  Range range;                          ///< of all values
  std::optional<Range> radiusRange;     ///< of the scalars that give radii, if these are not the values
  bool colored = false;                 ///< points have colours instead of values; the same on every rank
  uint64_t primitives = 0;              ///< over all partitions, each counted once
  uint64_t droppedPrimitives = 0;       ///< with non-finite coordinates, or degenerate
  std::map<int, GeometryBlock> blocks;  ///< by local partition
};

/// The scalar that gives the radius at a point; 0 where there is none.
double radiusValue(const GeometryBlock& block, size_t point);

/// Whether a block of this rank has values to map, be all of them NaN.
bool hasValues(const Geometry& geometry);

/// The points that define primitive p of a block: 1 (Particles), 2 (PathLines; neighbours are not among them)
/// or 3.
struct Corners {
  std::array<uint32_t, 3> points;
  int count;
  const uint32_t* begin() const { return points.data(); }
  const uint32_t* end() const { return points.data() + count; }
};
Corners cornersOf(const GeometryBlock& block, GeometryKind kind, size_t p);

/// Throws Error unless the block's arrays fit each other and the kind, and every index names a point.
void validate(const GeometryBlock& block, GeometryKind kind);

/// The chosen primitives (indices, in the order wanted) and the points that they refer to, in order of first
/// use.
GeometryBlock subset(
    const GeometryBlock& block, GeometryKind kind, std::span<const uint32_t> primitives,
    const Advance& advance = [](double) {});

/// All primitives of several valid blocks, ids ascending. Points equal in position, normal, value or colour, and radius
/// become one (never for Particles, where each point is a primitive) and are numbered in order of first use, so that
/// the result depends neither on the order of the parts nor on how primitives were spread over them. Throws
/// Error if an id comes twice, if only some parts have normals, values, colours or radii, or for 2^32 - 1 points or more.
GeometryBlock merged(
    GeometryKind kind, std::span<const GeometryBlock> parts, const Advance& advance = [](double) {});

/// Removes primitives that cannot be drawn: with a non-finite coordinate (neighbours' included), triangles without area,
/// and segments between points of a line that are equal in position, normal, value or colour, and radius (merged() makes these one,
/// which would be its own neighbour); the segments around them become neighbours. Returns how many. Other segments of no length
/// stay: they are round.
int64_t dropUnusable(GeometryBlock& block, GeometryKind kind);

/// Memory of the local blocks.
int64_t bytesOf(const Geometry& geometry);

/// The box of all points of a block, and the range of its values.
Box boxOf(const GeometryBlock& block);
Range rangeOf(const GeometryBlock& block);

/// The range of the scalars that give a block's radii, if these are not its values.
std::optional<Range> radiusRangeOf(const GeometryBlock& block);

}  // namespace gxy
