// SPDX-License-Identifier: Apache-2.0
// Volumes become fields at the points of geometry.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/analysis/filter.h"
#include "core/data/geometry.h"
#include "core/rays/compiled_sampling.h"

namespace gxy {

/// What a component of a volume is called where it is the value of points: "u" of one component, else "mag(u)" or "u.1", as in
/// expressions.
std::string nameOfComponent(const std::string& name, int components, int component);

/// Throws Error that begins with `filter` if two of the sources have one name, or if one is called as recorded gradients are and there
/// are such (`gradient`).
void checkNames(std::span<const FilterSource> sources, const std::string& filter, bool gradient = false);

/// What the field of recorded gradients is called.
inline constexpr const char* kGradientField = "gradient";

/// How many points of a volume have no value.
struct PointsWithout {
  uint64_t outside = 0, noData = 0;  ///< on all ranks
};

/// Collective. Reads all components of each source at the points of a block of this rank, as ValueReader does. Each becomes a field with
/// the name of its source, and replaces one of this name. Returns how many points have no value, by source. `memory` gets the
/// entries of what is read. If any rank fails, all throw the same Error.
std::vector<PointsWithout> recordFields(FilterRun& run, std::span<const FilterSource> sources,
                                        GeometryBlock& block, std::vector<LedgerEntry>& memory);

/// Collective. The same for the gradient of a component of a volume (FieldReader::gradient()).
void recordGradient(FilterRun& run, const Dataset& volume, int component, GeometryBlock& block,
                    std::vector<LedgerEntry>& memory);
/// Collective. The same for the curl of three components, on a grid or unstructured, as the field "vorticity".
void recordVorticity(FilterRun& run, const FilterSource& vectors, GeometryBlock& block,
                     std::vector<LedgerEntry>& memory);

/// Adds a field to a block, or replaces the one of its name.
void setField(GeometryBlock& block, PointField field);

/// What a sampling records of volumes. The values of points are the first field or its magnitude.
struct SampledVolumes {
  std::vector<SampledField>
      sampled;        ///< first what is shown, if there is a volume; then the components of `fields`
  std::string array;  ///< what the values are called
  std::vector<PointField> fields;  ///< names and numbers of components
};
/// Throws Error if two of the volumes have one name, or for too many components.
SampledVolumes sampledVolumes(std::span<const FilterSource> sources, const std::string& filter,
                              bool gradient);

}  // namespace gxy
