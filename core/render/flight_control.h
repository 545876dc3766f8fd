// SPDX-License-Identifier: Apache-2.0
// FlightControl: the life of flights on all ranks. Flights (flights.h) adds the life of their items.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "core/comm/completion.h"
#include "core/comm/trace.h"
#include "core/comm/transport.h"
#include "core/comm/wire.h"
#include "core/render/flight.h"
#include "core/render/task_runner.h"
#include "core/space/ledger.h"

namespace gxy {

/// Starts flights on all ranks, cancels and fails them, and ends them when Completion says that all their
/// items have ended. It keeps what overtakes the start of a flight until then, and it keeps the credits.
///
/// Threads: any thread may call all functions except the constructor and destructor.
class FlightControl {
 public:
  struct Options {
    /// The numbers of its messages.
    struct Channels {
      Channel control, items, credits;
      Channel completion = Channel::Completion;
    } channels;
    /// What a flight, its items and a chunk of new items are called in errors and in the trace.
    struct Words {
      const char *flight, *items, *chunk;
    } words;
    TaskRunner::Options tasks;  ///< with the credits of this rank
    /// The ledger for messages that wait for the start of their flight, and the tenant that they count for;
    /// null: none.
    Ledger* ledger = nullptr;
    std::string tenant;
    Trace* trace = nullptr;  ///< records packets and chunks; may be null; must outlive the object
  };
  using OnComplete = std::function<void(const FlightEnding&)>;
  using OnReport = std::function<void(FlightId, Reader& report)>;

  FlightControl(const FlightControl&) = delete;
  FlightControl& operator=(const FlightControl&) = delete;

  /// Rank 0 only: gives out the number of a flight. It must be begun at some time, because all ranks keep
  /// track of the flights that are over.
  FlightId announce();
  /// Rank 0 only: makes all ranks end the flight's items where they meet them. The flight ends like any
  /// other, but does not count. Does nothing if all its items have ended. It may be called before the flight
  /// begins.
  void cancel(FlightId id);
  /// Ends a flight because this rank could not do its part. Rank 0 is told of the first error of this rank.
  void fail(FlightBase& flight, const std::string& error);
  /// Sends bytes to the OnReport of rank 0, which gets them on its progress thread. They are not counted as
  /// an item, so they may be about a flight that is over.
  void report(FlightId id, const Bytes& report);

  /// Users who send messages of their own that belong to a flight count each as an item: as created before it
  /// is sent, and as retired after it has been taken.
  void created(FlightId id, uint64_t n) { completion_.created(id, n); }
  void retired(FlightId id, uint64_t n) { completion_.retired(id, n); }

  /// Runs the tasks of flights. Users may push their own.
  TaskRunner& tasks() { return tasks_; }

  struct Counters {
    uint64_t itemsForwarded = 0;  ///< sent to other ranks
    uint64_t bytesForwarded = 0, messagesForwarded = 0;
    uint64_t itemsDropped = 0;  ///< ended without having been advanced
    /// Messages with credits that were not sent, because there were no credits to give back.
    uint64_t creditsSkipped = 0;
    uint64_t waves = 0;       ///< rank 0: waves of Completion
    int64_t mostCredits = 0;  ///< most credits out at once
  };
  Counters counters() const;

  /// State that is kept for flights that are not over; all 0 when none is under way.
  struct Kept {
    size_t flights = 0;         ///< started here and not finished
    size_t parkedMessages = 0;  ///< messages of flights that have not started here
    size_t announced = 0;       ///< rank 0: given out and not complete
    size_t completionSets = 0;
    size_t tasks = 0;                           ///< tasks that wait for their turn
    int64_t credits = 0;                        ///< credits out
    std::map<uint32_t, int64_t> tenantCredits;  ///< credits out, by tenant
  };
  Kept kept() const;

 protected:
  using BasePtr = std::shared_ptr<FlightBase>;
  using Make = std::function<BasePtr(FlightId, Reader& parameters)>;
  using Receive = std::function<void(Bytes)>;

  FlightControl(Transport& transport, Options options, Make make, OnReport onReport);
  ~FlightControl() = default;
  /// Begins to receive messages. The last thing that a constructor does.
  void listen();
  /// Receives no more messages, and waits for tasks that run and devices at work. The first thing that a
  /// destructor does.
  void stop();
  void begin(const BasePtr& flight, const Bytes& parameters, OnComplete onComplete);
  BasePtr findOrPark(FlightId id, Bytes& message, Receive receive);
  void dropChunks(FlightBase& flight);
  /// Counts a chunk whose items have all been made.
  void spawnedChunk(FlightBase& flight);
  /// Gives credits back to the rank that took them; negative for children beyond those that their parents
  /// took credits for.
  void giveBack(int origin, const Priority& priority, int64_t credits);
  virtual void receiveItems(Bytes message) = 0;
  virtual std::shared_ptr<TileSource> sourceOf(const BasePtr& flight) = 0;

  Transport& transport_;
  const Options options_;
  Completion completion_;
  TaskRunner tasks_;  ///< destroyed before the Completion, as tasks hold Actives
  mutable std::mutex mutex_;
  Counters counters_;  ///< guarded by mutex_

 private:
  /// A message that came before the start of its flight.
  struct Parked {
    Receive receive;
    Bytes message;
    Completion::Active active;
    LedgerEntry memory;
  };

  void receiveControl(const Bytes& message);
  void receiveCredits(const Bytes& message);
  void sendDown(const Bytes& message);
  void start(const BasePtr& flight, const Bytes& message);
  void park(FlightId id, Bytes message, Receive receive);
  void stopItems(FlightBase& flight);
  void cancelHere(FlightId id);
  void cancelEverywhere(FlightId id);
  void failed(FlightId id, const std::string& error);
  void complete(FlightId id, const OnComplete& onComplete);
  void finish(FlightId id, bool counts);
  BasePtr find(FlightId id) const;
  bool isOver(FlightId id) const { return id < firstNotOver_ || over_.count(id) > 0; }
  std::string name(FlightId id) const { return options_.words.flight + (" " + std::to_string(id)); }

  const Make make_;
  const OnReport onReport_;
  const LedgerEntry parkedMemory_;  ///< has 0 bytes; messages are entered by its another()

  // Guarded by mutex_:
  std::map<FlightId, BasePtr> flights_;
  std::map<FlightId, std::vector<Parked>> parked_;
  FlightId firstNotOver_ = 1;  ///< all flights below this number are over here
  std::set<FlightId> over_;    ///< flights that are over and above firstNotOver_
  std::map<FlightId, FlightEnding>
      endings_;        ///< rank 0: what is known so far of flights that are not complete
  FlightId next_ = 1;  ///< rank 0
};

}  // namespace gxy
