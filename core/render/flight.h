// SPDX-License-Identifier: Apache-2.0
// Flight: one set of items that travel between ranks, as one rank sees it. Users say here what the items are
// and what is done with them; Flights (flights.h) does what is the same for all kinds of items.
#pragma once
#include <atomic>
#include <concepts>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/comm/transport.h"
#include "core/rays/packet_size.h"
#include "core/render/priority.h"
#include "core/space/ledger.h"

namespace gxy {

/// The number of a flight on all ranks, and the SetId of its items. It is never 0 and never used twice.
using FlightId = uint64_t;

/// A movable list of items (rays, heads of lines, ...) of one kind in one partition. A kind is a number that
/// the user gives items: those of a kind take the same number of bytes in a message and the same number of
/// credits.
template <class T>
concept ItemList = std::movable<T> && requires(const T& list, int most, Bytes& message, uint32_t kind) {
  { list.partition } -> std::convertible_to<int>;
  { list.kind() } -> std::same_as<uint32_t>;
  { list.size() } -> std::same_as<int>;
  { list.bytes() } -> std::same_as<int64_t>;             // of memory
  { list.split(most) } -> std::same_as<std::vector<T>>;  // into lists of at most so many items, in order
  {list.write(message)};                                 // appends size() * wireBytes(kind()) bytes
  { T::wireBytes(kind) } -> std::convertible_to<int>;    // bytes of one item; 0: there is no such kind
};

/// What becomes of items that are advanced through one partition, or that are new. The user adds to it
/// whatever he deposits.
template <class T>
concept ItemResult = std::movable<T> && std::default_initializable<T> && requires(T& result) {
  requires ItemList<typename std::remove_cvref_t<decltype(result.leaving)>::value_type>;
  {result.leaving.front()};                        // lists of items that go on, and of new ones
  { result.retired } -> std::same_as<uint64_t&>;   // items that have ended
  { result.created } -> std::same_as<uint64_t&>;   // items in `leaving` that are new: children
  { result.error } -> std::same_as<std::string&>;  // not empty: the call failed, and only `retired` counts
};

/// How a flight has ended.
struct FlightEnding {
  bool cancelled = false;
  std::string error;  ///< the first error of any rank, as "rank 3: <reason>"
  /// Whether all has been done: its results are whole.
  bool counts() const { return !cancelled && error.empty(); }
};

/// The part of a Flight that does not depend on the kind of items.
///
/// Threads: Flights calls the functions from any thread, and several at once, unless it is said otherwise.
class FlightBase {
 public:
  /// Of items that are advanced together there are at most `packetItems`, and fewer where they take long.
  FlightBase(FlightId id, int packetItems) : id(id), packet_(packetItems) {}
  virtual ~FlightBase() = default;
  FlightBase(const FlightBase&) = delete;
  FlightBase& operator=(const FlightBase&) = delete;

  const FlightId id;
  /// Whether the items that are left end where they are met, because the flight was cancelled or a rank has
  /// failed.
  bool cancelled() const { return cancelled_; }

  /// Makes what this rank needs before it can advance items. Called once, before all functions below. What it
  /// throws fails the flight, and items that come to this rank end; of the functions below then only
  /// priority(), creditsOf(), onCancel() and end() are called.
  virtual void prepare() = 0;
  /// Whose turn the flight's tasks run in, and whose credits its items take. The tenant and the stream always
  /// stay the same.
  virtual Priority priority() const = 0;

  /// A rank makes its items without a parent (primary rays, seeds) in *chunks*, when there are credits for
  /// them. This is the number of chunks to be taken yet. This and the next function are called with a lock
  /// held, and by one thread at a time.
  virtual size_t chunks() const = 0;
  /// The most credits that the items of the next chunk take.
  virtual int64_t cost() const = 0;
  /// Credits that an item of a kind takes: 1, and 1 for each child that it is expected to have, as children
  /// take theirs from their parent.
  virtual int64_t creditsOf(uint32_t kind) const = 0;

  /// Enters the memory of a list of items that waits or is advanced in the ledger.
  virtual LedgerEntry hold(int64_t bytes) const = 0;
  /// Called when the flight is cancelled, perhaps more than once, and perhaps where prepare() has failed: for
  /// items that wait in a device.
  virtual void onCancel() {}
  /// Called once on each rank after all items have ended on all ranks, on the progress thread: it must be
  /// short. `counts`: see FlightEnding.
  virtual void end(bool counts) = 0;

 private:
  friend class FlightControl;
  template <ItemResult Result>
  friend class Flights;

  PacketSize packet_;
  bool prepared_ = false;
  std::atomic<bool> cancelled_ = false;
  std::atomic<bool> failed_ = false;   ///< this rank has told rank 0 of an error
  std::atomic<size_t> unspawned_ = 0;  ///< chunks whose items have not all been made
};

/// One flight on one rank, and its *act*: what is done with its items. Users derive from it.
template <ItemResult Result>
class Flight : public FlightBase {
 public:
  using Items = typename decltype(Result::leaving)::value_type;
  /// Takes a result, on any thread. It is called once: before the function that got it returns, or later.
  using Done = std::function<void(Result)>;
  using FlightBase::FlightBase;

  /// The rank of a partition.
  virtual int owner(int partition) const = 0;
  /// Takes the next chunk, and returns a function that makes its items: all are `leaving`, and may be in
  /// partitions of any rank. Called as chunks() is; the function is called later, without a lock.
  virtual std::function<void(Done)> takeChunk() = 0;
  /// Advances a packet through a partition of this rank until each item has ended or left it. It may throw
  /// instead of calling `done`.
  virtual void advance(Items packet, Done done) = 0;
  /// Takes what a result has besides its items, before these are sent on or retired.
  virtual void deposit(Result& result) = 0;
  /// Reads `count` items from a message of another rank, of the size that ItemList::wireBytes() asks for.
  /// Throws Error if a partition of this rank cannot have such items. That fails the flight.
  virtual Items read(int partition, uint32_t kind, int count, std::span<const std::byte> bytes) const = 0;
};

}  // namespace gxy
