// SPDX-License-Identifier: Apache-2.0
// Cells of topologies in Conduit's Mesh Blueprint, as gxy_cells() takes them.
#pragma once
#include <optional>

#include "insitu/catalyst/blueprint.h"

namespace gxy::catalyst {

/// The cells of an unstructured topology, of one shape or mixed. Nothing, and a warning, where a shape is not taken. Throws
/// std::runtime_error where the arrays are not what the Blueprint says.
std::optional<Cells> unstructuredCells(const Node& topology, const Warn& warn);

/// The hexahedra between the points of a lattice, x being the fastest. `lattices` keeps them for the next step.
Cells latticeCells(const Index& points, Lattices& lattices);

/// The points of a lattice whose planes lie at these coordinates along x, y and z. `made` holds them.
Values latticePositions(const Values& planes, Lattices& lattices, std::shared_ptr<const void>& made);

/// Returns a field vtkGhostType for gxy_field(), of what a field of that name or of Ascent (ascent_ghosts: 1 for a cell that another rank
/// has, too, others above 0 for cells that nothing shows) says of each cell. `made` holds its values.
Values ghostBits(const Values& ghosts, std::shared_ptr<const void>& made);

/// The cells that are no ghosts, which ghostBits() have one for each.
Cells withoutGhosts(const Cells& cells, const Values& bits);

}  // namespace gxy::catalyst
