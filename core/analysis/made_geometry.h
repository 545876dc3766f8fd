// SPDX-License-Identifier: Apache-2.0
// Geometry that a filter has made becomes a dataset.
#pragma once
#include <memory>
#include <span>
#include <string>

#include "core/analysis/filter.h"

namespace gxy {

/// Collective. Makes a dataset of the primitives of all ranks. Each rank gives the ones that it owns, with ids that are different on
/// all ranks and ascend. Primitives that cannot be drawn (a coordinate that is not finite, say) are dropped and counted. `memory` is the
/// entry of the block in the ledger. `array` is what the values are called, if there are any. If any rank fails, all throw the same
/// Error.
std::shared_ptr<Dataset> madeGeometry(FilterRun& run, const std::string& name, GeometryKind kind,
                                      GeometryBlock block, std::shared_ptr<const Partitioning> partitioning,
                                      LedgerEntry memory, const std::string& array = {});

/// What users are told of fields: a list of objects with `name`, `components` and `range`, of the magnitude if there are several.
nlohmann::json toldOf(std::span<const PointFieldInfo> fields);
/// The same of all that points have: first the values, if they have a name.
nlohmann::json toldOfPoints(const OwnedGeometry& geometry);

}  // namespace gxy
