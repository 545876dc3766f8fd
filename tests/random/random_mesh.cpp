// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "tests/meshes/cells.h"
#include "tests/meshes/shapes.h"
#include "tests/random/random_data.h"

namespace gxy::test {

namespace {

/// Drops cells at random, so that islands and holes are left; at least one cell stays.
MeshPiece thinned(Choices& choose, MeshPiece piece) {
  const MeshPiece all = piece;
  const int parts = choose.from(2, 8), left = choose.from(1, parts - 1);
  const glm::dvec3 centre = choose.point(-0.6, 0.6);
  const bool ball = choose.oneIn(2);
  piece = kept(std::move(piece), [&](glm::dvec3 c) {
    return ball ? glm::length(c - centre) > 0.7 : choose.below(parts) < left;
  });
  return piece.cells.size() > 0 ? piece : all;
}

MeshPiece randomShape(Choices& choose, const Field& field) {
  if (choose.oneIn(12)) return oneCell();
  const auto n = uint32_t(choose.from(1, 5));
  const double far = choose.oneIn(3) ? 0 : 0.17;
  MeshPiece piece;
  if (choose.oneIn(2)) {
    piece = cubeMesh(n, far, field, choose.seed());
  } else {
    const Cells cells = kOtherCells[size_t(choose.below(int(kOtherCells.size())))];
    piece = cubeOfCells(cells, cells == Cells::All ? n + 1 : n, far, field, choose.seed());
  }
  if (choose.oneIn(3)) piece = thinned(choose, std::move(piece));
  if (choose.oneIn(4)) piece = invertedHere(std::move(piece), choose.seed());
  return piece;
}

}  // namespace

RandomMesh randomCells(Choices& choose) {
  RandomMesh made;
  MeshPiece& piece = made.mesh.cells;
  piece = randomShape(choose, randomField(choose));
  if (choose.oneIn(5)) piece = withGaps(std::move(piece), [&](glm::dvec3) { return choose.oneIn(30); });
  const double span = choose.oneIn(3) ? choose.scale(1e-15, 1e15) : 1;
  made.lo = choose.oneIn(3) ? span * choose.in(-30, 30) : 0;
  made.hi = made.lo + span;
  if (choose.oneIn(3)) {
    made.mesh.shift = made.lo, made.mesh.scale = span;
  } else {
    for (float& value : piece.values) value = float(made.lo + span * double(value));
  }
  glm::dvec3 size(choose.oneIn(3) ? choose.in(0.3, 0.8) : 1);
  if (choose.oneIn(3)) size *= choose.point(0.2, 1);
  if (choose.oneIn(15)) size[choose.below(3)] *= 1e-4;
  const glm::dvec3 centre = choose.oneIn(3) ? choose.point(-0.4, 0.4) : glm::dvec3(0);
  piece = placed(std::move(piece), [&](glm::dvec3 p) { return centre + size * p; });
  made.size = std::max({size.x, size.y, size.z}) / 3;
  made.thin = std::min({size.x, size.y, size.z}) < 1e-3;
  return made;
}

}  // namespace gxy::test
