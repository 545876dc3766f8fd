// SPDX-License-Identifier: Apache-2.0
// The cells of one rank of a simulation: whether they are such that can be shown.
#pragma once
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <string>

#include "core/data/cells.h"
#include "insitu/plan/description.h"

namespace gxy::insitu {

/// Stands for an offset or a point's number that 32 bits cannot hold.
inline constexpr uint32_t kNoPlace = std::numeric_limits<uint32_t>::max();

/// The arrays of the cells of one rank as they are sent. Nothing is known of their content.
struct Cells {
  uint64_t points = 0;                     ///< how many the rank has
  std::span<const uint8_t> types;          ///< VTK's, by cell
  std::span<const uint32_t> ends;          ///< by cell: where its corners end in `connectivity`
  std::span<const uint32_t> connectivity;  ///< by corner: the number of its point

  size_t count() const { return types.size(); }
  /// The points of a cell, once they are checked.
  std::span<const uint32_t> corners(size_t cell) const {
    const size_t begin = cell == 0 ? 0 : ends[cell - 1];
    return connectivity.subspan(begin, ends[cell] - begin);
  }
};

/// Returns what cells of a type of VTK become. Throws Error, which begins with `what`, for those that are not taken.
Mesh::Shape shapeOf(int type, const std::string& what);

/// The number of points of each cell of a type that is taken; 0 if they have any number.
size_t pointsOfEach(int type);

/// Returns what the cells become; Unknown if there are none. Throws Error, which begins with `what` and names the cell, unless all
/// become `shape` (Unknown: the same), their corners follow each other in `connectivity` and fill it, each has as many as its type
/// needs, and the points that they name exist and are finite.
Mesh::Shape check(const Cells& cells, Mesh::Shape shape, const std::string& what,
                  const std::function<glm::dvec3(size_t point)>& position);

/// How many segments or triangles there are, of cells that become such.
uint64_t primitivesOf(const Cells& cells);

}  // namespace gxy::insitu
