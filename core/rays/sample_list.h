// SPDX-License-Identifier: Apache-2.0
// SampleList: what sampling rays have recorded.
#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "core/space/ledger.h"

namespace gxy {

/// The surface that a hit has met, for rays that go on from there.
struct MetSurface {
  glm::vec3 origin{0}, direction{0};  ///< of the ray, in render space
  uint32_t kind = 0;                  ///< HIT_* of ray_fields.h
  uint32_t primitive = 0;  ///< index of the isovalue, of the slice, or of the triangle in the partition
  int32_t partition = 0;
};

/// The samples of hits, as a structure of arrays. The key of a sample is (depth, ray, hit), which no two samples of a
/// sampling share. Not thread safe.
struct SampleList {
  std::vector<uint64_t> ray;               ///< number of the ray
  std::vector<uint32_t> hit;               ///< number of the hit on the ray, from 0
  std::vector<uint32_t> depth;             ///< how many rays the ray descends from
  std::vector<uint32_t> surface;           ///< index of the operator that was met
  std::vector<float> t;                    ///< on the ray, in render space
  std::vector<glm::dvec3> position;        ///< world
  std::vector<std::vector<float>> values;  ///< of each recorded field; NaN where there is none
  std::vector<glm::vec3> gradient;  ///< per world unit, of the volume that was met; empty if not asked for
  std::vector<MetSurface> met;      ///< empty if not asked for

  size_t size() const { return ray.size(); }
  bool empty() const { return ray.empty(); }
  int64_t bytes() const {
    return int64_t(size()) * bytesPerSample(int(values.size()), !gradient.empty()) +
           int64_t(met.size() * sizeof(MetSurface));
  }
  static int64_t bytesPerSample(int fields, bool gradient);

  /// Appends the samples of another list with as many fields, or appends to an empty one.
  void append(SampleList&& other);
  /// Keeps the samples `which`, in that order.
  void select(const std::vector<uint32_t>& which);
};

/// Samples with their entries in the ledger, in steps of a fixed size. Not thread safe.
struct TakenSamples {
  static constexpr int64_t kStep = int64_t(1) << 20;  ///< bytes of each entry

  SampleList list;
  std::vector<LedgerEntry> memory;
  std::string refused;  ///< not empty: why there was no room for a step

  void append(TakenSamples&& other);
  /// Enters the steps that the list fills and, if `whole`, the one that it has begun. Sets `refused` if `enter` throws.
  /// Returns whether nothing was refused so far.
  bool enter(const EnterMemory& enter, bool whole);
};

}  // namespace gxy
