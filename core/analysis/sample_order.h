// SPDX-License-Identifier: Apache-2.0
// The order of samples, which does not depend on the ranks that have them.
#pragma once
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "core/comm/collectives.h"

namespace gxy {

/// The key of a sample. No two samples of a sampling have the same.
struct SampleKey {
  uint64_t ray = 0;
  uint32_t depth = 0, hit = 0;
  auto operator<=>(const SampleKey& o) const {
    if (const auto c = depth <=> o.depth; c != 0) return c;
    if (const auto c = ray <=> o.ray; c != 0) return c;
    return hit <=> o.hit;
  }
  bool operator==(const SampleKey&) const = default;
};

/// Collective. Returns the place of each of this rank's keys, which ascend, among those of all ranks together. Each rank orders a
/// part of all keys, of about the same size (parallel sorting by regular sampling: Shi & Schaeffer, J. Parallel and Distributed
/// Computing 14, 1992).
std::vector<uint64_t> placesAmong(std::span<const SampleKey> mine, Collectives& ranks);

}  // namespace gxy
