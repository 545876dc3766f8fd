// SPDX-License-Identifier: Apache-2.0
#include "core/comm/collective.h"

#include <utility>

#include "core/comm/error.h"
#include "core/comm/tree.h"
#include "core/comm/wire.h"

namespace gxy {

enum class Collective::Kind : uint8_t {
  Gathered,  ///< a rank's part, sent to the collecting rank
  Direct,    ///< a rank's part, sent to the rank that it is for
  Whole,     ///< the bytes for all ranks, sent down the tree
};

struct Collective::Header {
  Kind kind;
  int32_t root;
  uint64_t key, step;
};

Collective::Collective(Transport& transport) : transport_(transport) {
  transport_.onMessage(Channel::Collective, [this](int source, Bytes message) { receive(source, message); });
}

Collective::~Collective() { transport_.onMessage(Channel::Collective, nullptr); }

std::vector<Bytes> Collective::allGather(uint64_t key, Bytes mine) {
  const Call call = next(key);
  const int collector = int(key % uint64_t(transport_.size()));
  send(collector, Kind::Gathered, call, collector, std::move(mine));
  const Bytes whole = waitForWhole(call);
  Reader reader(whole, "gathered parts");
  std::vector<Bytes> parts(transport_.size());
  for (auto& part : parts) part = reader.readVector<std::byte>();
  reader.expectEnd();
  return parts;
}

std::vector<Bytes> Collective::allToAll(uint64_t key, std::vector<Bytes> perRank) {
  if (perRank.size() != size_t(transport_.size()))
    throw Error("Collective::allToAll: " + std::to_string(perRank.size()) +
                " entries, expected one for each of " + std::to_string(transport_.size()) + " ranks");
  const Call call = next(key);
  for (int r = 0; r < transport_.size(); ++r) send(r, Kind::Direct, call, r, std::move(perRank[r]));
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return arrived_[call].count == transport_.size(); });
  std::vector<Bytes> parts;
  for (auto& part : arrived_[call].parts) parts.push_back(std::move(*part));
  arrived_.erase(call);
  return parts;
}

Bytes Collective::broadcast(uint64_t key, int root, Bytes bytes) {
  const Call call = next(key);
  if (transport_.rank() != root) return waitForWhole(call);
  sendDownTree(call, root, bytes);
  return bytes;
}

void Collective::barrier(uint64_t key) { allGather(key, {}); }

void Collective::agree(uint64_t key, const std::optional<std::string>& error) {
  Writer writer;
  writer.write(error.has_value()).write(error.value_or(""));
  const auto all = allGather(key, writer.take());
  std::string message;
  for (size_t r = 0; r < all.size(); ++r) {
    Reader reader(all[r], "agreement");
    if (!reader.read<bool>()) continue;
    message += (message.empty() ? "rank " : "; rank ") + std::to_string(r) + ": " + reader.readString();
  }
  if (!message.empty()) throw Error(message);
}

void Collective::finish(uint64_t key) {
  std::lock_guard lock(mutex_);
  calls_.erase(key);
}

Collective::Call Collective::next(uint64_t key) {
  std::lock_guard lock(mutex_);
  return {key, calls_[key]++};
}

void Collective::send(int destination, Kind kind, Call call, int root, Bytes body) {
  Writer writer;
  writer.write(Header{kind, root, call.first, call.second}).write(body);
  transport_.send(destination, Channel::Collective, writer.take());
}

void Collective::sendDownTree(Call call, int root, const Bytes& body) {
  forEachTreeChild(transport_.rank(), root, transport_.size(),
                   [&](int child) { send(child, Kind::Whole, call, root, body); });
}

void Collective::receive(int source, const Bytes& message) {
  Reader reader(message, "collective");
  const auto header = reader.read<Header>();
  const Call call{header.key, header.step};
  auto body = reader.readVector<std::byte>();
  reader.expectEnd();
  if (header.kind > Kind::Whole || header.root < 0 || header.root >= transport_.size())
    reader.fail("kind " + std::to_string(int(header.kind)) + ", root " + std::to_string(header.root));
  if (header.kind != Kind::Whole) return receivePart(source, header.kind, call, std::move(body));
  sendDownTree(call, header.root, body);
  {
    std::lock_guard lock(mutex_);
    arrived_[call].whole = std::move(body);
  }
  changed_.notify_all();
}

void Collective::receivePart(int source, Kind kind, Call call, Bytes body) {
  Writer whole;
  {
    std::lock_guard lock(mutex_);
    Arrived& arrived = arrived_[call];
    arrived.parts.resize(transport_.size());
    if (arrived.parts[source])
      throw Error("collective: rank " + std::to_string(source) + " made call " + std::to_string(call.second) +
                  " of key " + std::to_string(call.first) + " twice");
    arrived.parts[source] = std::move(body);
    if (++arrived.count < transport_.size()) return;
    if (kind == Kind::Gathered) {
      for (const auto& part : arrived.parts) whole.write(*part);
      arrived_.erase(call);
    }
  }
  // The collector is the root of the tree. It sends the whole to itself, and receive() passes it on to its
  // children.
  if (kind == Kind::Gathered)
    send(transport_.rank(), Kind::Whole, call, transport_.rank(), whole.take());
  else
    changed_.notify_all();
}

Bytes Collective::waitForWhole(Call call) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] {
    const auto found = arrived_.find(call);
    return found != arrived_.end() && found->second.whole;
  });
  return std::move(*arrived_.extract(call).mapped().whole);
}

}  // namespace gxy
