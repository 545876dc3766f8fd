// SPDX-License-Identifier: Apache-2.0
// What a computation on several ranks needs of the others: two collective operations, and the agreements built on them.
#pragma once
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/comm/advance.h"
#include "core/comm/collective.h"
#include "core/comm/error.h"
#include "core/comm/transport.h"

namespace gxy {

/// The ranks of one computation. Every rank calls the same operations in the same order; calls block.
struct Collectives {
  virtual ~Collectives() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  /// Every rank's bytes, by rank, on every rank.
  virtual std::vector<Bytes> allGather(Bytes mine) = 0;
  /// `perRank[r]` goes to rank r; returns what each rank had for this one, by rank.
  virtual std::vector<Bytes> allToAll(std::vector<Bytes> perRank) = 0;
  /// Throws Error if this rank's part is to end before it is done; called between files, blocks and layers of them, where
  /// agree() makes all ranks end, from any thread.
  virtual void check() const {}
  /// This rank has done so much of the call that it is in, from 0 to 1; called where check() is, beside it.
  virtual void done(double) const {}
};

/// One rank by itself.
struct SingleRank final : Collectives {
  int rank() const override { return 0; }
  int size() const override { return 1; }
  std::vector<Bytes> allGather(Bytes mine) override { return {std::move(mine)}; }
  std::vector<Bytes> allToAll(std::vector<Bytes> perRank) override { return perRank; }
};

/// The ranks of a Transport, over a Collective and one of its keys.
class RankCollectives final : public Collectives {
 public:
  RankCollectives(Collective& collective, int rank, int size, uint64_t key, std::function<void()> check = {},
                  std::function<void(double)> done = {})
      : collective_(collective),
        rank_(rank),
        size_(size),
        key_(key),
        check_(std::move(check)),
        done_(std::move(done)) {}
  int rank() const override { return rank_; }
  int size() const override { return size_; }
  std::vector<Bytes> allGather(Bytes mine) override { return collective_.allGather(key_, std::move(mine)); }
  std::vector<Bytes> allToAll(std::vector<Bytes> perRank) override {
    return collective_.allToAll(key_, std::move(perRank));
  }
  void check() const override {
    if (check_) check_();
  }
  void done(double fraction) const override {
    if (done_) done_(fraction);
  }

 private:
  Collective& collective_;
  int rank_, size_;
  uint64_t key_;
  std::function<void()> check_;
  std::function<void(double)> done_;
};

/// check(), then done(): of a call, or of a part of it that goes from `first` to `last`.
inline Advance advanceOf(const Collectives& ranks, double first = 0, double last = 1) {
  return [&ranks, first, last](double fraction) {
    ranks.check();
    ranks.done(first + fraction * (last - first));
  };
}

/// Runs `work`, which must not communicate, on every rank. If it throws on any rank, throws Error on every
/// rank, with the message of the lowest rank that failed (and that rank, where there are several).
void agree(Collectives& ranks, const std::function<void()>& work);

/// The values of every rank, by rank. Every rank gives the same number of them, else all throw Error.
template <class T>
std::vector<std::vector<T>> gatherValues(Collectives& ranks, std::span<const T> mine) {
  static_assert(std::is_trivially_copyable_v<T>);
  Bytes bytes(mine.size_bytes());
  if (!bytes.empty()) std::memcpy(bytes.data(), mine.data(), bytes.size());
  std::vector<std::vector<T>> all;
  for (const Bytes& theirs : ranks.allGather(std::move(bytes))) {
    if (theirs.size() != mine.size_bytes())
      throw Error("collective operation: ranks disagree about its size");
    all.emplace_back(mine.size());
    if (!theirs.empty()) std::memcpy(all.back().data(), theirs.data(), theirs.size());
  }
  return all;
}

/// The count of every rank, by rank; and their sum.
std::vector<uint64_t> gatherCounts(Collectives& ranks, uint64_t mine);
uint64_t sumOfCounts(Collectives& ranks, uint64_t mine);

}  // namespace gxy
