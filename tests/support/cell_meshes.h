// SPDX-License-Identifier: Apache-2.0
// Meshes of hexahedra, wedges and pyramids for tests, beside cubeOfTets().
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <numeric>

#include "core/data/mesh_blocks.h"

namespace gxy::test {

/// How one of the cubes of a mesh is cut into cells. Its points are in the order of VTK's hexahedron.
class CubeCutter {
 public:
  explicit CubeCutter(MeshCells& cells) : cells_(&cells) {}
  using Cube = std::array<uint32_t, 8>;

  void hexahedron(const Cube& c) { add(CellType::Hexahedron, c); }
  /// Two wedges along z. They share the diagonals of the faces across z with the six tetrahedra.
  void wedges(const Cube& c) {
    add(CellType::Wedge, std::array{c[0], c[2], c[1], c[4], c[6], c[5]});
    add(CellType::Wedge, std::array{c[0], c[3], c[2], c[4], c[7], c[6]});
  }
  /// Six tetrahedra around the diagonal, those of cubeOfTets().
  void tetrahedra(const Cube& c) {
    const std::array<uint32_t, 6> around{c[1], c[2], c[3], c[7], c[4], c[5]};
    for (size_t k = 0; k < 6; k++)
      add(CellType::Tetrahedron, std::array{c[0], around[k], around[(k + 1) % 6], c[6]});
  }
  /// Pyramids from the faces to a point inside. Of a face that isCut(face) two tetrahedra take the place of the pyramid.
  template <class IsCut>
  void pyramids(const Cube& c, uint32_t top, IsCut&& isCut) {
    const CellShape& shape = shapeOf(CellType::Hexahedron);
    for (size_t f = 0; f < shape.faces; f++) {
      std::array<uint32_t, 4> q{};
      for (size_t k = 0; k < 4; k++) q[k] = c[shape.face[f].corner[k]];
      if (isCut(f)) {
        std::rotate(q.begin(), std::min_element(q.begin(), q.end()), q.end());
        add(CellType::Tetrahedron, std::array{top, q[0], q[1], q[2]});
        add(CellType::Tetrahedron, std::array{top, q[0], q[2], q[3]});
      } else {
        add(CellType::Pyramid, std::array{q[0], q[3], q[2], q[1], top});
      }
    }
  }

 private:
  template <size_t N>
  void add(CellType type, const std::array<uint32_t, N>& points) {
    auto& all = cells_->points[size_t(type)];
    all.insert(all.end(), points.begin(), points.end());
  }
  MeshCells* cells_;
};

/// The box [0, 1]^3 as n^3 cubes; cut(cutter, cube, centre, x, y, z) makes the cells of each. Points are those of cubeOfTets(), and
/// behind them the centres of the cubes if `centres`. move(p) is added to point p; value(q) is the stored value at the point where it is
/// then.
template <class Move, class Value, class Cut>
MeshPiece cubeOfCubes(uint32_t n, bool centres, Move&& move, Value&& value, Cut&& cut) {
  MeshPiece mesh;
  const uint32_t m = n + 1;
  const auto add = [&](const glm::dvec3& p) {
    const glm::dvec3 q = p + glm::dvec3(move(p));
    mesh.points.push_back(q);
    mesh.values.push_back(float(value(q)));
  };
  for (uint32_t i = 0; i < m * m * m; i++) add(glm::dvec3(i % m, i / m % m, i / (m * m)) / double(n));
  for (uint32_t i = 0; centres && i < n * n * n; i++)
    add(glm::dvec3(2 * (i % n) + 1, 2 * (i / n % n) + 1, 2 * (i / (n * n)) + 1) / double(2 * n));
  mesh.numbers.resize(mesh.points.size());
  std::iota(mesh.numbers.begin(), mesh.numbers.end(), uint64_t(0));
  CubeCutter cutter(mesh.cells);
  for (uint32_t i = 0; i < n * n * n; i++) {
    const uint32_t x = i % n, y = i / n % n, z = i / (n * n);
    const auto p = [&](uint32_t a, uint32_t b, uint32_t c) { return x + a + m * (y + b + m * (z + c)); };
    cut(cutter,
        CubeCutter::Cube{p(0, 0, 0), p(1, 0, 0), p(1, 1, 0), p(0, 1, 0), p(0, 0, 1), p(1, 0, 1), p(1, 1, 1),
                         p(0, 1, 1)},
        m * m * m + i, x, y, z);
  }
  return mesh;
}

/// n^3 hexahedra in [0, 1]^3. `move` and `value` as for cubeOfTets(), with the same points.
template <class Move, class Value>
MeshPiece cubeOfHexes(uint32_t n, Move&& move, Value&& value) {
  return cubeOfCubes(n, false, move, value,
                     [](CubeCutter& cutter, const CubeCutter::Cube& c, uint32_t, uint32_t, uint32_t,
                        uint32_t) { cutter.hexahedron(c); });
}

/// 2 n^3 wedges in [0, 1]^3, the rest as for cubeOfHexes().
template <class Move, class Value>
MeshPiece cubeOfWedges(uint32_t n, Move&& move, Value&& value) {
  return cubeOfCubes(n, false, move, value,
                     [](CubeCutter& cutter, const CubeCutter::Cube& c, uint32_t, uint32_t, uint32_t,
                        uint32_t) { cutter.wedges(c); });
}

/// 6 n^3 pyramids in [0, 1]^3, whose tops are at the centres of n^3 cubes. The centres are the last points; the rest is as for
/// cubeOfHexes().
template <class Move, class Value>
MeshPiece cubeOfPyramids(uint32_t n, Move&& move, Value&& value) {
  return cubeOfCubes(n, true, move, value,
                     [](CubeCutter& cutter, const CubeCutter::Cube& c, uint32_t top, uint32_t, uint32_t,
                        uint32_t) { cutter.pyramids(c, top, [](size_t) { return false; }); });
}

/// Cells of all four types in [0, 1]^3, n >= 2. Of n^3 cubes every second one is by turns a hexahedron, two wedges or six tetrahedra. The
/// others are pyramids to their centres, with two tetrahedra each where the neighbour's face is two triangles. Each centre is a point,
/// also those that no cell has; the rest is as for cubeOfPyramids().
template <class Move, class Value>
MeshPiece cubeOfAllCells(uint32_t n, Move&& move, Value&& value) {
  enum { Hexahedron, Wedges, Tetrahedra };
  const auto kindOf = [n](uint32_t x, uint32_t y, uint32_t z) { return (x + n * (y + n * z)) / 2 % 3; };
  return cubeOfCubes(
      n, true, move, value,
      [&](CubeCutter& cutter, const CubeCutter::Cube& c, uint32_t top, uint32_t x, uint32_t y, uint32_t z) {
        const auto kind = kindOf(x, y, z);
        if ((x + y + z) % 2 == 0) {
          if (kind == Hexahedron) cutter.hexahedron(c);
          if (kind == Wedges) cutter.wedges(c);
          if (kind == Tetrahedra) cutter.tetrahedra(c);
          return;
        }
        // The faces of a hexahedron are in the order of -x, +x, -y, +y, -z, +z.
        cutter.pyramids(c, top, [&](size_t face) {
          std::array<uint32_t, 3> at{x, y, z};
          at[face / 2] += face % 2 ? 1 : uint32_t(-1);
          if (*std::max_element(at.begin(), at.end()) >= n) return false;
          const auto beside = kindOf(at[0], at[1], at[2]);
          return beside == Tetrahedra || (beside == Wedges && face / 2 == 2);
        });
      });
}

}  // namespace gxy::test
