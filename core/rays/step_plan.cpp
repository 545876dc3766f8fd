// SPDX-License-Identifier: Apache-2.0
#include "core/rays/step_plan.h"

#include <algorithm>
#include <cmath>

#include "core/kernels/single.h"

namespace gxy {

namespace {
// Segments per cell length that give one per cell, whose diagonal is sqrt(3) long.
constexpr double kOnePerCell = 0.57;
constexpr double kLongest = PLAN_REACH;
static_assert(kLongest < kGhostLayers - 0.09);  // rounding may ask for a little more
constexpr double kLowestRate = 1 / kLongest, kHighestRate = 256;

constexpr double kBendMidpoint = 0.015, kBendPieces = 0.09;
constexpr double kBendOfMap = 0.027, kKinkOfMap = 0.055;
// 1/12 along an axis; along other rays the slope may be larger than along each axis.
constexpr double kShade = 0.1;
constexpr double kJump = 0.9, kHalvedJump = 0.2;
constexpr double kUnforeseen = 0.1;  // part of the tolerance kept for the worst of very many rays
constexpr double kMostJump = 2;      // optical depth per cell; a larger step hides what is behind it
constexpr double kThinnest = 0.2;    // least part of a cell, or of a kink, that is seen
constexpr double kMostDepth = 1;    // largest optical depth of a midpoint segment, whose front hides its back
constexpr double kCostOfCells = 8;  // time of a cell length cell by cell, in times of a midpoint segment

constexpr double kLongestRay = 1.7;  // diagonal of a cube whose side is 1 in t
constexpr double kFew = 32;          // cells over which errors of random sign even out
// The same coefficients where rays are too short for that.
constexpr double kWorstKink = 0.125, kWorstPieces = 4;

// Errors of segments of h cells, divided by h^2. `within` is that of pieces where the map has no step.
// `jumpError` is the coefficient of a step within a piece.
struct Errors {
  double midpoint = 0, pieces = 0, within = 0;
};
Errors errorsOf(const Macrocell& m, const CompiledMap::Over& map, double jumpError, double cellT) {
  const double range = double(m.max) - m.min;
  const double depth = 1 / (map.extinction * cellT);                               // cells to optical depth 1
  const double seen = std::clamp(depth, 1.0, std::max(1.0, kLongestRay / cellT));  // or across the volume
  const double ratio = m.bend > 0 ? double(m.steep) / m.bend : 1;
  const double correlationLength =
      std::clamp(ratio * ratio, std::max(1.0, std::min(seen, kFew / seen)), 4 * seen);
  const double bend =
      map.slope * m.bend * std::clamp(depth, kThinnest, 1.0) * std::sqrt(seen * correlationLength);
  const double crossings = range > 0 ? std::max(1.0, seen * m.steep / range) : 1;
  // Errors have one sign where the field runs along the map, and the map is curved rather than bent back and
  // forth.
  const double smooth = map.curve * crossings / 24;
  const double across = std::max(1.0, kLongestRay / cellT),
               shortRayWeight = std::min(1.0, kFew * kFew / (across * across));
  const double kink = kKinkOfMap + shortRayWeight * (kWorstKink - kKinkOfMap);
  // In dense material a slope change of the map is hidden by the material in front of it, which looks like
  // that behind it.
  auto visible = [&](double all, double dense) {
    return std::min(all, std::max(dense / (cellT * cellT), kThinnest * all));
  };
  const double bendOfMap = visible(map.bend - map.curve, map.denseBend) + map.curve;
  const double kinkOfMap = visible(map.kink, map.denseKink);
  const double kinks =
      m.steep * std::max({kBendOfMap * bendOfMap * std::sqrt(crossings), kink * kinkOfMap, smooth});
  // The front of a segment hides its back, so the colour is seen from nearer than its middle.
  const double shade = m.steep * map.shade * std::min(1.0, seen / depth) * kShade;
  const double piecesWeight = 1 + shortRayWeight * (kWorstPieces - 1);
  const double within = piecesWeight * cellT * kBendPieces * bend;
  const double jumps = piecesWeight * jumpError * std::min(map.jump * cellT, kMostJump);
  return {cellT * (kBendMidpoint * bend + kinks + shade), within + jumps, within};
}

}  // namespace

int32_t planOf(double segmentsPerCell, Integrator integrator, double within) {
  const double rate = segmentsPerCell > kLowestRate ? std::min(segmentsPerCell, kHighestRate) : kLowestRate;
  const int32_t length = int32_t(PLAN_UNIT / rate) << PLAN_BITS;
  if (integrator == Integrator::Midpoint) return length;
  int longer = 0;
  while (longer < PLAN_MOST_LONGER && rate / (1 << longer) > kOnePerCell && rate / (2 << longer) >= within)
    longer++;
  return length | longer << PLAN_LONGER_BIT | PLAN_CELLS;
}

std::vector<int32_t> stepPlan(std::span<const Macrocell> summaries, const CompiledMap& map, double cellT,
                              double tolerance, double step, std::optional<double> others) {
  std::vector<int32_t> plan(summaries.size(), 0);
  // For a single volume see addPiecesOfFew and addPieces in kernels/cell_curve.h.
  const double jumpError = others ? kJump : map.intervals() <= MAP_SMALL ? 0 : kHalvedJump;
  for (size_t i = 0; i < plan.size(); i++) {
    const Macrocell& m = summaries[i];
    if (!(m.min <= m.max)) continue;
    const CompiledMap::Over over = map.over(m.min, m.max);
    if (!(over.extinction > 0)) continue;
    if (step > 0) {
      plan[i] = planOf(1 / step, Integrator::Midpoint);
      continue;
    }
    Errors errors = errorsOf(m, over, jumpError, cellT);
    const double allowed = (1 - kEarlyEnd - kUnforeseen) * tolerance;
    if (others) errors.midpoint += cellT * over.slope * m.steep * std::min(1.0, kLongestRay * *others) / 24;
    const double midpoint =
        std::max(std::sqrt(errors.midpoint / allowed), over.extinction * cellT / kMostDepth);
    const double pieces = std::sqrt(errors.pieces / allowed);
    const bool cells =
        m.noData || over.jump > 0 || midpoint > std::min(kHighestRate, kCostOfCells * std::max(pieces, 1.0));
    plan[i] = cells ? planOf(pieces, Integrator::ByCells, std::sqrt(errors.within / allowed))
                    : planOf(midpoint, Integrator::Midpoint);
  }
  return plan;
}

}  // namespace gxy
