// SPDX-License-Identifier: Apache-2.0
// Copies of the simulation's arrays.
#pragma once
#include <cstddef>

#include "core/data/volume.h"
#include "insitu/api/galaxy_insitu.h"

namespace gxy::insitu {

/// Copies the values of the points `points` to `out`: x fastest, the components of a point together. `values` are those of the points
/// `block`; points beside it get the value of the nearest point in it. `out` has room for points.count() points.
void copyPoints(const gxy_array& values, const Extent& block, const Extent& points, std::byte* out);

/// Does the same with doubles, and stores them as floats: (value - shift) / scale in double, rounded once. A finite value that float cannot
/// hold becomes the largest float. The scale is a power of two whose inverse is exact.
void copyPointsAsFloats(const gxy_array& values, const Extent& block, const Extent& points, double shift,
                        double scale, std::byte* out);

}  // namespace gxy::insitu
