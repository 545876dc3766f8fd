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
/// The errors of segments of h cells add up over the N cells that a ray sees (until it is opaque, or has crossed the
/// volume) to about 0.035 V h^2 sqrt(N), where V = (largest slope of the map over the macrocell's range) x (that range) x
/// (t of a cell). Where the map has a step inside the range, is sharp against its extinction or is dense, segments end at
/// cell faces and are pre-integrated along the map (PLAN_PIECES): 0.015 V h^2 sqrt(N) + 1.4 J h^2, J the step's optical
/// depth per cell. h is chosen so that this is 3/4 of the tolerance; early termination takes the rest. The constants are
/// measured (tests/accuracy/step_plan.cpp: turbulence and Marschner-Lobb under five shapes of maps).
std::vector<uint8_t> stepPlan(std::span<const Macrocell> summaries, const CompiledMap& map, double cellT,
                              double tolerance, bool fixedStep);

/// 1 for every macrocell whose range holds one of the isovalues (stored units).
std::vector<uint8_t> isoPlan(std::span<const Macrocell> summaries, std::span<const float> isovalues);

}  // namespace gxy
