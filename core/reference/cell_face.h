// SPDX-License-Identifier: Apache-2.0
// Where a ray goes through the faces of hexahedra, wedges and pyramids: triangles and bilinear patches.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "core/data/mesh.h"
#include "core/reference/ray.h"

namespace gxy::reference {

/// What each of a cell's corners has, of at most eight.
using OfCorners = std::array<double, 8>;

/// A place where a ray goes through a face of a cell.
struct FaceMeeting {
  double t = 0;
  int sign =
      0;  ///< 1 where the face, as the cell has it, runs counterclockwise as seen along the ray's frame; else -1
  uint8_t corners = 0;              ///< 3 or 4
  std::array<uint8_t, 4> corner{};  ///< of the cell
  std::array<double, 4> weights{};  ///< of these corners, barycentric or bilinear; never negative

  /// What is linear or bilinear in the face and has these values at the cell's corners. It is not beyond those of the face, as rounding
  /// may put it.
  double mean(const OfCorners& values) const;
};

/// None, one or two meetings.
struct FaceMeetings {
  std::array<FaceMeeting, 2> meeting;
  size_t count = 0;
  const FaceMeeting* begin() const { return meeting.data(); }
  const FaceMeeting* end() const { return meeting.data() + count; }
};

/// Returns where a ray goes through a face. `seen` are the cell's corners in the ray's frame and `numbers` those of its points. All
/// results but `corner` and `sign` depend on the face's points and the order of their numbers alone, so they have the same bits in both
/// cells of the face.
///
/// The exact number of times that the face's border runs around the ray is the sum of the signs. Rays through edges and points count as
/// moved by an infinitesimal distance, like those of passageThrough(), so they go through exactly those faces around them that close
/// the surface. That sum is 1 or -1 if a bilinear face is passed once, and it says which root of the quadratic that is. If it is 0, the
/// face may bulge so that the ray passes it twice. Where the ray grazes the bulge, rounding decides whether it does.
FaceMeetings meet(const CellFace& face, std::span<const glm::dvec3> seen, std::span<const uint32_t> numbers);

}  // namespace gxy::reference
