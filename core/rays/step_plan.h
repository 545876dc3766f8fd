// SPDX-License-Identifier: Apache-2.0
// Per macrocell: skip it, or how finely and by which method to integrate it (kernels/volume.h's plan byte).
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "gxy/data/volume.h"
#include "gxy/rays/compiled_map.h"

namespace gxy {

/// The ladder of sampling rates, in segments per cell length: rates[0] is unused, rates[l] = 2^((l - 1) / 4) * 0.2625.
/// With a fixed step > 0 (in cells) all are 1 / step, for steps of 3.8 cells at most: the ghost layers allow no longer ones.
std::array<float, 32> planRates(double fixedStep);

/// The plan of every macrocell, from its value range alone, so that all partitions and ranks agree.
///
/// The error that midpoint segments of h cells leave on a pixel was measured (docs/decisions/0002) to stay below
/// 0.025 V h^2, where V = (largest slope of the map over the macrocell's range) x (that range) x (t of a cell); h is
/// chosen so that this is 3/4 of the tolerance, early termination takes the rest. Where the map has a step inside the
/// range, segments are pre-integrated along the map (PLAN_PIECES), since midpoint is of first order there.
std::vector<uint8_t> stepPlan(std::span<const Macrocell> summaries, const CompiledMap& map, double cellT,
                              double tolerance, bool fixedStep);

/// 1 for every macrocell whose range holds one of the isovalues (stored units).
std::vector<uint8_t> isoPlan(std::span<const Macrocell> summaries, std::span<const float> isovalues);

}  // namespace gxy
