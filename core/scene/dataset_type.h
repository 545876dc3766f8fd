// SPDX-License-Identifier: Apache-2.0
// The types of datasets: their names, and which type a dataset has.
#pragma once
#include <optional>
#include <string>

#include "core/data/dataset.h"
#include "core/scene/scene.h"

namespace gxy {

inline constexpr int kDatasetTypes = 4;

/// "Volume", "Particles", "PathLines", "Triangles".
const char* nameOf(DatasetType type);
/// Returns the type of this name; nothing if there is none.
std::optional<DatasetType> datasetTypeNamed(const std::string& name);
/// Returns the type of a dataset, which has a volume or geometry.
DatasetType typeOf(const Dataset& dataset);
/// Returns the kind of geometry of a type; nothing for volumes.
std::optional<GeometryKind> geometryKindOf(DatasetType type);

}  // namespace gxy
