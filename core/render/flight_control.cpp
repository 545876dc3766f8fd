// SPDX-License-Identifier: Apache-2.0
#include "core/render/flight_control.h"

#include <utility>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/comm/tree.h"

namespace gxy {

namespace {

/// The first two and the last three go down the tree of ranks and to rank 0.
enum class Message : uint8_t { Start, Cancel, Finish, Report, Failed };

Writer head(Message kind, FlightId id) {
  Writer w;
  w.write(kind).write(id);
  return w;
}

}  // namespace

FlightControl::FlightControl(Transport& transport, Options options, Make make, OnReport onReport)
    : transport_(transport),
      options_(std::move(options)),
      completion_(transport, options_.channels.completion),
      tasks_(transport, options_.tasks),
      make_(std::move(make)),
      onReport_(std::move(onReport)),
      parkedMemory_(options_.ledger ? options_.ledger->enter(options_.tenant, "parked messages", 0)
                                    : LedgerEntry()) {}

void FlightControl::listen() {
  const Options::Channels& channels = options_.channels;
  transport_.onMessage(channels.control, [this](int, const Bytes& m) { receiveControl(m); });
  transport_.onMessage(channels.items, [this](int, Bytes m) { receiveItems(std::move(m)); });
  transport_.onMessage(channels.credits, [this](int, const Bytes& m) { receiveCredits(m); });
}

void FlightControl::stop() {
  const Options::Channels& channels = options_.channels;
  for (Channel c : {channels.control, channels.items, channels.credits}) transport_.onMessage(c, {});
  tasks_.close();
}

FlightControl::Counters FlightControl::counters() const {
  std::lock_guard lock(mutex_);
  Counters counters = counters_;
  counters.waves = completion_.wavesStarted();
  counters.mostCredits = tasks_.queue().credits().mostOut();
  return counters;
}

FlightControl::Kept FlightControl::kept() const {
  Kept kept;
  kept.completionSets = completion_.setsKept();
  kept.tasks = tasks_.queue().size();
  const Credits credits = tasks_.queue().credits();
  kept.credits = credits.out();
  kept.tenantCredits = credits.byTenant();
  std::lock_guard lock(mutex_);
  kept.flights = flights_.size();
  for (const auto& [id, messages] : parked_) kept.parkedMessages += messages.size();
  kept.announced = endings_.size();
  return kept;
}

// ----------------------------------------------------------------------------------------------------------
// begin

FlightId FlightControl::announce() {
  std::lock_guard lock(mutex_);
  endings_[next_];
  return next_++;
}

void FlightControl::begin(const BasePtr& flight, const Bytes& parameters, OnComplete onComplete) {
  const FlightId id = flight->id;
  completion_.begin(id, [this, id, onComplete = std::move(onComplete)] { complete(id, onComplete); });
  Bytes message = head(Message::Start, id).take();
  message.insert(message.end(), parameters.begin(), parameters.end());
  start(flight, message);
}

void FlightControl::start(const BasePtr& flight, const Bytes& message) {
  sendDown(message);
  const FlightId id = flight->id;
  try {
    flight->prepare();
    flight->prepared_ = true;
    flight->unspawned_ = flight->chunks();
  } catch (const std::exception& e) {
    fail(*flight, textOf(e));  // before other ranks can end the flight
  }
  // Asked here, since other threads take chunks once the flight is known.
  const bool spawnsNothing = flight->unspawned_ == 0;

  std::vector<Parked> parked;
  {
    std::lock_guard lock(mutex_);
    flights_[id] = flight;
    if (const auto waiting = parked_.extract(id)) parked = std::move(waiting.mapped());
  }
  // Each in a task of its own, so that a refused one does not keep others back, and before the chunks, since
  // one may say that the flight is cancelled.
  for (Parked& p : parked)
    tasks_.push(
        flight->priority(), id,
        [p = std::make_shared<Parked>(std::move(p))] { p->receive(std::move(p->message)); }, true);
  if (spawnsNothing) return completion_.spawned(id);
  tasks_.queue().addTiles(flight->priority(), id, sourceOf(flight));
  if (flight->cancelled()) dropChunks(*flight);
  tasks_.start();
}

void FlightControl::spawnedChunk(FlightBase& flight) {
  if (--flight.unspawned_ == 0) completion_.spawned(flight.id);
}

FlightControl::BasePtr FlightControl::find(FlightId id) const {
  const auto it = flights_.find(id);
  return it == flights_.end() ? nullptr : it->second;
}

// Returns the flight of a message. If it has not started, the message is taken and kept until then, and null
// is returned.
FlightControl::BasePtr FlightControl::findOrPark(FlightId id, Bytes& message, Receive receive) {
  std::lock_guard lock(mutex_);
  if (isOver(id)) throw Error("a message came for " + name(id) + ", which is over");
  BasePtr flight = find(id);
  if (!flight) park(id, std::move(message), std::move(receive));
  return flight;
}

// Called with the lock held.
void FlightControl::park(FlightId id, Bytes message, Receive receive) {
  LedgerEntry memory = parkedMemory_.another(int64_t(message.size()));
  parked_[id].push_back({std::move(receive), std::move(message), {completion_, id}, std::move(memory)});
}

// ----------------------------------------------------------------------------------------------------------
// end

void FlightControl::cancel(FlightId id) {
  {
    std::lock_guard lock(mutex_);
    const auto ending = endings_.find(id);
    if (ending == endings_.end() || std::exchange(ending->second.cancelled, true)) return;
  }
  cancelEverywhere(id);
}

void FlightControl::cancelEverywhere(FlightId id) {
  sendDown(head(Message::Cancel, id).take());
  cancelHere(id);
}

void FlightControl::cancelHere(FlightId id) {
  BasePtr flight;
  {
    std::lock_guard lock(mutex_);
    if (isOver(id)) return;
    flight = find(id);
    if (!flight) return park(id, {}, [this, id](Bytes) { cancelHere(id); });
  }
  stopItems(*flight);
}

// Makes the items that wait on this rank end untouched, also those in a device, and no more be made.
void FlightControl::stopItems(FlightBase& flight) {
  flight.cancelled_ = true;
  flight.onCancel();
  dropChunks(flight);
}

void FlightControl::dropChunks(FlightBase& flight) {
  if (!tasks_.queue().dropTiles(flight.priority(), flight.id)) return;
  if ((flight.unspawned_ -= flight.chunks()) == 0) completion_.spawned(flight.id);
}

// The message to rank 0 counts as an item, so the flight does not end before it is received.
void FlightControl::fail(FlightBase& flight, const std::string& error) {
  stopItems(flight);
  if (flight.failed_.exchange(true)) return;
  completion_.created(flight.id, 1);
  const std::string told = "rank " + std::to_string(transport_.rank()) + ": " + error;
  transport_.send(0, options_.channels.control, head(Message::Failed, flight.id).write(told).take());
}

// Rank 0: the first error of a flight counts. Where all ranks fail, they are told once that it is cancelled.
void FlightControl::failed(FlightId id, const std::string& error) {
  bool isFirst = false;
  {
    std::lock_guard lock(mutex_);
    const auto ending = endings_.find(id);
    if (ending == endings_.end()) throw Error(name(id) + " was said to have failed, but is not under way");
    isFirst = ending->second.error.empty();
    if (isFirst) ending->second.error = error;
  }
  if (isFirst) cancelEverywhere(id);
  completion_.retired(id, 1);
}

// Rank 0: called once, when all items have ended. Decides for all ranks whether the flight counts.
void FlightControl::complete(FlightId id, const OnComplete& onComplete) {
  FlightEnding ending;
  {
    std::lock_guard lock(mutex_);
    ending = std::move(endings_.extract(id).mapped());
  }
  onComplete(ending);
  sendDown(head(Message::Finish, id).write(ending.counts()).take());
  finish(id, ending.counts());
}

void FlightControl::finish(FlightId id, bool counts) {
  BasePtr flight;
  {
    std::lock_guard lock(mutex_);
    flight = find(id);
    if (!flight) throw Error(name(id) + " was said to be finished, but is not under way");
    flights_.erase(id);
    over_.insert(id);
    while (over_.erase(firstNotOver_)) firstNotOver_++;
  }
  flight->end(counts);
}

void FlightControl::report(FlightId id, const Bytes& report) {
  Bytes message = head(Message::Report, id).take();
  message.insert(message.end(), report.begin(), report.end());
  transport_.send(0, options_.channels.control, std::move(message));
}

// ----------------------------------------------------------------------------------------------------------
// messages

// Sends a message down a binary tree rooted at rank 0. Each rank passes on what it receives.
void FlightControl::sendDown(const Bytes& message) {
  forEachTreeChild(transport_.rank(), 0, transport_.size(),
                   [&](int child) { transport_.send(child, options_.channels.control, message); });
}

void FlightControl::receiveControl(const Bytes& message) {
  const std::string what = std::string(options_.words.flight) + " message";
  Reader in(message, what);
  const auto kind = in.read<Message>();
  const auto id = in.read<FlightId>();
  if (kind > Message::Failed) in.fail("its kind is " + std::to_string(int(kind)) + ", expected 0 to 4");
  if (id == 0 || (kind >= Message::Report) != (transport_.rank() == 0))
    in.fail("it is not for rank " + std::to_string(transport_.rank()));
  if (kind == Message::Start) {
    const BasePtr flight = make_(id, in);
    in.expectEnd();
    {
      std::lock_guard lock(mutex_);
      if (find(id) || isOver(id)) in.fail(name(id) + " has started before");
    }
    start(flight, message);
  } else if (kind == Message::Cancel) {
    in.expectEnd();
    sendDown(message);
    cancelHere(id);
  } else if (kind == Message::Finish) {
    const bool counts = in.read<bool>();
    in.expectEnd();
    sendDown(message);
    finish(id, counts);
  } else if (kind == Message::Failed) {
    const std::string error = in.readString();
    in.expectEnd();
    failed(id, error);
  } else {
    onReport_(id, in);
  }
}

void FlightControl::receiveCredits(const Bytes& message) {
  Reader in(message, "credits");
  Priority priority;
  priority.tenant = in.read<uint32_t>();
  priority.stream = in.read<uint64_t>();
  const auto credits = in.read<int64_t>();  // negative for children beyond what their parents took
  in.expectEnd();
  constexpr int64_t kMost = int64_t(1) << 40;  // far beyond those of a packet's items
  if (credits < -kMost || credits > kMost)
    in.fail(std::to_string(credits) + " credits come back, expected at most " + std::to_string(kMost));
  giveBack(transport_.rank(), priority, credits);
}

void FlightControl::giveBack(int origin, const Priority& priority, int64_t credits) {
  if (credits == 0) {
    if (origin == transport_.rank()) return;
    std::lock_guard lock(mutex_);
    counters_.creditsSkipped++;
    return;
  }
  if (origin != transport_.rank()) {
    Writer w;
    w.write(priority.tenant).write(priority.stream).write(credits);
    transport_.send(origin, options_.channels.credits, w.take());
    return;
  }
  tasks_.queue().giveBack(priority, credits);
  tasks_.start();  // there may be room for a chunk now
}

}  // namespace gxy
