// SPDX-License-Identifier: Apache-2.0
// Boxes of grid points: what two of them share, and how samples are copied from one into another.
#pragma once
#include <cstddef>
#include <span>

#include "core/data/volume.h"

namespace gxy {

/// Returns the points that two extents share; count 0 if there are none.
Extent intersection(const Extent& a, const Extent& b);

/// Copies the points of `box`, which both extents contain, from samples laid out as `from` to samples
/// laid out as `to`. Samples are laid out x fastest; the components of a point stand together.
void copyBox(const Extent& box, std::span<const std::byte> source, const Extent& from,
             std::span<std::byte> target, const Extent& to, size_t bytesPerPoint);

}  // namespace gxy
