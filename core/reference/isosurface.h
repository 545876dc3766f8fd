// SPDX-License-Identifier: Apache-2.0
// Hits of a ray with an isosurface of the trilinear field.
#pragma once
#include <optional>

#include "core/reference/field.h"
#include "core/reference/ray.h"

namespace gxy::reference {

/// Returns the first t in `range`, and > `after`, at which the ray meets the surface field = isovalue, to the
/// precision of double. Cells are half-open along the ray (the last one before the border is closed), and
/// cells with samples without data are empty. A plateau at the isovalue is hit once, where the ray enters it
/// or where the ray starts in it. Asking again with `after` set to a result gives the next crossing of the
/// same ray, never the same one.
std::optional<double> firstRoot(const Field& field, const Ray& ray, double isovalue, Interval range = {},
                                double after = -kInfinity);

/// Returns the cell in which firstRoot found a root at t. On a face it is the cell that the ray leaves there
/// or, if that holds no data, the one behind.
Index3 cellMet(const Field& field, const Ray& ray, double t);

}  // namespace gxy::reference
