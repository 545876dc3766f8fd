// SPDX-License-Identifier: Apache-2.0
// Changes the range of values of an operator's maps, in steps.
#pragma once
#include <array>
#include <optional>

#include "core/scene/scene.h"

namespace gxy {

/// Returns the operator's data range; if it has none, the range that the points of its maps span together.
/// Returns nothing if both maps are constant.
std::optional<std::array<double, 2>> dataRangeOf(const Vis& vis);

/// Makes the range `factor` times as wide around its middle, then moves it by `shift` times its new width. If
/// the operator has no data range, it gets one, in such a way that factor 1 and shift 0 would change no
/// colour or opacity. Returns false if both maps are constant.
bool changeDataRange(Vis& vis, double factor, double shift);

}  // namespace gxy
