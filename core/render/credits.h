// SPDX-License-Identifier: Apache-2.0
// Credits: how many rays of a rank may be in flight, and how many of these each tenant may have.
#pragma once
#include <cstdint>
#include <map>
#include <utility>

#include "core/render/priority.h"

namespace gxy {

/// The credits of one rank. Credits come back only when rays end, so whoever takes must leave some free for
/// those who come later: a tenant may have at most 7 times as many credits as stay free (Choudhury and Hahne,
/// "Dynamic queue length thresholds for shared-memory packet switches", 1998). One tenant alone thus gets at
/// most 7/8, each of two 7/15, and each of n 7/(1 + 7n). The streams of a tenant share its part by the same
/// rule. A tenant that has no credits out may take all that are free. If no credits are out at all, a tile
/// may be spawned whatever it costs. Not thread safe.
class Credits {
 public:
  explicit Credits(int64_t all) : all_(all) {}

  bool mayTake(const Priority& priority, int64_t cost) const;
  void take(const Priority& priority, int64_t cost);
  /// `credits` is negative when a primary made more secondary rays than it took credits for.
  void giveBack(const Priority& priority, int64_t credits);

  int64_t all() const { return all_; }
  int64_t out() const { return out_; }
  int64_t mostOut() const { return mostOut_; }
  int64_t outOfTenant(const Priority& priority) const;
  int64_t outOfStream(const Priority& priority) const;
  /// Credits out; only those that are not 0.
  const std::map<uint32_t, int64_t>& byTenant() const { return tenants_; }

 private:
  void change(const Priority& priority, int64_t by);

  const int64_t all_;
  int64_t out_ = 0, mostOut_ = 0;
  std::map<uint32_t, int64_t> tenants_;
  std::map<std::pair<uint32_t, uint64_t>, int64_t> streams_;  ///< credits out, likewise
};

}  // namespace gxy
