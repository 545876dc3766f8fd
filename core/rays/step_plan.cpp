// SPDX-License-Identifier: Apache-2.0
#include "gxy/rays/step_plan.h"

#include <algorithm>
#include <cmath>

namespace gxy {

namespace {
constexpr int kLevels = 31;
// A partition evaluates the segments that end in it, and holds kGhostLayers cells before it: so midpoint segments are at
// most 1 / 0.2625 = 3.8 cells long, and pre-integrated ones, which need their start, 1 / 0.525 = 1.9.
constexpr double kLowestRate = 0.2625;
constexpr int kLowestPieces = 5;
static_assert(kGhostLayers == 2);
constexpr uint8_t kPieces = 32;
constexpr double kErrorOfVariation = 0.035;
constexpr double kErrorOfPieces = 0.015;  // the same of pre-integrated segments
constexpr double kErrorOfJump = 1.4;
constexpr double kMostJump = 2;    // of optical depth per cell: what is behind such a step is hidden
constexpr double kSharp = 4;       // change of extinction over the range at its steepest, in extinctions
constexpr double kThick = 0.3;     // optical depth of a cell from which a segment hides part of itself
constexpr double kNoDataRate = 4;  // a no-data cell's faces are steps of the field
}  // namespace

std::array<float, 32> planRates(double fixedStep) {
  std::array<float, 32> rates{};
  for (int l = 1; l <= kLevels; l++)
    rates[l] =
        float(fixedStep > 0 ? std::max(1 / fixedStep, kLowestRate) : kLowestRate * std::exp2((l - 1) / 4.0));
  return rates;
}

std::vector<uint8_t> stepPlan(std::span<const Macrocell> summaries, const CompiledMap& map, double cellT,
                              double tolerance, bool fixedStep) {
  std::vector<uint8_t> plan(summaries.size(), 0);
  for (size_t i = 0; i < plan.size(); i++) {
    const Macrocell& m = summaries[i];
    if (!(m.min <= m.max)) continue;
    const CompiledMap::Over over = map.over(m.min, m.max);
    if (!(over.extinction > 0)) continue;
    if (fixedStep) {
      plan[i] = 1;
      continue;
    }
    // errors of about as many cells add up, at random, as a ray sees
    const double seen = std::min(1 / (over.extinction * cellT), 1.7 / cellT);
    const double variation = over.slope * (double(m.max) - m.min) * cellT;
    const double jump = std::min(over.jump * cellT, kMostJump);
    const bool sharp = jump > 0 || over.extinction * cellT > kThick ||
                       over.slope * (double(m.max) - m.min) > kSharp * over.extinction;
    const double error =
        (sharp ? kErrorOfPieces : kErrorOfVariation) * variation * std::sqrt(std::max(seen, 1.0)) +
        kErrorOfJump * jump;
    double rate = std::sqrt(error / (0.75 * tolerance));
    if (m.noData) rate = std::max(rate, kNoDataRate);
    const int level = rate > kLowestRate ? int(std::ceil(4 * std::log2(rate / kLowestRate))) + 1 : 1;
    plan[i] = uint8_t(std::clamp(level, sharp ? kLowestPieces : 1, kLevels) | (sharp ? kPieces : 0));
  }
  return plan;
}

std::vector<uint8_t> isoPlan(std::span<const Macrocell> summaries, std::span<const float> isovalues) {
  std::vector<uint8_t> plan(summaries.size(), 0);
  for (size_t i = 0; i < plan.size(); i++)
    for (float v : isovalues) plan[i] |= uint8_t(summaries[i].min <= v && v <= summaries[i].max);
  return plan;
}

}  // namespace gxy
