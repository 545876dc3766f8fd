// SPDX-License-Identifier: Apache-2.0
// Collects the facts of loaded data that a first look needs.
#pragma once
#include <optional>

#include "core/data/dataset.h"
#include "core/data/owned_geometry.h"
#include "core/data/volume.h"
#include "core/scene/resolve.h"

namespace gxy {

DataFacts factsOf(const Volume& volume);
DataFacts factsOf(const Mesh& mesh);
DataFacts factsOf(const OwnedGeometry& geometry);
DataFacts factsOf(const Dataset& dataset);

/// Returns this rank's part of a sample for LookFacts of the values that operators show by default: the
/// value, or the magnitude of several components. A volume is sampled on a lattice of at most kSampledPerAxis
/// points along each axis, geometry at kSampledValues primitives at most on all ranks, and a mesh at about as many points. The samples of all
/// ranks together do not depend on the number of ranks.
std::vector<float> sampleOf(const Volume& volume, const Partitioning& partitioning);
std::vector<float> sampleOf(const Mesh& mesh, const Partitioning& partitioning);
std::vector<float> sampleOf(const OwnedGeometry& geometry);
std::vector<float> sampleOf(const Dataset& dataset);

inline constexpr int64_t kSampledPerAxis = 48;
inline constexpr uint64_t kSampledValues = 1 << 17;

/// Returns the value that operators show by default for the point whose `components` components are stored at
/// `sample`: the value, or the magnitude.
double shownValue(const std::byte* sample, ScalarType type, int components);
/// Returns the axis along which a grid is one cell thick, as for a file with one layer. Returns nothing if no
/// axis or more than one is.
std::optional<int> thinAxis(const Grid& grid);
/// Returns the distance of sampled points along each axis, in points of the grid.
Index3 samplingStride(const Grid& grid);

}  // namespace gxy
