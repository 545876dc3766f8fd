// SPDX-License-Identifier: Apache-2.0
// Blocks of geometry one after the other, with little more memory than they have.
#pragma once
#include <vector>

#include "core/data/geometry.h"

namespace gxy {

/// To which points the indices of a part refer: to those of the part, or to those of all parts up to it.
enum class Indices { OfPart, OfAll };

/// Returns the points and primitives of all parts, in their order. Array by array is joined, and then freed in the parts, so
/// that at most one array is in memory twice. One part alone is returned as it is. Throws Error if only some of the parts
/// with points have normals, values, colours or radii, if fields have different names or components, or for 2^32 - 1 points
/// or more.
GeometryBlock joined(GeometryKind kind, std::vector<GeometryBlock> parts, Indices indices = Indices::OfPart);

/// merged() of all blocks of which `parts` is joined, in place of them.
GeometryBlock merged(
    GeometryKind kind, GeometryBlock&& parts, const Advance& advance = [](double) {});

/// Orders particles by their ids, array by array.
void sortById(GeometryBlock& particles);

}  // namespace gxy
