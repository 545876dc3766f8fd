// SPDX-License-Identifier: Apache-2.0
// Derived fields of unstructured volumes: values that an expression computes of others at each point, or of each cell, of one mesh.
//
// Values are computed and stored as those on grids are (evaluate.h), without differentials, which need a grid. `x`, `y` and `z` are those of the
// point, or the mean of the cell's corners. A logical result is 0 or 1, and 0 where there is no data.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/analysis/evaluate.h"
#include "core/data/mesh.h"

namespace gxy {

/// A field under the name that the expression uses.
struct MeshInput {
  std::string name;
  std::shared_ptr<const Mesh> mesh;
  std::shared_ptr<const Partitioning> partitioning;
};

struct DerivedMesh {
  std::shared_ptr<Mesh> mesh;  ///< it shares all but its values with the first input
  ValueType type;
  int64_t noData = 0;  ///< points, or cells, where a component has no data
};

/// Collective. Computes a field. Every rank gives the same expression and inputs, with its own blocks. All inputs are on the same points and
/// cells, and in the same partitions, and all have values of points, or all of cells. All ranks throw the same Error if any fails: for
/// inputs on different meshes, a differential, and as derive() does.
DerivedMesh derive(const Expression& expression, std::span<const MeshInput> inputs, Collectives& ranks,
                   const DeriveOptions& options = {});

/// Collective. Computes a number of such fields, as numberOf() does of fields on a grid. Each point or cell counts once.
double numberOf(const Expression& expression, std::span<const MeshInput> inputs, Collectives& ranks,
                const DeriveOptions& options = {});

}  // namespace gxy
