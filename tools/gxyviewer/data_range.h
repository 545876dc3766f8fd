// SPDX-License-Identifier: Apache-2.0
// The values over which an operator's maps run, changed by steps.
#pragma once
#include <array>
#include <optional>

#include "core/scene/scene.h"

namespace gxy {

/// The range of its maps; where it has no `data range`, the ends of its maps together. None where no map varies.
std::optional<std::array<double, 2>> dataRangeOf(const Vis& vis);

/// Makes the range `factor` times as wide about its middle, and then moves it by `shift` times its width. Where it was not said,
/// it is from now on, and each value keeps its colour and opacity but for the change. False where no map varies.
bool changeDataRange(Vis& vis, double factor, double shift);

}  // namespace gxy
