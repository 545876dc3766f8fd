// SPDX-License-Identifier: Apache-2.0
// Derived fields: volumes that are computed from others by an expression (expression.h).
//
// Values are computed in double, with the same bits on every machine, in rows of at most 512 points, and stored as float: a scalar
// has 1 component, a vector 3, a tensor 9. Logical results are bytes, 0 or 1, and 0 where there is no data. Results do not depend
// on how the grid is cut into partitions, nor on ranks and threads.
//
// No data: a NaN or an infinite sample is none, and neither is what is computed of one. Division by 0, the square root of a
// negative number, the logarithm of a number that is not positive, sin(), cos() and tan() beyond 2^30, and what is too large for
// float give no data. What is smaller than the least normal float is stored as 0.
//
// Differentials are differences per world unit: central, one-sided of order 2 at the ends of the domain and beside points without
// data, of order 1 where there are only two points, and 0 where both neighbours have no data. A first difference needs two layers
// of points around it (the one-sided one has three points), laplacian() three; when the four ghost layers of a block are used up,
// the intermediate result is stored in double and its ghosts are exchanged. Data of cells (Grid::rim) have their derivatives at
// the centres of the cells, and the rim repeats those.
#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>

#include "core/analysis/expression.h"
#include "core/comm/collectives.h"
#include "core/data/partitioning.h"
#include "core/data/volume.h"

namespace gxy {

/// A field under the name that the expression uses. The volume is complete, and its blocks are those of the partitioning with
/// kGhostLayers. Both are only read.
struct FieldInput {
  std::string name;
  std::shared_ptr<const Volume> volume;
  std::shared_ptr<const Partitioning> partitioning;
};

struct DeriveOptions {
  std::string name;                                        ///< of the result
  double time = std::numeric_limits<double>::quiet_NaN();  ///< of the inputs; NaN: unknown
  /// Is told bytes before they are allocated, and negative ones when memory that was needed meanwhile has been given back. It may
  /// throw, which all ranks then do. Calls do not overlap. After an exception, what was told is no longer in use.
  std::function<void(int64_t bytes)> memory;
};

struct DerivedField {
  std::shared_ptr<Volume> volume;  ///< complete, with the grid of the inputs
  ValueType type;
  int64_t noData = 0;  ///< points of the grid, without its rim, where a component has no data
};

/// Collective. Computes a field. Every rank gives the same expression and inputs, with its own blocks. There is at least one
/// input, and all have one grid and one partitioning. Calls ranks.check() and ranks.done() often. All ranks throw the same Error if
/// any fails: for names and types (typesOf()), grids and partitionings that differ, an expression that is a number, `time` that is
/// unknown, a fraction of quantile() that is not from 0 to 1.
DerivedField derive(const Expression& expression, std::span<const FieldInput> inputs, Collectives& ranks,
                    const DeriveOptions& options = {});

/// Collective. Computes where a logical expression holds: bytes, 0 or 1, as `where` of fieldStatistics() wants them. Only owned
/// points are set; the volume is not complete. Errors are those of derive().
std::shared_ptr<Volume> conditionOf(const Expression& expression, std::span<const FieldInput> inputs,
                                    Collectives& ranks, const DeriveOptions& options = {});

/// Collective. Computes a number of fields, such as max(p) or, 1 or 0, max(p) > 3; NaN if it has no data. Errors are those of
/// derive(), and that the expression is a field.
double numberOf(const Expression& expression, std::span<const FieldInput> inputs, Collectives& ranks,
                const DeriveOptions& options = {});

}  // namespace gxy
