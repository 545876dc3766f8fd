// SPDX-License-Identifier: Apache-2.0
// Long work that all ranks do together for a request, or for several: its turn among the tenant's, its end and its progress.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "core/io/collectives.h"

namespace gxy {

struct Node;
class Request;

/// Who wants long work done. Both are called from any thread, are short, and are not empty.
struct Asker {
  std::function<void()> check = [] {};  ///< throws Error "cancelled" once it is wanted no more
  /// As Request::progress.
  std::function<void(int64_t done, int64_t of, const std::string& text, bool phase)> progress =
      [](int64_t, int64_t, const std::string&, bool) {};
};
/// For as long as the request lives.
Asker askerOf(Request& request);

/// One on each rank. Rank 0 begins an exchange for a request and tells its number to a work (not of Runs::Short), which
/// join()s it on all ranks. When the request is cancelled, its parts end soon. Thread safe.
class Exchanges {
 public:
  static constexpr int64_t kUnits = 100;  ///< of progress that an item counts

  explicit Exchanges(Node& node) : node_(node) {}
  void addWorks();

  /// Rank 0: its number, until let go; the request outlives it.
  [[nodiscard]] std::shared_ptr<const uint64_t> begin(Request& request);
  /// The same for what computes long: waits until the tenant has fewer than Tenants::kLong of these under way. Throws Error
  /// when the request is cancelled.
  [[nodiscard]] std::shared_ptr<const uint64_t> beginLong(Request& request);
  /// begin() for another asker. Where it wants the work no more, cancel() tells the other ranks.
  [[nodiscard]] std::shared_ptr<const uint64_t> begin(Asker asker);
  void cancel(uint64_t number);

  /// A rank's part of an exchange; used by one thread, but for check() and done() of its ranks. What it has to say to the
  /// other ranks has been said when it goes.
  class Part {
   public:
    ~Part();
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;

    /// Its check() throws Error "cancelled" when it is time; its done() is told to the client, by rank 0 for all.
    RankCollectives ranks;

    /// What ranks.done() is a share of from now on: item number `item` of `of`. Throws as check() does, on all ranks: they
    /// all call it. With `phase`, the client hears of it whatever came just before.
    void begin(int64_t item, int64_t of, const std::string& text, bool phase = false);

   private:
    friend class Exchanges;
    Part(Exchanges& exchanges, uint64_t number);
    void tell(double share, bool phase);

    Exchanges& exchanges_;
    const uint64_t number_;
    int64_t item_ = 0, of_ = 1;
    std::string text_;
  };
  /// In a work, on every rank.
  Part join(uint64_t number) { return Part(*this, number); }

 private:
  std::shared_ptr<const uint64_t> begin(Request& request, std::shared_ptr<void> turn);
  std::shared_ptr<const uint64_t> begin(Asker asker, std::shared_ptr<void> turn);
  void check(uint64_t number) const;

  Node& node_;
  mutable std::mutex mutex_;
  std::map<uint64_t, const Asker> led_;  ///< rank 0: by number
  std::map<uint64_t, bool> underWay_;    ///< parts of this rank, and whether they are to end
};

}  // namespace gxy
