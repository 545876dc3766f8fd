// SPDX-License-Identifier: Apache-2.0
// The Transport between processes, over MPI.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>

#include "core/comm/mailbox.h"
#include "core/comm/transport.h"

namespace gxy {

/// Only the rank's progress thread calls MPI, on a communicator of Galaxy's own. Messages that are sent while
/// it works are coalesced, per destination, into packets; larger ones stream from the sender's memory into
/// the receiver's. Without traffic the thread sleeps up to 4 ms at a time, and after two quiet seconds 16 ms, or
/// less where ranks are on several nodes (backoff.h), but wakes at once when this rank sends something. After
/// traffic it polls without sleeping for a moment, unless the node has fewer cores than threads.
///
/// Construction and destruction are collective. The destructor returns when all ranks are in their
/// destructors, all messages have been delivered and all tasks have run, including those sent or posted
/// meanwhile. It uses the rule of completion.h. Messages that still have no handler then are dropped.
///
/// An exception that leaves a handler or task goes to `onError`. If MPI itself fails, or there is no memory
/// for an announced message, this is reported and the job ends by MPI_Abort.
class MpiTransport final : public Transport {
 public:
  struct Options {
    /// Points to the MPI_Comm to duplicate, whose ranks become Galaxy's; null: MPI_COMM_WORLD.
    const void* communicator = nullptr;
    int threads = 0;                ///< oneTBB threads for tasks; 0: the node's cores / its ranks
    size_t packetBytes = 64 << 10;  ///< packet size, 256 to 2^30; messages over about half are streamed
    size_t chunkBytes = 16 << 20;   ///< bytes of one MPI call when streaming, at most 2^30
    ErrorReport onError = logError;
    Trace* trace = nullptr;  ///< gets a stage for each handled message; outlives the Transport
    int role = 0;            ///< rankOnNode() counts the ranks with the same role; not negative
  };

  /// Initialises MPI if nobody has (mpi_environment.h). Throws Error if an option is out of range.
  explicit MpiTransport(Options options);
  MpiTransport() : MpiTransport(Options{}) {}
  ~MpiTransport() override;

  int rank() const override;
  int size() const override;
  void send(int destination, Channel channel, Bytes message) override;
  void onMessage(Channel channel, Handler handler) override;
  void post(Task task) override;
  void postWaiting(Task task) override;
  void postLong(Task task) override;
  Counters counters() const override;

  /// What has gone to other ranks and what has come from them: messages, and their bytes without what packets add.
  struct Traffic {
    uint64_t messagesSent = 0, bytesSent = 0, messagesReceived = 0, bytesReceived = 0;
  };
  /// Returns the traffic of each channel that had any.
  std::map<Channel, Traffic> traffic() const;
  /// The number of ranks that this one has sent messages to or got messages from.
  int partners() const;

  /// Ends all ranks of the run, including those that hang, by MPI_Abort. Use it when a rank will never answer
  /// again. The progress thread calls MPI_Abort, after this function has returned.
  void abort();

  /// The number of threads that run tasks.
  int threads() const;
  /// The index of this rank among the ranks on its node with the same role, from 0.
  int rankOnNode() const;

 private:
  class Progress;
  std::unique_ptr<Progress> progress_;
};

}  // namespace gxy
