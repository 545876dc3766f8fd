// SPDX-License-Identifier: Apache-2.0
// Meshes of cells for tests.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <numeric>

#include "core/data/mesh_blocks.h"

namespace gxy::test {

/// The box [0, 1]^3 as n^3 cubes of six tetrahedra each, which share the diagonals of the cubes' faces. move(p) is added to point p;
/// value(q) is the stored value at the point where it is then.
template <class Move, class Value>
MeshPiece cubeOfTets(uint32_t n, Move&& move, Value&& value) {
  MeshPiece mesh;
  const uint32_t m = n + 1;
  for (uint32_t i = 0; i < m * m * m; i++) {
    const glm::dvec3 p = glm::dvec3(i % m, i / m % m, i / (m * m)) / double(n);
    const glm::dvec3 q = p + glm::dvec3(move(p));
    mesh.points.push_back(q);
    mesh.values.push_back(float(value(q)));
  }
  mesh.numbers.resize(mesh.points.size());
  std::iota(mesh.numbers.begin(), mesh.numbers.end(), uint64_t(0));
  auto& tets = mesh.cells.points[size_t(CellType::Tetrahedron)];
  for (uint32_t i = 0; i < n * n * n; i++) {
    const uint32_t x = i % n, y = i / n % n, z = i / (n * n);
    const auto p = [&](uint32_t a, uint32_t b, uint32_t c) { return x + a + m * (y + b + m * (z + c)); };
    const std::array<uint32_t, 6> around{p(1, 0, 0), p(1, 1, 0), p(0, 1, 0),
                                         p(0, 1, 1), p(0, 0, 1), p(1, 0, 1)};
    for (size_t k = 0; k < 6; k++)
      tets.insert(tets.end(), {p(0, 0, 0), around[k], around[(k + 1) % 6], p(1, 1, 1)});
  }
  return mesh;
}

}  // namespace gxy::test
