// SPDX-License-Identifier: Apache-2.0
// Messages between ranks and tasks on a rank: the interface under everything distributed.
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

/// One number per kind of message; the range of each part of the system is listed here so that they cannot
/// clash.
enum class Channel : uint16_t {
  Work = 0,        ///< core/comm/work.h
  Completion = 1,  ///< core/comm/completion.h
  Collective = 2,  ///< core/comm/collective.h
  Rays = 8,        ///< core/render
  Contributions = 9,
  Frame = 10,
  Credits = 11,
  Pictures = 16,  ///< multiserver/modules/viewer
  Test = 64,
};

/// A rank's connection to all ranks. Two implementations: MpiTransport (mpi_transport.h), and the ranks of an
/// InProcessWorld (in_process.h) with its seeded scheduler. No order is guaranteed between messages, not even
/// of the same sender and channel.
class Transport {
 public:
  using Handler = std::function<void(int source, Bytes message)>;
  using Task = std::function<void()>;

  virtual ~Transport() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;

  /// Hands over a message of any size (64-bit) for `destination` (may be this rank). Never blocks, always
  /// accepts; callable from any thread, handlers included.
  virtual void send(int destination, Channel channel, Bytes message) = 0;

  /// Sets what happens to messages of a channel; messages that came earlier are kept and delivered then. A
  /// handler runs on the rank's progress thread, one at a time, and must be short: longer work is posted as a
  /// task. An empty handler removes the one there is; when the call returns it is not running any more, so
  /// what it refers to may go. (From a thread that holds a lock which a handler takes, this would deadlock.)
  virtual void onMessage(Channel channel, Handler handler) = 0;

  /// Runs a task soon on one of the rank's worker threads (oneTBB), in any order. It must not wait for other tasks or for
  /// messages, and takes a millisecond or so: all that is rendered waits for a worker, and no task is interrupted.
  virtual void post(Task task) = 0;

  /// Runs a task on a thread that it does not share, so that it may wait for tasks and messages of any rank
  /// (collective.h). For requests, which are few; the threads are kept and used again.
  virtual void postWaiting(Task task) = 0;

  /// The same for what computes long: its threads are of lower priority than the others, so that these get the processors
  /// that they want. Its loops (parallel_for.h) run on its own thread. Where nothing has a priority, postWaiting().
  virtual void postLong(Task task) { postWaiting(std::move(task)); }

  /// Says that something which is no task, as a device at work, will post one from a thread of its own: until what this
  /// returns is gone InProcessWorld::run() waits for it. Others need not know, and return null.
  virtual std::shared_ptr<void> expectPost() { return nullptr; }

  /// Bytes and messages handed to MPI (or to the in-process world), after coalescing; and messages before it.
  struct Counters {
    uint64_t bytesSent = 0, packetsSent = 0, messagesSent = 0;
    /// Waiting to be sent, now and at most: handed over and not yet taken by MPI (0 in an in-process world).
    uint64_t bytesWaiting = 0, mostBytesWaiting = 0;
  };
  virtual Counters counters() const = 0;
};

}  // namespace gxy
