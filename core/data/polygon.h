// SPDX-License-Identifier: Apache-2.0
// Polygons to triangles.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace gxy {

/// Appends the n - 2 triangles (numbers of corners) of a polygon of n corners, in order around it, oriented as it is; none for
/// fewer than three. The result depends on the corners only, so it is the same on every rank.
///
/// Convex polygons become a fan from corner 0; of a quad that is not planar the shorter diagonal is taken, as VTK does. Concave
/// ones are cut by ear clipping (Meisters 1975) in the plane of their normal (Newell's), whichever corner comes first. Corners may
/// repeat, as where a bridge leads to a hole. Of polygons that cross themselves, and where more than 1000 tests a corner were
/// needed, what is left when no ear is found is cut in the order of the corners.
void triangulate(std::span<const glm::dvec3> corners, std::vector<std::array<uint32_t, 3>>& triangles);

}  // namespace gxy
