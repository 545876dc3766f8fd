// SPDX-License-Identifier: Apache-2.0
// Data from a seed, in and about [-1, 1]^3.
#pragma once
#include "tests/random/draw_numbers.h"
#include "tests/support/data_sets.h"

namespace gxy::test {

/// A volume and what its maps need to know.
struct RandomVolume {
  WholeVolume volume;
  double lo = 0, hi = 1;  ///< its true values are about these
};
RandomVolume randomVolume(Choices& choose);

/// Values in [0, 1], some NaN, or colours, or neither.
WholeGeometry randomParticles(Choices& choose);
WholeGeometry randomLines(Choices& choose, bool repeats);  ///< some points twice in a row
WholeGeometry randomMesh(Choices& choose);

}  // namespace gxy::test
