// SPDX-License-Identifier: Apache-2.0
// Meshes of cells of all types for tests.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <initializer_list>
#include <numeric>

#include "core/data/mesh_blocks.h"

namespace gxy::test {

inline void addCell(MeshPiece& mesh, CellType type, std::initializer_list<uint32_t> points) {
  auto& cells = mesh.cells.points[size_t(type)];
  cells.insert(cells.end(), points);
}

/// The box [0, 1]^3 as n^3 cubes. Some are hexahedra, some two wedges, which stand in columns along z, and some six pyramids with their
/// tops in the middle; of pyramids with their base at x = 0 each is two tetrahedra. All cells conform. move(p) is added to point p;
/// value(q) is the stored value at the point where it is then. From n = 2 on there are cells of all types.
template <class Move, class Value>
MeshPiece cubeOfMixedCells(uint32_t n, Move&& move, Value&& value) {
  MeshPiece mesh;
  const uint32_t m = n + 1;
  const auto addPoint = [&](const glm::dvec3& p) {
    mesh.points.push_back(p + glm::dvec3(move(p)));
    mesh.values.push_back(float(value(mesh.points.back())));
  };
  for (uint32_t i = 0; i < m * m * m; i++) addPoint(glm::dvec3(i % m, i / m % m, i / (m * m)) / double(n));
  for (uint32_t i = 0; i < n * n * n; i++) {
    const uint32_t x = i % n, y = i / n % n, z = i / (n * n);
    const auto p = [&](uint32_t a, uint32_t b, uint32_t c) { return x + a + m * (y + b + m * (z + c)); };
    const std::array<uint32_t, 8> h{p(0, 0, 0), p(1, 0, 0), p(1, 1, 0), p(0, 1, 0),
                                    p(0, 0, 1), p(1, 0, 1), p(1, 1, 1), p(0, 1, 1)};
    if ((x + 2 * y) % 3 == 1) {
      addCell(mesh, CellType::Wedge, {h[0], h[2], h[1], h[4], h[6], h[5]});
      addCell(mesh, CellType::Wedge, {h[0], h[3], h[2], h[4], h[7], h[6]});
    } else if ((x + y + z) % 2 == 1) {
      addCell(mesh, CellType::Hexahedron, {h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7]});
    } else {
      const auto middle = uint32_t(mesh.points.size());
      addPoint((glm::dvec3(x, y, z) + 0.5) / double(n));
      for (const CellFace& face : shapeOf(CellType::Hexahedron).face) {
        const uint32_t a = h[face.corner[3]], b = h[face.corner[2]], c = h[face.corner[1]],
                       d = h[face.corner[0]];
        if (x == 0 && &face == &shapeOf(CellType::Hexahedron).face[0]) {
          addCell(mesh, CellType::Tetrahedron, {a, b, c, middle});
          addCell(mesh, CellType::Tetrahedron, {a, c, d, middle});
        } else {
          addCell(mesh, CellType::Pyramid, {a, b, c, d, middle});
        }
      }
    }
  }
  mesh.numbers.resize(mesh.points.size());
  std::iota(mesh.numbers.begin(), mesh.numbers.end(), uint64_t(0));
  return mesh;
}

}  // namespace gxy::test
