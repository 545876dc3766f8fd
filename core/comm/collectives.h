// SPDX-License-Identifier: Apache-2.0
// Collective operations of the ranks that compute something together, and agreements that are built on them.
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

/// The ranks of one computation. Every rank calls the same operations in the same order. Calls block.
struct Collectives {
  virtual ~Collectives() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  /// Returns the bytes of every rank, by rank, on every rank.
  virtual std::vector<Bytes> allGather(Bytes mine) = 0;
  /// Sends `perRank[r]` to rank r. Returns what each rank has sent to this one, by rank.
  virtual std::vector<Bytes> allToAll(std::vector<Bytes> perRank) = 0;
  /// Returns, on every rank, what `fold` makes of the bytes of all ranks. A rank's messages are as long as what is made of two
  /// ranks' bytes, and those of allGather() as long as the bytes of all ranks together.
  virtual Bytes allReduce(Bytes mine, const Collective::Fold& fold);
  /// Throws Error if the computation has been cancelled. Long loops call it inside agree(), which makes all ranks end, between
  /// files, blocks, and layers of blocks. Any thread may call it.
  virtual void check() const {}
  /// Is told how much of the current call this rank has done, from 0 to 1. Long loops call it where they call check().
  virtual void done(double) const {}
};

/// The only rank of a computation.
struct SingleRank final : Collectives {
  int rank() const override { return 0; }
  int size() const override { return 1; }
  std::vector<Bytes> allGather(Bytes mine) override { return {std::move(mine)}; }
  std::vector<Bytes> allToAll(std::vector<Bytes> perRank) override { return perRank; }
};

/// The ranks of a Transport. They use a Collective with one of its keys.
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
  Bytes allReduce(Bytes mine, const Collective::Fold& fold) override {
    return collective_.allReduce(key_, std::move(mine), fold);
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

/// Returns an Advance that calls check() and then done(). For a part of a call, `first` and `last` say which part it is.
inline Advance advanceOf(const Collectives& ranks, double first = 0, double last = 1) {
  return [&ranks, first, last](double fraction) {
    ranks.check();
    ranks.done(first + fraction * (last - first));
  };
}

/// Runs `work`, which must not communicate, on every rank. If it throws on any rank, every rank throws Error with the message
/// of the lowest rank that failed; if there are several ranks, the message begins with that rank.
void agree(Collectives& ranks, const std::function<void()>& work);

/// Returns the values of every rank, by rank. Every rank gives the same number of them; otherwise ranks throw Error.
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

/// Gives every rank the values that `join(a, b)` makes of those of all ranks, one by one. What it makes must not depend on the order
/// in which it gets them. Every rank gives the same number of values; otherwise ranks throw Error.
template <class T, class Join>
void reduceValues(Collectives& ranks, std::span<T> values, Join join) {
  static_assert(std::is_trivially_copyable_v<T>);
  const auto bytesOfValues = std::as_bytes(values);
  const Bytes all = ranks.allReduce(Bytes(bytesOfValues.begin(), bytesOfValues.end()),
                                    [join](Bytes& into, const Bytes& other) {
                                      if (into.size() != other.size())
                                        return into.clear();  // Those who gave values will find none.
                                      for (size_t at = 0; at < into.size(); at += sizeof(T)) {
                                        T mine, theirs;
                                        std::memcpy(&mine, into.data() + at, sizeof(T));
                                        std::memcpy(&theirs, other.data() + at, sizeof(T));
                                        mine = join(mine, theirs);
                                        std::memcpy(into.data() + at, &mine, sizeof(T));
                                      }
                                    });
  if (all.size() != values.size_bytes()) throw Error("collective operation: ranks disagree about its size");
  if (!all.empty()) std::memcpy(values.data(), all.data(), all.size());
}

/// Returns the count of every rank, by rank.
std::vector<uint64_t> gatherCounts(Collectives& ranks, uint64_t mine);
/// Returns the sum of the counts of all ranks.
uint64_t sumOfCounts(Collectives& ranks, uint64_t mine);

}  // namespace gxy
