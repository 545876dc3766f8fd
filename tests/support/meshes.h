// SPDX-License-Identifier: Apache-2.0
// Meshes of cells for tests.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
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

/// The cells of both, with points of their own and values at these.
inline MeshPiece joined(MeshPiece a, const MeshPiece& b) {
  const auto before = uint32_t(a.points.size());
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  a.values.insert(a.values.end(), b.values.begin(), b.values.end());
  for (const uint64_t number : b.numbers) a.numbers.push_back(before + number);
  for (size_t type = 0; type < kCellTypes; type++)
    for (const uint32_t corner : b.cells.points[type]) a.cells.points[type].push_back(before + corner);
  return a;
}

/// The mean of the corners of each cell of a type.
inline std::vector<glm::dvec3> centresOf(const MeshPiece& piece, CellType type) {
  const std::vector<uint32_t>& cells = piece.cells.points[size_t(type)];
  const size_t n = shapeOf(type).points;
  std::vector<glm::dvec3> centres;
  for (size_t at = 0; at < cells.size(); at += n) {
    glm::dvec3 sum(0);
    for (size_t i = 0; i < n; i++) sum += piece.points[cells[at + i]];
    centres.push_back(sum / double(n));
  }
  return centres;
}

/// The same cells with the stored value value(centre) each, in place of values at points.
template <class Value>
MeshPiece withCellValues(MeshPiece piece, Value&& value) {
  piece.ofCells = true;
  piece.components = 1;
  piece.values.clear();
  for (const CellType type : kAllCellTypes) {
    auto& values = piece.cellValues[size_t(type)];
    values.clear();
    for (const glm::dvec3& centre : centresOf(piece, type)) values.push_back(float(value(centre)));
    piece.duplicates[size_t(type)].assign(values.size(), 0);
  }
  return piece;
}

/// A mesh without blocks, with ranges, a box and a number of components.
inline Mesh describedMesh(const MeshPiece& piece, double shift = 0, double scale = 1) {
  Mesh mesh;
  mesh.name = "mesh";
  mesh.components = piece.components;
  mesh.shift = shift, mesh.scale = scale;
  const auto n = size_t(piece.components);
  mesh.ranges.resize(n > 1 ? n + 1 : 1);
  mesh.ofCells = piece.ofCells;
  const auto extend = [&](const std::vector<float>& values) {
    for (size_t p = 0; p < values.size() / n; p++) {
      double squares = 0;
      for (size_t c = 0; c < n; c++) {
        const double value = shift + scale * double(values[p * n + c]);
        mesh.ranges[c].extend(value);
        squares += value * value;
      }
      if (n > 1) mesh.ranges[n].extend(std::sqrt(squares));
    }
  };
  extend(piece.values);
  for (const auto& values : piece.cellValues) extend(values);
  for (const auto& cells : piece.cells.points)
    for (const uint32_t p : cells) mesh.box.extend(piece.points[p]);
  return mesh;
}

/// The mesh in the one partition that is the whole domain; an empty domain is the box of the mesh.
inline std::shared_ptr<Mesh> meshInOnePiece(MeshPiece piece, Box domain = {}, double shift = 0,
                                            double scale = 1) {
  auto mesh = std::make_shared<Mesh>(describedMesh(piece, shift, scale));
  MeshBlockCounts counts;
  mesh->blocks.emplace(
      0, meshBlock(std::move(piece), Partitioning::single(domain.empty() ? mesh->box : domain), 0, counts));
  mesh->report.cells = counts.cells;
  mesh->report.points = counts.points;
  mesh->report.foldedFaces = counts.foldedFaces;
  mesh->report.crowdedFaces = counts.crowdedFaces;
  return mesh;
}

}  // namespace gxy::test
