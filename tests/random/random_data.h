// SPDX-License-Identifier: Apache-2.0
// Data from a seed, in and about [-1, 1]^3.
#pragma once
#include <functional>

#include "tests/random/draw_numbers.h"
#include "tests/support/data_sets.h"

namespace gxy::test {

/// Values of about [0, 1] over [-1, 1]^3.
std::function<double(glm::dvec3)> randomField(Choices& choose);

/// A volume and what its maps need to know.
struct RandomVolume {
  WholeVolume volume;
  double lo = 0, hi = 1;  ///< its true values are about these
};
RandomVolume randomVolume(Choices& choose);

/// An unstructured volume of one component and what its maps need to know: cells in order, some of them missing, inverted or
/// without data.
struct RandomMesh {
  WholeMesh mesh;
  double lo = 0, hi = 1;  ///< its true values are about these
  double size = 1;        ///< about that of the largest cells
  bool thin = false;      ///< the cells are far thinner than wide
};
RandomMesh randomCells(Choices& choose);

/// Values in [0, 1], some NaN, or colours, or neither.
WholeGeometry randomParticles(Choices& choose);
WholeGeometry randomLines(Choices& choose, bool repeats);  ///< some points twice in a row
WholeGeometry randomMesh(Choices& choose);

}  // namespace gxy::test
