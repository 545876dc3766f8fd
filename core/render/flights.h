// SPDX-License-Identifier: Apache-2.0
// Flights: items that travel between ranks, of any number of flights. They are made against credits, advanced
// in packets, sent on and retired.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "core/comm/error_text.h"
#include "core/render/flight_control.h"

namespace gxy {

/// Carries out flights together with the Flights of all other ranks; each rank has one, over its Transport.
/// What the items are, and what is done with them, say the user's classes derived from Flight.
///
/// Rank 0 begins a flight and makes it known down a tree of ranks; its parameters, and the generations of
/// data that it pins, travel in that first message. Each rank makes its items without a parent, in chunks.
/// Items live on one rank at a time. They are advanced where they are and forwarded to the rank of the
/// partition where they go on. A flight is complete when Completion says that all items of all ranks have
/// been retired.
///
/// Memory: credits bound the items. Items take credits of the rank that made them (FlightBase::creditsOf),
/// and give them back wherever they and their children end. A rank takes chunks only while it has credits.
/// Items that arrive are always accepted, since ranks that refused each other's items would wait for ever.
/// Children beyond those that an item took credits for put its rank into debt.
///
/// Order: chunks and packets take turns as ReadyQueue says. A task advances one packet, and puts the rest
/// off.
///
/// Errors: an act that throws, or whose result has an error, fails its flight: rank 0 is told, the flight's
/// items end where they are met, and other flights go on. Messages that a Flights would not send are refused
/// with an Error. If their flight is under way it fails, and their items count as ended.
///
/// Threads: any thread may call all functions except the constructor and destructor.
template <ItemResult Result>
class Flights final : public FlightControl {
 public:
  using Flight = gxy::Flight<Result>;
  using FlightPtr = std::shared_ptr<Flight>;
  using Items = typename Flight::Items;
  /// Makes a flight from its parameters, on every rank but 0. Throws Error if they are malformed.
  using Make = std::function<FlightPtr(FlightId, Reader& parameters)>;

  /// `make` and `onReport` may be called before the constructor returns. `transport` must outlive the object.
  Flights(Transport& transport, Options options, Make make, OnReport onReport)
      : FlightControl(transport, std::move(options), std::move(make), std::move(onReport)) {
    listen();
  }
  /// Waits for running tasks and for devices at work. Drops the rest of the work of flights that are under
  /// way.
  ~Flights() { stop(); }

  /// Rank 0 only: starts a flight whose number announce() has given out. `flight` is rank 0's own; the other
  /// ranks make theirs from `parameters`. `onComplete` is called once, on rank 0's progress thread, before
  /// any FlightBase::end(). It must be short.
  void begin(const FlightPtr& flight, const Bytes& parameters, OnComplete onComplete) {
    FlightControl::begin(flight, parameters, std::move(onComplete));
  }

  /// Finds the flight that a message of the user's belongs to. If it has not started here, `message` is taken
  /// and kept, null is returned, and `receive` is called with it in a task when the flight has started.
  /// Throws Error if the flight is over.
  FlightPtr findOrPark(FlightId id, Bytes& message, Receive receive) {
    return std::static_pointer_cast<Flight>(FlightControl::findOrPark(id, message, std::move(receive)));
  }

 private:
  /// A list of items on this rank, and its entry in the ledger.
  struct Queued {
    Items items;
    LedgerEntry memory;
  };
  using Stack = std::vector<Queued>;
  using Call = std::function<void(typename Flight::Done)>;
  using Then = std::function<void(Result&, Stack&)>;
  struct ItemsHeader {
    FlightId flight;
    int32_t partition, origin, count;
    uint32_t kind;
  };

  /// A call to an act. The result may come before or after the call returns; whichever is second takes `next`
  /// and goes on. What a device may still keep of the call then holds nothing.
  struct PendingCall {
    struct Next {
      std::shared_ptr<void> inside, expected;  ///< make these Flights and the Transport wait for the result
      FlightPtr flight;
      int origin;
      Then then;
      Completion::Active active;
      Result result;
    };
    std::mutex mutex;
    bool answered = false, left = false;
    std::shared_ptr<Next> next;
  };

  /// The chunks of a flight, which the ReadyQueue calls tiles.
  class Chunks final : public TileSource {
   public:
    Chunks(Flights& flights, FlightPtr flight) : flights_(flights), flight_(std::move(flight)) {}
    bool empty() const override { return flight_->chunks() == 0; }
    int64_t cost() const override { return flight_->cost(); }
    std::function<void()> take() override {
      const int64_t cost = flight_->cost();
      auto active = std::make_shared<Completion::Active>(flights_.completion_, flight_->id);
      return [&flights = flights_, flight = flight_, cost, spawn = flight_->takeChunk(), active] {
        flights.spawnChunk(flight, spawn, cost);
      };
    }

