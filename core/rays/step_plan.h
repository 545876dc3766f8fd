// SPDX-License-Identifier: Apache-2.0
// Per macrocell: skip it, or how finely and by which method to integrate it.
#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/data/volume.h"
#include "core/rays/compiled_map.h"

namespace gxy {

/// How a macrocell's segments are integrated.
enum class Integrator { Midpoint, ByCells };

/// The share of the tolerance that rays may leave behind where they end early. A small one costs few segments.
inline constexpr double kEarlyEnd = 1 / 16.0;

/// A plan as kernels/volume.h reads it. Segments are at most 3.9 cells long: what the next depends on lies within the
/// ghost layers of the partition that evaluates it. Cell by cell, segments of cells whose values lie within one interval of
/// the map are longer: at least `within` a cell length, where that is more than one a cell.
int32_t planOf(double segmentsPerCell, Integrator integrator,
               double within = std::numeric_limits<double>::infinity());

/// The plan of every macrocell, from its summary alone, so that all partitions and ranks agree.
///
/// With h the length of segments in cells, m the macrocell's summary, f the map over its range, N the cells to optical
/// depth 1 (at most those across the volume), and all extinctions per cell, the error of a ray is estimated as
///
///   midpoint         h^2 (0.015 B + m.steep max(0.027 f.bend sqrt(c), 0.055 f.kink, f.curve c / 24)
///                         + m.steep f.shade / 10)
///   pre-integrated   h^2 (0.09 B + 0.9 f.jump)
///
/// where B = f.slope m.bend sqrt(N l) is what the field's curvature does, in runs of l = (m.steep / m.bend)^2 cells that
/// err alike (at least 32 / N, as few cells even out less; at least 1, at most 4 N), and c = N m.steep / (m.max - m.min)
/// the number of times that the ray crosses the range. h makes this 0.84 of the tolerance (early termination takes a
/// sixteenth, a tenth is for the worst of very many rays), and the method is the one that costs less; steps of the map are
/// integrated cell by cell, where f.jump counts only for cells that meet one. Of the only volume 0.2 f.jump is enough, as
/// segments with a step are halved by what it matters, and nothing where its map has at most MAP_SMALL intervals: there
/// steps are met exactly. 1/24 is the coefficient of the rule for
/// errors of one sign (Davis & Rabinowitz 1984, 2.1), 1/10 takes its 1/12 for rays that run along no axis; the constants
/// here hold for rays through fields from smooth to white noise under five shapes of maps (tests/rays/step_plan_test.cpp).
///
/// On grids of few cells across a ray is too short for its errors to even out. With w = min(1, 32 / cells across)^2, the
/// kink's coefficient is by the part w that of the worst place of a kink in its segment, 1/8, and the pre-integrated error
/// counts 1 + 3 w times.
///
/// Where several volumes are rendered at once, `others` is the largest extinction of the others together, per unit of t.
/// Midpoint segments then hold extinction constant (kernels/many.h), and the others are seen through their front before
/// their back: that adds f.slope m.steep min(1, 1.7 others) / 24.
///
/// A step > 0 (in cells) asks for midpoint segments of that length wherever something is seen.
std::vector<int32_t> stepPlan(std::span<const Macrocell> summaries, const CompiledMap& map, double cellT,
                              double tolerance, double step, std::optional<double> others = {});

}  // namespace gxy
