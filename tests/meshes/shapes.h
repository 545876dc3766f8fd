// SPDX-License-Identifier: Apache-2.0
// Tetrahedral meshes that are hard to render, in and about [-1, 1]^3.
#pragma once
#include <functional>

#include "core/data/mesh_blocks.h"

namespace gxy::test {

using Field = std::function<double(glm::dvec3)>;

/// The cube [-1, 1]^3 of 6 n^3 cells with the value field(place) at each point. Inner points are moved by up to `far` of a spacing on
/// each axis, border points within their faces; the cells stay in order up to 0.18, and are inverted and overlap from some 0.5 on.
MeshPiece cubeMesh(uint32_t n, double far, const Field& field, uint64_t seed = 1);

/// The same with planes at x[i], y[i] and z[i], which ascend; all as many.
MeshPiece graded(const std::vector<double>& x, const std::vector<double>& y, const std::vector<double>& z,
                 const Field& field);

/// One cell, the corner of a cube with points at -1 and 1; the values are 0, 1/3, 2/3 and 1.
MeshPiece oneCell();

/// Keeps the cells of whose centre keep(centre) is true.
MeshPiece kept(MeshPiece piece, const std::function<bool(glm::dvec3 centre)>& keep);
/// Drops the cell whose centre is nearest to a place.
MeshPiece withHoleAt(MeshPiece piece, glm::dvec3 place);
/// Numbers the points of every second cell, chosen by a seed, in the other orientation.
MeshPiece invertedHere(MeshPiece piece, uint64_t seed);
/// Moves the points.
MeshPiece placed(MeshPiece piece, const std::function<glm::dvec3(glm::dvec3)>& move);
/// Both, with their own points.
MeshPiece together(MeshPiece a, const MeshPiece& b);
/// Gives points no data where none(place) is true.
MeshPiece withGaps(MeshPiece piece, const std::function<bool(glm::dvec3)>& none);
/// Adds cells without volume: one on each of some faces of cells, whose fourth point is the middle of one of the face's edges.
MeshPiece withFlatCells(MeshPiece piece, size_t count, uint64_t seed);

/// Teeth of a comb across x: every second layer of cubes is missing, but for the lowest row.
MeshPiece comb(uint32_t teeth, const Field& field);
/// A ball in a shell in a shell, with nothing between.
MeshPiece nestedShells(uint32_t n, const Field& field);
/// A layer of cells 1e-6 as thick as wide in the middle of each axis.
MeshPiece slivers(uint32_t n, const Field& field);
/// Cells that shrink towards a corner by a factor of 1e6.
MeshPiece shrinking(uint32_t n, const Field& field);

}  // namespace gxy::test
