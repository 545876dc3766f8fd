// SPDX-License-Identifier: Apache-2.0
// Copies of the simulation's arrays.
#pragma once
#include <cstddef>

#include "core/data/volume.h"
#include "insitu/api/galaxy_insitu.h"

namespace gxy::insitu {

/// Copies the values of the points `points` of a block, whose first point is `first`, to `out`: x fastest, the components of a
/// point together. `out` has room for points.count() points.
void copyPoints(const gxy_array& values, const Index3& first, const Extent& points, std::byte* out);

}  // namespace gxy::insitu
