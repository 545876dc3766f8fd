// SPDX-License-Identifier: Apache-2.0
#include "core/comm/mpi_packets.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/comm/wire.h"

namespace gxy {

namespace {

constexpr int matchesPerPoll = 64;  // limited, so that sending gets its turn

enum Tag : int { packetTag = 0, chunkTag = 1 };

struct RecordHeader {
  uint64_t size;
  Channel channel;
  uint16_t large;  ///< 1: the message comes in chunks
  uint32_t unused = 0;
};

}  // namespace

size_t PacketSizes::small() const { return packet / 2 - sizeof(RecordHeader); }

PacketSender::PacketSender(MPI_Comm communicator, int ranks, PacketSizes sizes)
    : communicator_(communicator), sizes_(sizes), open_(size_t(ranks)) {}

void PacketSender::add(int destination, Channel channel, Bytes message) {
  const bool large = message.size() > sizes_.small();
  const size_t record = sizeof(RecordHeader) + (large ? 0 : message.size());
  held_ += sizeof(RecordHeader) + message.size();
  Bytes& packet = open_[destination];
  if (packet.size() + record > sizes_.packet) leave(destination);
  if (packet.empty()) filled_.push_back(destination);
  const RecordHeader header{message.size(), channel, large};
  const auto* start = reinterpret_cast<const std::byte*>(&header);
  packet.insert(packet.end(), start, start + sizeof header);
  if (!large) {
    packet.insert(packet.end(), message.begin(), message.end());
    return;
  }
  leave(destination);
  const std::byte* data = message.data();
  for (size_t at = 0; at < message.size(); at += sizes_.chunk)
    this->start(data + at, std::min(sizes_.chunk, message.size() - at), destination, chunkTag);
  owners_.back() = std::move(message);  // The last chunk's request owns the message: see reap().
}

void PacketSender::flush() {
  for (const int destination : std::exchange(filled_, {}))
    if (!open_[destination].empty()) leave(destination);
}

void PacketSender::leave(int destination) {
  Bytes packet = std::exchange(open_[destination], {});
  start(packet.data(), packet.size(), destination, packetTag);
  owners_.back() = std::move(packet);
}

void PacketSender::start(const std::byte* data, size_t size, int destination, int tag) {
  MPI_Request request;
  MPI_Isend(data, int(size), MPI_BYTE, destination, tag, communicator_, &request);
  requests_.push_back(request);
  owners_.emplace_back();
  bytes_ += size;
  ++packets_;
}

bool PacketSender::reap() {
  if (requests_.empty()) return false;
  int done = 0;
  std::vector<int> indices(requests_.size());
  MPI_Testsome(int(requests_.size()), requests_.data(), &done, indices.data(), MPI_STATUSES_IGNORE);
  if (done <= 0) return false;
  // A chunk without an owner reads memory that a later entry owns. While the chunk is under way, that entry
  // is kept.
  size_t kept = 0;
  bool chunkUnderWay = false;
  for (size_t i = 0; i < requests_.size(); ++i) {
    const bool finished = requests_[i] == MPI_REQUEST_NULL;
    if (owners_[i].empty()) {
      chunkUnderWay |= !finished;
      if (finished) continue;
    } else if (finished && !std::exchange(chunkUnderWay, false)) {
      held_ -= owners_[i].size();
      continue;
    }
    requests_[kept] = requests_[i];
    std::swap(owners_[kept], owners_[i]);
    ++kept;
  }
  requests_.resize(kept);
  owners_.resize(kept);
  return true;
}

void PacketSender::finish() {
  MPI_Waitall(int(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
  requests_.clear();
  owners_.clear();
  held_ = 0;
}

bool PacketReceiver::poll(const Deliver& deliver) {
  bool active = false;
  for (int i = 0; i < matchesPerPoll && match(); ++i) active = true;
  int done = 1;
  while (!packets_.empty()) {
    MPI_Test(&packets_.front().request, &done, MPI_STATUS_IGNORE);
    if (!done) break;
    const Packet packet = std::move(packets_.front());
    packets_.pop_front();
    unpack(packet, deliver);
    active = true;
  }
  std::vector<int> indices;
  for (auto it = large_.begin(); it != large_.end();) {
    indices.resize(it->chunks.size());
    MPI_Testsome(int(it->chunks.size()), it->chunks.data(), &done, indices.data(), MPI_STATUSES_IGNORE);
    if (done > 0) {
      active = true;
      it->missing -= size_t(done);
    }
    if (it->missing > 0) {
      ++it;
      continue;
    }
    deliver(std::move(it->delivery));
    it = large_.erase(it);
  }
  return active;
}

bool PacketReceiver::match() {
  int there = 0, size = 0;
  MPI_Message message;
  MPI_Status status;
  MPI_Improbe(MPI_ANY_SOURCE, packetTag, communicator_, &there, &message, &status);
  if (!there) return false;
  MPI_Get_count(&status, MPI_BYTE, &size);
  Packet& packet = packets_.emplace_back(Packet{status.MPI_SOURCE, Bytes(size_t(size)), MPI_REQUEST_NULL});
  MPI_Imrecv(packet.bytes.data(), size, MPI_BYTE, &message, &packet.request);
  return true;
}

void PacketReceiver::unpack(const Packet& packet, const Deliver& deliver) {
  std::span<const std::byte> rest = packet.bytes;
  while (!rest.empty()) {
    Reader reader(rest, "packet");
    const auto header = reader.read<RecordHeader>();
    rest = reader.rest();
    if (header.large) {
      startLarge(packet.source, header.channel, header.size);
      continue;
    }
    if (header.size > rest.size()) reader.fail("a record is longer than its packet");
    const auto body = rest.first(header.size);
    rest = rest.subspan(header.size);
    deliver({packet.source, header.channel, Bytes(body.begin(), body.end())});
  }
}

void PacketReceiver::startLarge(int source, Channel channel, uint64_t size) {
  Large& large = large_.emplace_back(Large{{source, channel, Bytes(size)}, {}, 0});
  Bytes& bytes = large.delivery.message;
  for (size_t at = 0; at < size; at += sizes_.chunk) {
    const int count = int(std::min<size_t>(sizes_.chunk, size - at));
    MPI_Irecv(bytes.data() + at, count, MPI_BYTE, source, chunkTag, communicator_,
              &large.chunks.emplace_back(MPI_REQUEST_NULL));
  }
  large.missing = large.chunks.size();
}

}  // namespace gxy
