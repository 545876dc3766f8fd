// SPDX-License-Identifier: Apache-2.0
// Ranks that are threads of the test, for what is collective.
#pragma once
#include <atomic>
#include <barrier>
#include <exception>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/comm/collectives.h"
#include "core/comm/error.h"

namespace gxy::test {

/// `size` ranks on threads; a collective operation is a barrier and a look at the others' bytes.
class ThreadRanks {
 public:
  explicit ThreadRanks(int size) : barrier_(size), boxes_(size_t(size)) {}

  /// Runs work(ranks) on every rank; returns each rank's error text, empty where there was none.
  template <class Work>
  std::vector<std::string> run(Work work) {
    std::vector<std::string> errors(boxes_.size());
    std::vector<std::thread> threads;
    for (int r = 0; r < int(boxes_.size()); ++r)
      threads.emplace_back([&, r] {
        Rank rank(*this, r);
        try {
          work(static_cast<Collectives&>(rank));
        } catch (const std::exception& e) {
          errors[size_t(r)] = e.what();
        }
      });
    for (std::thread& thread : threads) thread.join();
    return errors;
  }

 private:
  struct Rank final : Collectives {
    Rank(ThreadRanks& all, int rank) : all_(all), rank_(rank) {}
    int rank() const override { return rank_; }
    int size() const override { return int(all_.boxes_.size()); }
    std::vector<Bytes> allGather(Bytes mine) override {
      return allToAll(std::vector<Bytes>(all_.boxes_.size(), mine));
    }
    std::vector<Bytes> allToAll(std::vector<Bytes> perRank) override {
      all_.boxes_[size_t(rank_)] = std::move(perRank);
      all_.barrier_.arrive_and_wait();
      std::vector<Bytes> mine;
      for (const auto& box : all_.boxes_) mine.push_back(box[size_t(rank_)]);
      all_.barrier_.arrive_and_wait();
      return mine;
    }
    ThreadRanks& all_;
    int rank_;
  };
  std::barrier<> barrier_;
  std::vector<std::vector<Bytes>> boxes_;
};

/// Ranks that are cancelled after some calls of check().
class CancelledRanks final : public Collectives {
 public:
  CancelledRanks(Collectives& ranks, int after) : ranks_(ranks), left_(after) {}
  int rank() const override { return ranks_.rank(); }
  int size() const override { return ranks_.size(); }
  std::vector<Bytes> allGather(Bytes mine) override { return ranks_.allGather(std::move(mine)); }
  std::vector<Bytes> allToAll(std::vector<Bytes> perRank) override {
    return ranks_.allToAll(std::move(perRank));
  }
  void check() const override {
    if (--left_ < 0) throw Error("cancelled");
  }

 private:
  Collectives& ranks_;
  mutable std::atomic<int> left_;
};

}  // namespace gxy::test
