// SPDX-License-Identifier: Apache-2.0
// Values at points from those of the cells around them.
#pragma once
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "core/comm/advance.h"
#include "core/data/mesh.h"

namespace gxy {

/// Returns a value for each point, the components together: a weighted average over the cells that have the point. `values` are those of
/// cells, the components of a cell together; cells with a component that is not finite do not count, and a point that has no others gets
/// NaN.
///
/// The average is what the linear function that fits the cells best has at the point, if a cell's value stands at the mean of its corners
/// (least squares; the same as the weights of Holmes & Connell, Solution of the 2D Navier-Stokes equations on unstructured adaptive grids,
/// 1989, where these are not cut off). So linear functions stay linear. Where cells are on one side of the point only, as on a flat border,
/// the function is constant towards it: in each principal direction of the cells in which the point lies farther from their mean than
/// any of n numbers can lie from theirs (Samuelson 1968). The value is kept between the lowest and the highest one around, as Barth &
/// Jespersen do (The design and application of upwind schemes on unstructured meshes, 1989).
///
/// Sums are in the order of cells, so the result has the same bits wherever all cells of a point are there in the same order.
std::vector<float> averagesAtPoints(
    std::span<const glm::dvec3> points, const MeshCellsView& cells, std::span<const float> values,
    int components, const Advance& advance = [](double) {});

}  // namespace gxy
