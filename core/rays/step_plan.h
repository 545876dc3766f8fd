// SPDX-License-Identifier: Apache-2.0
// Step plans: for each macrocell, whether to skip it, or how finely and by which method to integrate it.
#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/data/volume.h"
#include "core/rays/compiled_map.h"

namespace gxy {

/// The method by which a macrocell's segments are integrated.
enum class Integrator { Midpoint, ByCells };

/// The part of the tolerance that rays may leave behind where they end early. A small part costs few
/// segments.
inline constexpr double kEarlyEnd = 1 / 16.0;

/// Packs the plan of one macrocell, as kernels/volume.h reads it. Segments are at most 3.9 cells long, so
/// that what the next one depends on lies within the ghost layers of the partition that evaluates it. Cell by
/// cell, segments are longer in cells whose values lie within one interval of the map: their number per cell
/// length is halved as long as it stays at least `within` and a cell has more than one.
int32_t planOf(double segmentsPerCell, Integrator integrator,
               double within = std::numeric_limits<double>::infinity());

/// Plans every macrocell from its summary alone, so that all partitions and ranks agree.
///
/// The error of a ray is estimated from h, the length of segments in cells; m, the macrocell's summary; f,
/// the map over its range; and N, the number of cells to optical depth 1 (at most those across the volume).
/// All extinctions are per cell.
///
///   midpoint         h^2 (0.015 B + m.steep max(0.027 f.bend sqrt(c), 0.055 f.kink, f.curve c / 24)
///                         + m.steep f.shade / 10)
///   pre-integrated   h^2 (0.09 B + 0.9 f.jump)
///
/// B = f.slope m.bend sqrt(N l) is the effect of the field's curvature, in runs of l = (m.steep / m.bend)^2
/// cells whose errors have one sign. l is at least 32 / N, since few cells even out less, at least 1, and at
/// most 4 N. c = N m.steep / (m.max - m.min) is the number of times that the ray crosses the range.
///
/// h is chosen so that the error is 0.84 of the tolerance: early termination takes a sixteenth of it, and a
/// tenth is kept for the worst of very many rays. The method that costs less is taken. Steps of the map are
/// integrated cell by cell, where f.jump counts only for cells that meet one. If the volume is the only one,
/// 0.2 f.jump is enough, as segments with a step are halved by what it matters; and if its map has at most
/// MAP_SMALL intervals, f.jump counts nothing, because steps are met exactly.
///
/// 1/24 is the coefficient of the rule for errors of one sign (Davis & Rabinowitz 1984, 2.1). 1/10 takes its
/// 1/12 for rays that run along no axis. The other constants hold for rays through fields from smooth to
/// white noise under five shapes of maps (tests/rays/step_plan_test.cpp).
///
/// On grids of few cells across, a ray is too short for its errors to even out. With w = min(1, 32 / cells
/// across)^2, the kink's coefficient goes by the part w towards 1/8, that of the worst place of a kink in its
/// segment, and the pre-integrated error counts 1 + 3 w times.
///
/// If several volumes are rendered at once, `others` is the largest extinction of the others together, per
/// unit of t. Midpoint segments then hold extinction constant (kernels/multi_volume.h), and the others are seen
/// through a segment's front before its back. That adds f.slope m.steep min(1, 1.7 others) / 24.
///
/// `step` > 0 (in cells) asks for midpoint segments of that length wherever something is seen. `cellT` is the
/// length of a cell in t. The result has one plan per element of `summaries`; 0 means that nothing is seen.
std::vector<int32_t> stepPlan(std::span<const Macrocell> summaries, const CompiledMap& map, double cellT,
                              double tolerance, double step, std::optional<double> others = {});

}  // namespace gxy
