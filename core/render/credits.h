// SPDX-License-Identifier: Apache-2.0
// How many rays may be under way, and how much of that each tenant may take.
#pragma once
#include <cstdint>
#include <map>
#include <utility>

#include "core/render/share.h"

namespace gxy {

/// Credits of a rank. Rays give them back only when they end, so that whoever comes later must find some: whoever takes keeps
/// an eighth of what it could take free (a queue may take a multiple of the free room: Choudhury and Hahne, "Dynamic queue
/// length thresholds for shared-memory packet switches", 1998). One tenant alone thus has at most 7/8, each of two 7/15, and
/// each of n 7/(1 + 7n); the streams of a tenant share its part in the same way. A tenant that has nothing out may take all
/// that is free, and where nothing is out at all a tile goes whatever it costs. Not thread safe.
class Credits {
 public:
  explicit Credits(int64_t all) : all_(all) {}

  bool mayTake(const Share& share, int64_t cost) const;
  void take(const Share& share, int64_t cost);
  /// Less than 0 for secondary rays beyond those that their primary took credits for.
  void giveBack(const Share& share, int64_t credits);

  int64_t all() const { return all_; }
  int64_t out() const { return out_; }
  int64_t mostOut() const { return mostOut_; }
  int64_t outOfTenant(const Share& share) const;
  int64_t outOfStream(const Share& share) const;
  const std::map<uint32_t, int64_t>& byTenant() const { return tenants_; }  ///< where not 0

 private:
  void change(const Share& share, int64_t by);

  const int64_t all_;
  int64_t out_ = 0, mostOut_ = 0;
  std::map<uint32_t, int64_t> tenants_;
  std::map<std::pair<uint32_t, uint64_t>, int64_t> streams_;  ///< likewise
};

}  // namespace gxy
