// SPDX-License-Identifier: Apache-2.0
// Tracer: stream lines through fields on all ranks. The heads of lines are the items of a flight.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "core/analysis/trace_share.h"
#include "core/comm/collectives.h"
#include "core/comm/transport.h"
#include "core/render/flights.h"

namespace gxy {

/// Traces lines together with the Tracers of all other ranks; each rank has one, over its Transport. Any
/// number of traces may be under way.
///
/// A head lives on one rank at a time. The rank advances it through the blocks that it has, stores the
/// points of its way, and sends it on to the rank of the partition where it goes on. Seeds travel like heads,
/// so they may be on any rank. What becomes of a line, to the last bit, depends neither on the ranks nor on
/// the partitions, nor on the order of messages (DeviceFields::advance()).
///
/// Heads are advanced in Transport::postLong() tasks, so that rendering does not wait for them. Credits bound
/// the heads that are under way: a rank makes heads of its seeds only while it has credits.
///
/// Threads: any thread may call all functions except the constructor and destructor.
class Tracer {
 public:
  struct Options {
    int64_t heads = int64_t(1) << 18;  ///< most heads of one rank's seeds under way
    int packetHeads = 4096;            ///< most heads that are advanced together
    int runners = 2;                   ///< most packets of one rank that are advanced at once; 0: no limit
    /// Whether tasks are Transport::postLong() tasks. Otherwise they are post() tasks.
    bool longTasks = true;
    /// The ledger for heads ("heads") and for messages that wait, and the tenant that these count for. It may
    /// be null, and must outlive the object.
    Ledger* ledger = nullptr;
    std::string tenant;
    Trace* trace = nullptr;  ///< records packets; may be null; must outlive the object
    std::function<std::chrono::nanoseconds()> processorTime = PacketSize::processorTime;
  };

  /// `transport` must outlive the object. Throws Error for options that cannot be.
  Tracer(Transport& transport, Options options);
  /// Waits for tasks that run. Drops the rest of traces that are under way.
  ~Tracer();
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;

  /// Collective, and waits for the trace to end: call it where a Collective may be called. `ranks` are all
  /// ranks of the Transport. Calls ranks.check() every 20 ms. If that throws on any rank, if a request
  /// cannot be fulfilled (there is no memory, say), or if a device fails, then the trace ends on all ranks,
  /// nothing of it is kept, and all ranks throw Error with the same message; if there are several ranks, it
  /// begins with the rank. Tells ranks.done() the fraction of lines that have ended.
  TracedLines trace(TraceRequest request, Collectives& ranks);

  // The parts of trace(), none of which waits:

  /// Rank 0 only: gives out the number of a trace, which must be begun at some time.
  FlightId announce() { return flights_.announce(); }
  /// On each rank, before rank 0 begins the trace: gives the rank's part, whose request is as trace() checks
  /// it.
  void join(FlightId id, std::shared_ptr<TraceShare> share);
  /// Rank 0 only: begins the trace. `onComplete` is called once, on rank 0's progress thread, when all heads
  /// have ended on all ranks and before TraceShare::end(). It must be short.
  void begin(FlightId id, std::function<void(const FlightEnding&)> onComplete);
  /// Ends a trace that is begun or announced, because of `why`. If nothing else has ended it before, its
  /// error is "rank 2: why". Does nothing if all heads have ended.
  void stop(FlightId id, const std::string& why);
  /// Lets rank 0 know how many lines have ended here.
  void tellEnds(FlightId id, uint64_t ends);
  /// Rank 0: how many lines have ended on other ranks, as far as they have told.
  uint64_t endsElsewhere(FlightId id) const;
  /// Forgets a trace that has ended here; join() is undone.
  void leave(FlightId id);

  FlightControl::Counters counters() const { return flights_.counters(); }
  /// What is kept for traces under way.
  struct Kept {
    FlightControl::Kept flights;
    size_t shares = 0;  ///< joined and not left
  };
  Kept kept() const;

 private:
  using FlightPtr = Flights<AdvanceResult>::FlightPtr;
  struct Joined {
    std::shared_ptr<TraceShare> share;
    std::map<int, uint64_t> ends;  ///< rank 0: the number of lines that have ended, by other rank
    std::string stopped;           ///< rank 0: why the trace was stopped; empty: it was not
  };
  class HeadFlight;

  std::shared_ptr<TraceShare> find(FlightId id) const;
  FlightPtr readFlight(FlightId id, Reader& in);
  void receiveReport(FlightId id, Reader& in);
  void stopped(FlightId id, const std::string& why);
  FlightEnding endingOf(FlightId id, FlightEnding ending) const;

  Transport& transport_;
  const Options options_;
  mutable std::mutex mutex_;
  std::map<FlightId, Joined> joined_;  ///< guarded by mutex_
  Flights<AdvanceResult> flights_;     ///< the last member: its tasks use all others
};

}  // namespace gxy
