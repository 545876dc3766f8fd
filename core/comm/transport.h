// SPDX-License-Identifier: Apache-2.0
// Messages between ranks, and tasks on a rank: the interface that all distributed code uses.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace gxy {

using Bytes = std::vector<std::byte>;

/// One number per kind of message. They are listed here so that no two parts of the system use the same number.
/// Number 3 is that of core/comm/presence.h.
enum class Channel : uint16_t {
  Work = 0,        ///< core/comm/work.h
  Completion = 1,  ///< core/comm/completion.h
  Collective = 2,  ///< core/comm/collective.h
  Rays = 8,        ///< core/render
  Contributions = 9,
  Frame = 10,
  Credits = 11,
  Items = 12,  ///< core/analysis: heads of lines
  Flight = 13,
  ItemCredits = 14,
  ItemCompletion = 15,
  Pictures = 16,      ///< multiserver/rendering
  SampleFlight = 20,  ///< core/analysis: rays of samplings
  SampleRays = 21,
  SampleCredits = 22,
  SampleCompletion = 23,
  Test = 64,
};

/// A rank's connection to all ranks. It has two implementations: MpiTransport (mpi_transport.h), and the
/// ranks of an InProcessWorld (in_process.h) with its seeded scheduler. No order is guaranteed between
/// messages, not even between messages of the same sender and channel.
class Transport {
 public:
  using Handler = std::function<void(int source, Bytes message)>;
  using Task = std::function<void()>;

  virtual ~Transport() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;

  /// Sends a message of any size (64-bit) to rank `destination`, which may be this rank. Never blocks and never
  /// refuses a message. Any thread may call it, handlers included. Throws Error if there is no such rank.
  virtual void send(int destination, Channel channel, Bytes message) = 0;

  /// Sets the handler for messages of a channel. Messages that came before there was one are kept, and are
  /// delivered to it now. Handlers run on the rank's progress thread, one at a time, and must be short:
  /// longer work is posted as a task. An empty handler removes the present one. When the call returns, the
  /// old handler is no longer running, so objects that it refers to may be destroyed. Deadlocks if the caller
  /// holds a lock that a handler takes.
  virtual void onMessage(Channel channel, Handler handler) = 0;

  /// Runs a task soon on one of the rank's worker threads (oneTBB). Tasks run in any order. A task must not
  /// wait for other tasks or for messages, and should take about a millisecond: rendering waits for workers,
  /// and no task is interrupted.
  virtual void post(Task task) = 0;

  /// Runs a task on a thread of its own, so that it may wait for tasks and messages of any rank
  /// (collective.h). This is for requests, which are few. The threads are kept and used again.
  virtual void postWaiting(Task task) = 0;

  /// Like postWaiting(), for tasks that compute for long. Their threads have a lower priority than all
  /// others, so that the others get the processors that they need. Their parallel loops (parallel_for.h) run
  /// on the task's own thread. A Transport without priorities calls postWaiting().
  virtual void postLong(Task task) { postWaiting(std::move(task)); }

  /// Announces that something other than a task (a device at work, for example) will post a task from a
  /// thread of its own. InProcessWorld::run() waits until the returned object is destroyed. Other
  /// implementations need not know, and return null.
  virtual std::shared_ptr<void> expectPost() { return nullptr; }

  struct Counters {
    /// Handed to MPI, or to the in-process world. Bytes and packets are counted after messages have been
    /// coalesced into packets, messages before.
    uint64_t bytesSent = 0, packetsSent = 0, messagesSent = 0;
    /// Bytes passed to send() and not yet sent by MPI, now and at most so far; 0 in an in-process world.
    uint64_t bytesWaiting = 0, mostBytesWaiting = 0;
  };
  virtual Counters counters() const = 0;
};

}  // namespace gxy
