// SPDX-License-Identifier: Apache-2.0
// Gradients at the points of a mesh, for the normals of isosurfaces.
#pragma once
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "core/comm/advance.h"
#include "core/comm/collectives.h"
#include "core/comm/transport.h"
#include "core/data/mesh.h"
#include "core/data/partitioning.h"

namespace gxy {

/// x y z for each point of each local block: the gradient of stored values, in units of them by the longest side of the mesh's box.
using PointGradients = std::map<int, std::vector<float>>;
int64_t bytesOf(const PointGradients& gradients);

/// Returns the gradients of one component, or of the magnitude if there are several components and none is named. The gradient at a point
/// is the mean of those that the cells around it have there, weighed by volume: a cell counts at a corner as the tetrahedron of the corner
/// and its neighbours along edges. So it is exact where the field is linear, central differences in a uniform grid, and cells that are
/// nearly flat hardly count. Cells without data do not count. It is 0 where no cell counts.
///
/// Sums are in the order of cells, so the result has the same bits wherever all cells of a point are there. A block may lack some cells of
/// points outside its partition; takeGradients() corrects these.
PointGradients localGradients(
    const Mesh& mesh, std::optional<int> component, const Advance& advance = [](double) {});

/// Returns one message for each rank with the gradients at points that are nearest to a partition of this rank, for those partitions of
/// the other rank which have cells with them.
std::vector<Bytes> packGradients(const Mesh& mesh, const PointGradients& gradients,
                                 const Partitioning& partitioning, int ranks);
/// Takes the gradients in such messages of all ranks over. Throws Error for a malformed message.
void takeGradients(const Mesh& mesh, PointGradients& gradients, const Partitioning& partitioning,
                   std::span<const Bytes> received);

/// Collective. Returns the gradients of a mesh, of which each rank has its blocks. If any rank fails, all throw the same Error.
PointGradients pointGradients(const Mesh& mesh, std::optional<int> component,
                              const Partitioning& partitioning, Collectives& ranks);

}  // namespace gxy