   private:
    Flights& flights_;
    const FlightPtr flight_;
  };

  std::shared_ptr<TileSource> sourceOf(const BasePtr& flight) override {
    return std::make_shared<Chunks>(*this, std::static_pointer_cast<Flight>(flight));
  }

  // `origin`, here and below: the rank that made the items or their ancestors. Their credits go back to it.
  void spawnChunk(const FlightPtr& flight, const Call& spawn, int64_t reserved);
  void spawned(const FlightPtr& flight, Result& result, int64_t reserved, Stack& stack);
  void take(const FlightPtr& flight, int origin, Result& result, Stack& stack);
  void advanced(const FlightPtr& flight, int origin, uint32_t kind, Result& result, Stack& stack);
  void drop(Flight& flight, int origin, uint32_t kind, uint64_t items);
  void process(const FlightPtr& flight, int origin, Stack stack);
  void putOff(const FlightPtr& flight, int origin, Stack rest);
  void call(const FlightPtr& flight, int origin, uint64_t items, const Call& call, Then then, Stack& stack);
  void answered(PendingCall& call, Result result);
  static Queued hold(const Flight& flight, Items items);
  void forward(const Flight& flight, int rank, int origin, const Items& items);
  void receiveItems(Bytes message) override;
};

// Calls an act. If the result is there when the call returns, it goes to `then` with the caller's stack;
// otherwise it goes to `then` with a new stack, in a task of its own. No thread waits for a device.
template <ItemResult Result>
void Flights<Result>::call(const FlightPtr& flight, int origin, uint64_t items, const Call& call, Then then,
                           Stack& stack) {
  const auto pending = std::make_shared<PendingCall>();
  pending->next.reset(new typename PendingCall::Next{tasks_.stay(),
                                                     transport_.expectPost(),
                                                     flight,
                                                     origin,
                                                     std::move(then),
                                                     {completion_, flight->id},
                                                     {}});
  try {
    call([this, pending](Result result) { answered(*pending, std::move(result)); });
  } catch (const std::exception& e) {
    pending->next->result.retired = items;
    pending->next->result.error = textOf(e);
    pending->answered = true;
  }
  std::shared_ptr<typename PendingCall::Next> next;
  {
    std::lock_guard lock(pending->mutex);
    pending->left = true;
    if (pending->answered) next = std::move(pending->next);
  }
  if (next) next->then(next->result, stack);
}

template <ItemResult Result>
void Flights<Result>::answered(PendingCall& call, Result result) {
  std::shared_ptr<typename PendingCall::Next> next;
  {
    std::lock_guard lock(call.mutex);
    call.answered = true;
    call.next->result = std::move(result);
    if (!call.left) return;
    next = std::move(call.next);
  }
  // The queued task does not keep these Flights waiting, because it may never run.
  const std::shared_ptr<void> inside = std::move(next->inside), expected = std::move(next->expected);
  const FlightPtr flight = next->flight;
  tasks_.push(flight->priority(), flight->id, [this, next = std::move(next)] {
    Stack stack;
    next->then(next->result, stack);
    process(next->flight, next->origin, std::move(stack));
  });
}

template <ItemResult Result>
void Flights<Result>::spawnChunk(const FlightPtr& flight, const Call& spawn, int64_t reserved) {
  Stack stack;
  Result nothing;
  const Trace::Span span(options_.trace, options_.words.chunk, flight->id);
  if (flight->cancelled())
    spawned(flight, nothing, reserved, stack);
  else
    call(
        flight, transport_.rank(), 0, spawn,
        [this, flight, reserved](Result& result, Stack& rest) { spawned(flight, result, reserved, rest); },
        stack);
  process(flight, transport_.rank(), std::move(stack));
}

template <ItemResult Result>
void Flights<Result>::spawned(const FlightPtr& flight, Result& result, int64_t reserved, Stack& stack) {
  for (const Items& items : result.leaving) {
    created(flight->id, uint64_t(items.size()));
    reserved -= items.size() * flight->creditsOf(items.kind());
  }
  take(flight, transport_.rank(), result, stack);
  spawnedChunk(*flight);
  giveBack(transport_.rank(), flight->priority(), reserved);
}

template <ItemResult Result>
typename Flights<Result>::Queued Flights<Result>::hold(const Flight& flight, Items items) {
  LedgerEntry memory = flight.hold(items.bytes());
  return {std::move(items), std::move(memory)};
}

// Distributes a result: to the act, to other ranks, and to this rank's stack.
template <ItemResult Result>
void Flights<Result>::take(const FlightPtr& flight, int origin, Result& result, Stack& stack) {
  if (!result.error.empty()) fail(*flight, result.error);
  flight->deposit(result);
  for (Items& items : result.leaving) {
    const int rank = flight->owner(items.partition);
    if (rank == transport_.rank())
      stack.push_back(hold(*flight, std::move(items)));
    else
      forward(*flight, rank, origin, items);
  }
}

template <ItemResult Result>
void Flights<Result>::advanced(const FlightPtr& flight, int origin, uint32_t kind, Result& result,
                               Stack& stack) {
  created(flight->id, result.created);
  take(flight, origin, result, stack);
  retired(flight->id, result.retired);
  const int64_t credits = int64_t(result.retired) * flight->creditsOf(kind) - int64_t(result.created);
  giveBack(origin, flight->priority(), credits);
}

// Ends items that will not be advanced.
template <ItemResult Result>
void Flights<Result>::drop(Flight& flight, int origin, uint32_t kind, uint64_t items) {
  {
    std::lock_guard lock(mutex_);
    counters_.itemsDropped += items;
  }
  retired(flight.id, items);
  giveBack(origin, flight.priority(), int64_t(items) * flight.creditsOf(kind));
}

// Advances one packet. Puts off the rest, and all items that it leaves on this rank.
template <ItemResult Result>
void Flights<Result>::process(const FlightPtr& flight, int origin, Stack stack) {
  while (!stack.empty()) {
    Queued next = std::move(stack.back());
    stack.pop_back();
    const int most = flight->packet_.rays();
    if (next.items.size() > most) {  // in packets, the last one first
      for (Items& part : next.items.split(most)) stack.push_back(hold(*flight, std::move(part)));
      continue;
    }
    const auto items = uint64_t(next.items.size());
    const uint32_t kind = next.items.kind();
    if (flight->cancelled()) {
      drop(*flight, origin, kind, items);
      continue;
    }
    const Trace::Span span(options_.trace, "packet", items);
    // Kept until the result is there.
    const auto memory = std::make_shared<LedgerEntry>(std::move(next.memory));
    const auto begin = options_.tasks.processorTime();
    call(
        flight, origin, items,
        [&](typename Flight::Done done) { flight->advance(std::move(next.items), std::move(done)); },
        [this, flight, origin, kind, memory](Result& result, Stack& rest) {
          advanced(flight, origin, kind, result, rest);
        },
        stack);
    flight->packet_.took(int(items), options_.tasks.processorTime() - begin);
    if (!stack.empty()) putOff(flight, origin, std::move(stack));
    return;
  }
}

// Queues the rest of a task for later.
template <ItemResult Result>
void Flights<Result>::putOff(const FlightPtr& flight, int origin, Stack rest) {
  auto active = std::make_shared<Completion::Active>(completion_, flight->id);
  auto held = std::make_shared<Stack>(std::move(rest));
  tasks_.push(
      flight->priority(), flight->id,
      [this, flight, origin, active, held] { process(flight, origin, std::move(*held)); }, true);
}

template <ItemResult Result>
void Flights<Result>::forward(const Flight& flight, int rank, int origin, const Items& items) {
  Writer header;
  header.write(ItemsHeader{flight.id, items.partition, origin, items.size(), items.kind()});
  Bytes message = header.take();
  items.write(message);
  {
    std::lock_guard lock(mutex_);
    counters_.itemsForwarded += uint64_t(items.size());
    counters_.bytesForwarded += message.size();
    counters_.messagesForwarded++;
  }
  transport_.send(rank, options_.channels.items, std::move(message));
}

template <ItemResult Result>
void Flights<Result>::receiveItems(Bytes message) {
  Reader in(message, options_.words.items);
  const auto header = in.read<ItemsHeader>();
  const auto bytes = size_t(Items::wireBytes(header.kind));
  if (bytes == 0 || header.flight == 0 || header.count < 1 || header.origin < 0 ||
      header.origin >= transport_.size() || in.rest().size() != size_t(header.count) * bytes)
    in.fail("its header does not fit its " + std::to_string(message.size()) + " bytes");
  const FlightPtr flight =
      findOrPark(header.flight, message, [this](Bytes parked) { receiveItems(std::move(parked)); });
  if (!flight) return;
  const auto count = uint64_t(header.count);
  if (!flight->prepared_) return drop(*flight, header.origin, header.kind, count);
  auto active = std::make_shared<Completion::Active>(completion_, header.flight);
  auto held = std::make_shared<Stack>();  // shared, because tasks are copied
  try {
    held->push_back(hold(*flight, flight->read(header.partition, header.kind, header.count, in.rest())));
  } catch (const std::exception& e) {  // the flight must end all the same
    fail(*flight, textOf(e));
    drop(*flight, header.origin, header.kind, count);
    throw;
  }
  tasks_.push(flight->priority(), flight->id, [this, flight, origin = header.origin, active, held] {
    process(flight, origin, std::move(*held));
  });
}

}  // namespace gxy
