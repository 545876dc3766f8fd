// SPDX-License-Identifier: Apache-2.0
// Facts of data that have been loaded.
#pragma once
#include <optional>

#include "core/data/volume.h"
#include "core/io/import_geometry.h"
#include "core/scene/resolve.h"

namespace gxy {

DataFacts factsOf(const Volume& volume);
DataFacts factsOf(const LoadedGeometry& geometry);

/// What this rank has of a sample of the values that operators show by default (a value, or the magnitude of components), for
/// LookFacts: of a volume points of a lattice of at most kSampledPerAxis along each axis, of geometry at most kSampledValues
/// in all. The samples of all ranks together do not depend on their number.
std::vector<float> sampleOf(const Volume& volume, const Partitioning& partitioning);
std::vector<float> sampleOf(const LoadedGeometry& geometry, int rank);

inline constexpr int64_t kSampledPerAxis = 48;
inline constexpr uint64_t kSampledValues = 1 << 17;

/// The value that operators show of a point by default, where its stored components are at `sample`.
double shownValue(const std::byte* sample, ScalarType type, int components);
/// The only axis along which a grid is one cell thick, as the image that is read from a file with one layer.
std::optional<int> thinAxis(const Grid& grid);
/// Every how many points of a grid one is sampled.
Index3 samplingStride(const Grid& grid);

}  // namespace gxy
