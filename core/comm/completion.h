// SPDX-License-Identifier: Apache-2.0
// When is all work of a set (a frame, an analysis) done, wherever it went? Exact, for any number of sets in
// flight.
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

/// Names a set in all ranks; never used twice in the life of a Completion.
using SetId = uint64_t;

/// Detects when every item (a ray, a pixel contribution) of a set has been retired: Mattern's four counters
/// (Mattern, "Algorithms for distributed termination detection", 1987) over a binary tree of ranks rooted at
/// rank 0.
///
/// The rules that a user follows:
/// 1. Rank 0 calls begin(). This creates one token per rank; the rank retires its token by spawned(), once,
/// after
///    it has created all items that come from nowhere (primary rays).
/// 2. Items are counted by created() before they are sent or posted, and children (secondary rays,
/// contributions)
///    before their parent is retired. An item is retired once, on whatever rank it ends.
/// 3. While items of a set are worked on or queued on a rank, it holds an Active of the set, opened before
/// the last
///    of them is retired or sent on.
///
/// Rank r keeps two counters that only grow. A wave goes down the tree and brings their sums up; a rank lets
/// it pass when it is idle: its token is retired and no Active is open. So no wave moves while some rank is
/// busy, and none of this costs anything but the counting. The set is done when the retired sum of one wave
/// equals the created sum of the next. Exactness does not rest on idleness, on clocks or on the order of
/// messages: let E be the items whose retirement the first wave saw. Each of them, and by rule 2 each of
/// their children, was counted as created before that wave ended, thus is in the created sum of the next. If
/// the sums are equal, that sum counts E and nothing else: the children of E are in E, the tokens are in E,
/// so all items are.
///
/// Any rank may hear of a set first through any call or message. When a set is done each rank forgets it.
///
/// Threads: all calls but the constructor and destructor may come from any thread.
class Completion {
 public:
  explicit Completion(Transport& transport) : Completion(transport, Rule{}) {}

  /// Afterwards no call may come; sets that are not done are forgotten.
  virtual ~Completion();

  Completion(const Completion&) = delete;
  Completion& operator=(const Completion&) = delete;

  /// Rank 0 only. `onDone` is called once, on rank 0's progress thread, when all items are retired; it must
  /// be short.
  void begin(SetId set, std::function<void()> onDone);

  /// This rank retires its token: what it had to spawn is created.
  void spawned(SetId set);

  void created(SetId set, uint64_t n);
  void retired(SetId set, uint64_t n);

  /// The number of sets that this rank keeps counters of.
  size_t setsKept() const;

  /// Waves that rank 0 has started, of all sets.
  uint64_t wavesStarted() const { return waves_; }

 private:
  struct Set;

 public:
  /// Work on items of a set is going on, for as long as this lives. Moves, does not copy.
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
  /// The clauses of the rule, which tests drop one by one to see that each is needed.
  struct Rule {
    bool comparesTwoWaves = true;
    bool tokensAtRoot = true;
    bool answersWhenIdle = true;
  };
  Completion(Transport& transport, Rule rule);

 private:
  std::shared_ptr<Set> find(SetId id);
  void receive(Bytes message);
  void startWave(Set& set);
  void receiveWave(Set& set);
  void receiveAnswer(Set& set, uint64_t created, uint64_t retired);
  void receiveDone(SetId id);
  void answerIfIdle(Set& set);
  void concludeWave(Set& set, uint64_t created, uint64_t retired);
  template <class Action>
  void forEachChild(Action&& action) const;

  Transport& transport_;
  const Rule rule_;
  mutable std::shared_mutex mutex_;  ///< guards sets_, not what is in them
  std::unordered_map<SetId, std::shared_ptr<Set>> sets_;
  std::atomic<uint64_t> waves_ = 0;
};

}  // namespace gxy
