// SPDX-License-Identifier: Apache-2.0
// Transport between processes, over MPI.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>

#include "core/comm/mailbox.h"
#include "core/comm/transport.h"

namespace gxy {

/// The rank's progress thread is the only caller of MPI on a communicator of Galaxy's own. Messages that are
/// handed over while it works are coalesced, per destination, into packets; larger ones stream from the
/// sender's memory into the receiver's. Without traffic the thread sleeps, up to 4 ms at a time, 16 ms after two
/// quiet seconds, but wakes at once when something is sent here; after traffic it stays hot for a moment, unless the
/// node has fewer cores than threads.
///
/// Constructing and destroying are collective. The destructor returns when all ranks are in their destructors
/// and all messages have been delivered and all tasks run, those included that were sent or posted meanwhile:
/// it uses the rule of completion.h. Messages that nobody has a handler for are dropped then.
///
/// An exception out of a handler or task goes to `onError`. A failure of MPI itself or no memory for a
/// message that has been announced ends the job by MPI_Abort, after it has been reported.
class MpiTransport final : public Transport {
 public:
  struct Options {
    /// Points to the MPI_Comm to duplicate, its ranks become Galaxy's; null: MPI_COMM_WORLD.
    const void* communicator = nullptr;
    int threads = 0;                ///< oneTBB threads for tasks; 0: the node's cores shared by its ranks
    size_t packetBytes = 64 << 10;  ///< of a packet; a message over about half of it is streamed
    size_t chunkBytes = 16 << 20;   ///< of one MPI call when streaming, at most 2^30
    ErrorReport onError = logError;
    Trace* trace = nullptr;  ///< of the messages that are handled; outlives the Transport
    int role = 0;            ///< rankOnNode() counts the ranks that have the same; not negative
  };

  /// Initialises MPI if need be (mpi_environment.h). Throws Error on options out of range.
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

  /// Ends all ranks of the run, those that hang included, by MPI_Abort: for when a rank never will answer again. Returns before
  /// that has happened.
  void abort();

  /// Threads that run tasks.
  int threads() const;
  /// Which this is of the ranks on its node that have its role, from 0.
  int rankOnNode() const;

 private:
  class Progress;
  std::unique_ptr<Progress> progress_;
};

}  // namespace gxy
