// SPDX-License-Identifier: Apache-2.0
// CompiledSampling: a compiled scene whose surfaces are sampled by rays, and what is recorded at hits.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/rays/compiled_scene.h"
#include "core/rays/sample_list.h"

namespace gxy {

/// The most fields that a sampling reads, and the most hits of a ray.
inline constexpr size_t kMostSampledFields = 16;
inline constexpr int kMostHits = 0xffff;

/// A component of a volume, whose values are recorded or tested where rays meet surfaces.
struct SampledField {
  std::shared_ptr<const Volume> volume;
  int component = 0;  ///< < 0: the magnitude of all
};

/// A condition on a hit: the value of a field there is in [least, largest]. No value fulfils none.
struct HitCondition {
  int field = 0;
  double least = 0, largest = 0;
};

/// What a hit of an operator means. A hit that fails a condition is passed as if it were not there.
struct HitRule {
  std::vector<HitCondition> conditions;  ///< all must be fulfilled
  int hits = 1;  ///< a ray that has as many hits, of any operators, ends here; 1 to kMostHits
};

/// A sampling as a device needs it. Immutable, thread safe.
struct CompiledSampling {
  std::shared_ptr<const CompiledScene> scene;
  /// The first `recorded` are stored with samples, the others are for conditions.
  std::vector<SampledField> fields;
  int recorded = 0;
  bool gradient = false;       ///< gradients of the volumes that are met are stored
  bool met = false;            ///< SampleList::met is stored
  std::vector<HitRule> rules;  ///< by operator of the scene

  // In the kernels' units:
  std::vector<CompiledOperator> views;  ///< by field: its grid, its stored component, and its local blocks
  std::vector<int32_t> isovalueOf;      ///< see core/kernels/sampling_view.h, like all that follow
  std::vector<int32_t> conditionOperator, conditionField;
  std::vector<float> conditionRange;
  std::vector<int32_t> hits;
};

/// Compiles a sampling. `scene` must show what forSampling() returns, and its `visible` be set. Throws Error (what, and what
/// is expected) for fields and rules that do not fit.
std::shared_ptr<const CompiledSampling> compileSampling(std::shared_ptr<const CompiledScene> scene,
                                                        std::vector<SampledField> fields, int recorded,
                                                        std::vector<HitRule> rules, bool gradient,
                                                        bool met = false);

/// The parts of an operator that a view of a field's samples (fillVolumeView()) needs.
CompiledOperator viewOf(const SampledField& field, const RenderSpace& space);

/// A hit that counts, as devices tell of it.
struct RecordedHit {
  uint64_t ray = 0;  ///< this and the next three: as in SampleList
  uint32_t hit = 0, depth = 0, surface = 0;
  float t = 0;
  MetSurface met;
  const float* values = nullptr;  ///< stored values of the recorded fields, `stride` apart
  size_t stride = 1;
  const float* gradient = nullptr;  ///< three numbers per unit of render space; only if gradients are stored
};

/// Adds a hit to samples, in world units: the same bits for all devices.
void addSample(const CompiledSampling& sampling, const RecordedHit& hit, SampleList& samples);

/// Returns the visualization with surfaces that rays can pass, as rays of a sampling do, and without what they do not meet: lights
/// and volume rendering.
Visualization forSampling(Visualization visualization);

}  // namespace gxy
