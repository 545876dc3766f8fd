// SPDX-License-Identifier: Apache-2.0
// Cuts polygons into triangles.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace gxy {

/// Appends the n - 2 triangles of a polygon of n corners, as indices of corners, with the polygon's
/// orientation. `corners` are in order around the polygon. Fewer than three corners give no triangle. The
/// result depends on the corners only, so it is the same on every rank.
///
/// A convex polygon becomes a fan from corner 0, but a quad that is not planar is cut along its shorter
/// diagonal, as VTK does. A concave polygon is cut by ear clipping (Meisters 1975) in the plane of its Newell
/// normal. Corners may repeat, for example where a bridge leads to a hole. If no ear is found (the polygon
/// crosses itself), or after 1000 tests per corner, the rest is cut in the order of the corners.
void triangulate(std::span<const glm::dvec3> corners, std::vector<std::array<uint32_t, 3>>& triangles);

}  // namespace gxy
