// SPDX-License-Identifier: Apache-2.0
// Particles, path lines and triangle meshes, stored per local partition.
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
#include "core/data/point_fields.h"

namespace gxy {

/// The primitives of one partition: all whose (inflated) bounding box touches it, so borders cut no primitive.
/// Positions are world coordinates in double. Ids are global: a primitive has the same id in every partition.
struct GeometryBlock {
  std::vector<glm::dvec3> points;
  std::vector<glm::vec3> normals;   ///< per point, unit length; empty if the file has none
  std::vector<float> values;        ///< per point, the mapped scalar; empty if the file has none
  std::vector<glm::vec3> colors;    ///< per point, instead of values: red, green and blue, each 0 to 1
  std::vector<float> radiusValues;  ///< per point, the scalar that gives the radius; empty: `values` give it
  std::vector<PointField>
      fields;  ///< per point, further ones; what is shown is `values` until another is asked for
  std::vector<std::array<uint32_t, 3>> triangles;  ///< Triangles: point indices
  std::vector<std::array<uint32_t, 2>> segments;   ///< PathLines: point indices
  /// PathLines: per segment, the line's points before and after it; at an end of the line, the segment's own end.
  std::vector<std::array<uint32_t, 2>> neighbours;
  std::vector<uint64_t> ids;  ///< per primitive (Particles: per point), ascending
  bool operator==(const GeometryBlock&) const = default;
};

enum class GeometryKind : uint8_t { Particles, PathLines, Triangles };

/// A distributed set of primitives. It is immutable once complete; any thread may read it.
struct Geometry {
  std::string name;
  GeometryKind kind = GeometryKind::Particles;
  Box box;                              ///< bounding box of all points, world coordinates
  Range range;                          ///< range of all values
  std::optional<Range> radiusRange;     ///< range of radiusValues; absent: the values give radii
  bool colored = false;                 ///< points have colours instead of values; the same on every rank
  uint64_t primitives = 0;              ///< number in all partitions, each counted once
  uint64_t droppedPrimitives = 0;       ///< number dropped: degenerate, or with non-finite coordinates
  std::map<int, GeometryBlock> blocks;  ///< by local partition
};

/// Returns the scalar that gives the radius at a point; 0 if there is none.
double radiusValue(const GeometryBlock& block, size_t point);

/// Whether a block of this rank has values to map, even if all of them are NaN.
bool hasValues(const Geometry& geometry);

/// The points that define primitive p of a block: 1 (Particles), 2 (PathLines, without neighbours) or 3
/// (Triangles).
struct PrimitivePoints {
  std::array<uint32_t, 3> points;
  int count;
  const uint32_t* begin() const { return points.data(); }
  const uint32_t* end() const { return points.data() + count; }
};
PrimitivePoints primitivePoints(const GeometryBlock& block, GeometryKind kind, size_t p);

/// Throws Error unless the block's arrays fit each other and the kind, and every index names a point.
void validate(const GeometryBlock& block, GeometryKind kind);

/// Returns the primitives with the given indices, in that order, and the points that they refer to, in
/// order of first use.
GeometryBlock subset(
    const GeometryBlock& block, GeometryKind kind, std::span<const uint32_t> primitives,
    const Advance& advance = [](double) {});

/// Returns all primitives of several valid blocks, by ascending id. Points that are equal in position,
/// normal, value or colour, radius and fields become one, except for Particles, where each point is a primitive.
/// Points are numbered in order of first use. So the result depends neither on the order of the parts nor on
/// how primitives were spread over them. Throws Error if an id comes twice, if only some parts have normals,
/// values, colours or radii, if fields have different names or components, or for 2^32 - 1 points or more.
GeometryBlock merged(
    GeometryKind kind, std::span<const GeometryBlock> parts, const Advance& advance = [](double) {});

/// Removes primitives that cannot be drawn, and returns their number. These are primitives with a non-finite
/// coordinate (that of a neighbour included), triangles without area, and segments of a line between points
/// that are equal in position, normal, value or colour, radius and fields: merged() would make their points one,
/// which would be its own neighbour. The segments around a removed one become neighbours. Other segments of
/// length zero stay and are drawn as balls.
int64_t dropUnusable(GeometryBlock& block, GeometryKind kind);

/// Memory of the local blocks in bytes.
int64_t bytesOf(const Geometry& geometry);

/// The bounding box of all points of a block, and the range of its values.
Box boxOf(const GeometryBlock& block);
Range rangeOf(const GeometryBlock& block);

/// Whether a field of a block has the name of its values, `array`, and one component: where both are written, it is left out.
bool repeatsValues(const GeometryBlock& block, const PointField& field, const std::string& array);

/// The range of a block's radiusValues; nothing if the values give the radii.
std::optional<Range> radiusRangeOf(const GeometryBlock& block);

}  // namespace gxy
