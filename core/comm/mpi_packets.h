// SPDX-License-Identifier: Apache-2.0
// Turns messages into MPI calls and back. Private to core/comm, because it includes mpi.h. Only one
// thread may use it.
#pragma once
#include <mpi.h>

#include <deque>
#include <functional>
#include <list>
#include <vector>

#include "core/comm/mailbox.h"
#include "core/comm/transport.h"

namespace gxy {

/// Sizes on the wire, equal on all ranks. A packet is a sequence of records. A record is a RecordHeader,
/// followed by the message if it is small. A large message follows its header in chunks with an MPI tag of
/// their own, which MPI copies directly from and to the message's memory. MPI keeps the order of messages
/// with one tag between two ranks, and that order pairs headers with chunks.
struct PacketSizes {
  size_t packet;         ///< maximal size of a packet in bytes
  size_t chunk;          ///< size of a chunk in bytes, at most 2^30 because MPI counts are int
  size_t small() const;  ///< larger messages are streamed
};

/// Coalesces messages per destination into packets, and sends these.
class PacketSender {
 public:
  PacketSender(MPI_Comm communicator, int ranks, PacketSizes sizes);

  /// Takes a message. Sends the destination's packet when it is full.
  void add(int destination, Channel channel, Bytes message);

  /// Sends all packets that have been begun.
  void flush();

  /// Frees the memory that MPI has sent; returns whether there was any.
  bool reap();

  /// Waits until MPI has sent everything.
  void finish();

  bool idle() const { return requests_.empty(); }

  /// Bytes of messages that have been added and not yet been sent.
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
  /// By request: the memory that it reads. Empty for a chunk that is not the last of its message: the
  /// last one owns it.
  std::vector<Bytes> owners_;
  uint64_t bytes_ = 0, packets_ = 0, held_ = 0;
};

/// Receives packets and chunks, and takes them apart into messages.
class PacketReceiver {
 public:
  using Deliver = std::function<void(Delivery)>;

  PacketReceiver(MPI_Comm communicator, PacketSizes sizes) : communicator_(communicator), sizes_(sizes) {}

  /// Receives what has arrived and passes complete messages to `deliver`. Returns whether anything came.
  bool poll(const Deliver& deliver);

  /// True if no message has arrived in part.
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
  std::deque<Packet> packets_;  ///< in the order in which they were matched and will be taken apart
  std::list<Large> large_;
};

}  // namespace gxy
