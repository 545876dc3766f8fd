// SPDX-License-Identifier: Apache-2.0
// Detects exactly when all work of a set (a frame, an analysis) is done on all ranks, for any number of sets
// at once.
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <unordered_map>

#include "core/comm/transport.h"

namespace gxy {

/// Names a set on all ranks. It is never used twice in the life of a Completion.
using SetId = uint64_t;

/// Detects when every item (a ray, a pixel contribution) of a set has been retired. The method is Mattern's
/// four counters (Mattern, "Algorithms for distributed termination detection", 1987) over a binary tree of
/// ranks rooted at rank 0.
///
/// A user follows three rules:
/// 1. Rank 0 calls begin(). This creates one token per rank. Each rank retires its token by calling spawned() once, after
///    it has created all items that have no parent (primary rays).
/// 2. Items are counted by created() before they are sent or posted. Children (secondary rays, contributions) are counted
///    before their parent is retired. An item is retired once, on the rank where it ends.
/// 3. While a rank works on items of a set or has them queued, it holds an Active of the set. It opens the Active before
///    the last of these items is retired or sent on.
///
/// Each rank keeps two counters that only grow: items created and items retired. A wave goes down the tree
/// and brings the sums of the counters up. A rank answers a wave when it is idle: its token is retired and no
/// Active is open. So no wave moves while some rank is busy, and the only cost is counting. The set is done
/// when the retired sum of one wave equals the created sum of the next. Exactness does not depend on
/// idleness, clocks or the order of messages. Proof: let E be the items whose retirement the first wave saw.
/// Each of them, and by rule 2 each of their children, was counted as created before that wave ended, and so
/// is in the created sum of the next. If the sums are equal, that sum counts E and nothing else. Then the
/// children of E are in E and the tokens are in E, so all items are in E.
///
/// A rank may learn of a set from any call or message. When a set is done, each rank forgets it.
///
/// Threads: any thread may call all functions except the constructor and destructor.
class Completion {
 public:
  /// Each Completion over a Transport has a channel of its own, the same on all ranks.
  explicit Completion(Transport& transport, Channel channel = Channel::Completion)
      : Completion(transport, Rule{}, channel) {}

  /// Forgets sets that are not done.
  virtual ~Completion();

  Completion(const Completion&) = delete;
  Completion& operator=(const Completion&) = delete;

  /// Begins a set; only rank 0 may call it. `onDone` is called once, on rank 0's progress thread, when all
  /// items are retired. It must be short. Throws Error on other ranks, and if the set has begun before.
  void begin(SetId set, std::function<void()> onDone);

  /// Retires this rank's token: it has created all its items that have no parent.
  void spawned(SetId set);

  void created(SetId set, uint64_t n);
  void retired(SetId set, uint64_t n);

  /// The number of sets that this rank keeps counters of.
  size_t setsKept() const;

  /// The number of waves that rank 0 has started, for all sets together.
  uint64_t wavesStarted() const { return waves_; }

 private:
  struct Set;

 public:
  /// While an Active of a set lives, this rank is working on items of the set.
  class Active {
   public:
    Active(Completion& completion, SetId set);
    ~Active();
    Active(Active&& other) noexcept : completion_(other.completion_), set_(std::move(other.set_)) {}
    Active& operator=(Active&&) = delete;

   private:
    Completion& completion_;
    std::shared_ptr<Set> set_;
  };

 protected:
  /// The conditions of the method. Tests drop them one by one to check that each is needed.
  struct Rule {
    bool comparesTwoWaves = true;
    bool tokensAtRoot = true;
    bool answersWhenIdle = true;
  };
  Completion(Transport& transport, Rule rule, Channel channel = Channel::Completion);

 private:
  std::shared_ptr<Set> find(SetId id);
  void receive(Bytes message);
  void startWave(Set& set);
  void receiveWave(Set& set);
  void receiveAnswer(Set& set, uint64_t created, uint64_t retired);
  void receiveDone(SetId id);
  void answerIfIdle(Set& set);
  void concludeWave(Set& set, uint64_t created, uint64_t retired);
  void sendDown(const Bytes& message);

  Transport& transport_;
  const Rule rule_;
  const Channel channel_;
  mutable std::shared_mutex mutex_;  ///< guards the map sets_, not the sets in it
  std::unordered_map<SetId, std::shared_ptr<Set>> sets_;
  std::atomic<uint64_t> waves_ = 0;
};

}  // namespace gxy
