// SPDX-License-Identifier: Apache-2.0
// Meshes for the tests of the reference renderer.
#pragma once
#include <array>

#include "tests/reference/samples.h"
#include "tests/support/meshes.h"

namespace gxy::reference {

using test::cubeOfTets;

inline constexpr size_t kTets = size_t(CellType::Tetrahedron);

inline const auto kStill = [](glm::dvec3) { return glm::dvec3(0); };
inline const auto kOne = [](glm::dvec3) { return 1.0; };

/// A mesh of one block, which is not connected: the reference needs no neighbours.
inline std::shared_ptr<Mesh> meshOf(const MeshPiece& piece) {
  auto mesh = std::make_shared<Mesh>();
  mesh->name = "test";
  mesh->components = piece.components;
  for (const glm::dvec3& p : piece.points) mesh->box.extend(p);
  for (const CellType type : kAllCellTypes) mesh->report.cells[size_t(type)] = piece.cells.size(type);
  MeshBlock& block = mesh->blocks[0];
  block.points = piece.points, block.values = piece.values;
  block.cells.points = shared(piece.cells.points);
  return mesh;
}

/// Moves points inside [0, 1]^3 by up to `far` on each axis, by whole steps of 2^-12. Points of the border stay in their faces.
inline auto inside(double far, uint64_t seed) {
  return [far, random = Uniform(seed)](glm::dvec3 p) mutable {
    glm::dvec3 step = random.inCube(far);
    for (int a = 0; a < 3; a++) step[a] = p[a] > 0 && p[a] < 1 ? std::round(step[a] * 4096) / 4096 : 0;
    return step;
  };
}

inline MeshPiece oneCell(const std::array<glm::dvec3, 4>& points, const std::array<float, 4>& values) {
  MeshPiece piece;
  piece.points.assign(points.begin(), points.end());
  piece.values.assign(values.begin(), values.end());
  piece.cells.points[kTets] = {0, 1, 2, 3};
  return piece;
}

/// Drops the cells whose centre is in the box.
inline MeshPiece without(MeshPiece piece, const Box& box) {
  std::vector<uint32_t> kept;
  const auto& cells = piece.cells.points[kTets];
  for (size_t i = 0; i < cells.size(); i += 4) {
    glm::dvec3 centre(0);
    for (size_t k = 0; k < 4; k++) centre += 0.25 * piece.points[cells[i + k]];
    if (!box.overlaps({centre, centre})) kept.insert(kept.end(), &cells[i], &cells[i] + 4);
  }
  piece.cells.points[kTets] = kept;
  return piece;
}

inline Ray towards(glm::dvec3 from, glm::dvec3 at) { return {from, glm::normalize(at - from)}; }

inline double lengthOf(const std::vector<MeshSpan>& spans) {
  double sum = 0;
  for (const MeshSpan& s : spans) sum += s.t1 - s.t0;
  return sum;
}

}  // namespace gxy::reference
