// SPDX-License-Identifier: Apache-2.0
// Long work that all ranks do together for a request, or for several requests: its turn among the tenant's
// works, its cancelling and its progress.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "core/comm/collectives.h"

namespace gxy {

struct ServerRank;
class Request;

/// The party that wants long work done. Both functions are short and not empty, and any thread may call them.
struct Asker {
  std::function<void()> check = [] {};  ///< throws Error "cancelled" once the work is no longer wanted
  /// Reports progress, as Request::progress() does.
  std::function<void(int64_t done, int64_t of, const std::string& text, bool phase)> progress =
      [](int64_t, int64_t, const std::string&, bool) {};
};
/// Returns an Asker that passes everything to the request, which must outlive it.
Asker askerOf(Request& request);

/// There is one on each rank. An exchange is one such work. Rank 0 begins it for a request and sends its
/// number as a parameter of a Work (not of Runs::Short); the action calls join() on all ranks. When the
/// request is cancelled, the parts on all ranks end soon. Thread safe.
class Exchanges {
 public:
  static constexpr int64_t kUnits = 100;  ///< units of progress for each item

  explicit Exchanges(ServerRank& serverRank) : serverRank_(serverRank) {}
  void addWorks();

  /// Begins an exchange on rank 0 and returns its number. It ends when the result is released; the request
  /// must live until then.
  [[nodiscard]] std::shared_ptr<const uint64_t> begin(Request& request);
  /// The same for work that computes for long: waits until the tenant has fewer than Tenants::kLong of these
  /// under way. Throws Error if the request is cancelled.
  [[nodiscard]] std::shared_ptr<const uint64_t> beginLong(Request& request);
  /// The same for a tenant's work that no request has asked for. Waits; throws what `asker.check` throws.
  [[nodiscard]] std::shared_ptr<const uint64_t> beginLong(const std::string& tenant, Asker asker);
  /// The same as begin() for any asker. If it no longer wants the work, it calls cancel() to tell the other ranks.
  [[nodiscard]] std::shared_ptr<const uint64_t> begin(Asker asker);
  void cancel(uint64_t number);
  /// Adds a reason to end an exchange that has begun, on rank 0. `check` is like Asker::check and is called before it.
  void alsoCheck(uint64_t number, std::function<void()> check);

  /// A rank's part of an exchange. One thread uses it, except that any thread may call ranks.check() and
  /// ranks.done(). It must have made all its calls of collectives when it is destroyed.
  class Part {
   public:
    ~Part();
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;

    /// Its check() throws Error "cancelled" once the exchange is cancelled. Its done() reports progress to
    /// the client; only rank 0's counts.
    RankCollectives ranks;

    /// From now on, ranks.done() reports the fraction of item number `item` of `of`. With `phase`, the client
    /// gets this progress event even if it got one just before. Collective: all ranks call it. If check()
    /// throws on any rank, it throws on all.
    void begin(int64_t item, int64_t of, const std::string& text, bool phase = false);

   private:
    friend class Exchanges;
    Part(Exchanges& exchanges, uint64_t number);
    void tell(double fraction, bool phase);

    Exchanges& exchanges_;
    const uint64_t number_;
    int64_t item_ = 0, of_ = 1;
    std::string text_;
  };
  /// Joins an exchange; an action of a Work calls it on every rank.
  Part join(uint64_t number) { return Part(*this, number); }

 private:
  std::shared_ptr<const uint64_t> begin(Request& request, std::shared_ptr<void> turn);
  std::shared_ptr<const uint64_t> begin(Asker asker, std::shared_ptr<void> turn);
  void check(uint64_t number) const;

  ServerRank& serverRank_;
  mutable std::mutex mutex_;
  std::map<uint64_t, Asker> led_;      ///< rank 0: askers of exchanges, by number
  std::map<uint64_t, bool> underWay_;  ///< by number: whether this rank's part has been cancelled
};

}  // namespace gxy
