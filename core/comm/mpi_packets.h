// SPDX-License-Identifier: Apache-2.0
// Messages to MPI calls and back. Private to core/comm: it shows mpi.h. One thread only.
#pragma once
#include <mpi.h>

#include <deque>
#include <functional>
#include <list>
#include <vector>

#include "core/comm/mailbox.h"
#include "core/comm/transport.h"

namespace gxy {

/// Sizes on the wire, equal on all ranks. A packet is a sequence of records: a RecordHeader, then the message
/// if it is small. A large message follows its header on a tag of its own, in chunks straight from and into
/// its own memory. MPI keeps the order of messages with one tag between two ranks, which pairs headers with
/// chunks.
struct PacketSizes {
  size_t packet;         ///< bytes, at most
  size_t chunk;          ///< bytes, at most 2^30: MPI counts are int
  size_t small() const;  ///< larger messages are streamed
};

/// Coalesces messages per destination.
class PacketSender {
 public:
  PacketSender(MPI_Comm communicator, int ranks, PacketSizes sizes);

  /// Takes a message; packets that are full leave.
  void add(int destination, Channel channel, Bytes message);

  /// All packets leave.
  void flush();

  /// Frees what MPI has sent; true when that was something.
  bool reap();

  /// Waits until MPI has sent all.
  void finish();

  bool idle() const { return requests_.empty(); }

  /// Memory of what has been added and not yet been sent.
  uint64_t bytesHeld() const { return held_; }
  uint64_t bytesSent() const { return bytes_; }
  uint64_t packetsSent() const { return packets_; }  ///< chunks included

 private:
  void leave(int destination);
  void start(const std::byte* data, size_t size, int destination, int tag);

  const MPI_Comm communicator_;
  const PacketSizes sizes_;
  std::vector<Bytes> open_;  ///< by destination: the packet that is being filled
  std::vector<int> filled_;  ///< destinations with an open packet
  std::vector<MPI_Request> requests_;
  std::vector<Bytes>
      owners_;  ///< of the memory that the request of the same index reads; empty: the one before
  uint64_t bytes_ = 0, packets_ = 0, held_ = 0;
};

/// Takes packets apart.
class PacketReceiver {
 public:
  using Deliver = std::function<void(Delivery)>;

  PacketReceiver(MPI_Comm communicator, PacketSizes sizes) : communicator_(communicator), sizes_(sizes) {}

  /// Receives what is there; true when something came.
  bool poll(const Deliver& deliver);

  /// Nothing has arrived in part.
  bool idle() const { return packets_.empty() && large_.empty(); }

 private:
  struct Packet {
    int source;
    Bytes bytes;
    MPI_Request request;
  };
  struct Large {
    Delivery delivery;
    std::vector<MPI_Request> chunks;
    size_t missing;
  };

  bool match();
  void unpack(const Packet& packet, const Deliver& deliver);
  void startLarge(int source, Channel channel, uint64_t size);

  const MPI_Comm communicator_;
  const PacketSizes sizes_;
  std::deque<Packet> packets_;  ///< in the order in which they were matched, and are taken apart
  std::list<Large> large_;
};

}  // namespace gxy
