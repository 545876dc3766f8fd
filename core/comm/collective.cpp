// SPDX-License-Identifier: Apache-2.0
#include "core/comm/collective.h"

#include <utility>

#include "core/comm/error.h"
#include "core/comm/tree.h"
#include "core/comm/wire.h"

namespace gxy {

enum class Collective::Kind : uint8_t {
  Up,      ///< what a subtree gives, sent to its parent in the tree
  Whole,   ///< the bytes for all ranks, sent down the tree
  Direct,  ///< a rank's part, sent to the rank that it is for
  Notice,  ///< for how many ranks there are direct parts, by rank
};

struct Collective::Header {
  Kind kind;
  int32_t at;  ///< root of the tree, or step of the notices
  uint64_t key, step;
};

Collective::Collective(Transport& transport) : transport_(transport) {
  transport_.onMessage(Channel::Collective, [this](int source, Bytes message) { receive(source, message); });
}

Collective::~Collective() { transport_.onMessage(Channel::Collective, nullptr); }

// ----------------------------------------------------------------------------------------------------------
// calls

std::vector<Bytes> Collective::allGather(uint64_t key, Bytes mine) {
  Writer writer;
  if (!mine.empty()) writer.write(int32_t(transport_.rank())).write(mine);
  const Bytes whole = allReduce(key, writer.take(), [](Bytes& into, const Bytes& other) {
    into.insert(into.end(), other.begin(), other.end());
  });
  std::vector<Bytes> parts(size_t(transport_.size()));
  for (Reader reader(whole, "gathered parts"); !reader.rest().empty();) {
    const auto rank = reader.read<int32_t>();
    if (rank < 0 || rank >= transport_.size()) reader.fail("a part is of rank " + std::to_string(rank));
    parts[size_t(rank)] = reader.readVector<std::byte>();
  }
  return parts;
}

Bytes Collective::allReduce(uint64_t key, Bytes mine, Fold fold) {
  const Call call = next(key);
  {
    const std::lock_guard lock(mutex_);
    Arrived& arrived = arrived_[call];
    arrived.mine = std::move(mine);
    arrived.fold = std::move(fold);
  }
  sendUpTree(call, int(key % uint64_t(transport_.size())));  // so that not all requests have the same root
  return waitForWhole(call);
}

std::vector<Bytes> Collective::allToAll(uint64_t key, std::vector<Bytes> perRank) {
  if (perRank.size() != size_t(transport_.size()))
    throw Error("Collective::allToAll: " + std::to_string(perRank.size()) +
                " entries, expected one for each of " + std::to_string(transport_.size()) + " ranks");
  const Call call = next(key);
  const int me = transport_.rank(), ranks = transport_.size();
  std::vector<Bytes> parts(perRank.size());
  parts[size_t(me)] = std::exchange(perRank[size_t(me)], {});
  // Each rank begins with the one after it, so that not all send to the same rank first.
  std::vector<int> destinations;
  for (int i = 1; i < ranks; ++i)
    if (const int r = (me + i) % ranks; !perRank[size_t(r)].empty()) {
      destinations.push_back(r);
      send(r, Kind::Direct, call, 0, std::exchange(perRank[size_t(r)], {}));
    }
  const size_t expected = countNotices(call, destinations);
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return arrived_[call].parts.size() == expected; });
  Arrived arrived = std::move(arrived_.extract(call).mapped());
  for (auto& [source, part] : arrived.parts) parts[size_t(source)] = std::move(part);
  return parts;
}

Bytes Collective::broadcast(uint64_t key, int root, Bytes bytes) {
  const Call call = next(key);
  if (transport_.rank() != root) return waitForWhole(call);
  sendDownTree(call, root, bytes);
  return bytes;
}

void Collective::barrier(uint64_t key) {
  allReduce(key, {}, [](Bytes&, const Bytes&) {});
}

void Collective::agree(uint64_t key, const std::optional<std::string>& error) {
  const auto all = allGather(key, error ? Writer().write(*error).take() : Bytes());
  std::string message;
  for (size_t r = 0; r < all.size(); ++r) {
    if (all[r].empty()) continue;
    Reader reader(all[r], "agreement");
    message += (message.empty() ? "rank " : "; rank ") + std::to_string(r) + ": " + reader.readString();
  }
  if (!message.empty()) throw Error(message);
}

void Collective::finish(uint64_t key) {
  std::lock_guard lock(mutex_);
  calls_.erase(key);
}

// ----------------------------------------------------------------------------------------------------------
// steps of calls

Collective::Call Collective::next(uint64_t key) {
  std::lock_guard lock(mutex_);
  return {key, calls_[key]++};
}

void Collective::send(int destination, Kind kind, Call call, int at, Bytes body) {
  Writer writer;
  writer.write(Header{kind, at, call.first, call.second}).write(body);
  transport_.send(destination, Channel::Collective, writer.take());
}

void Collective::sendDownTree(Call call, int root, const Bytes& body) {
  forEachTreeChild(transport_.rank(), root, transport_.size(),
                   [&](int child) { send(child, Kind::Whole, call, root, body); });
}

// Called when this rank has made its call and whenever a part comes. Once all are there, they go on as one.
void Collective::sendUpTree(Call call, int root) {
  const int me = transport_.rank(), size = transport_.size();
  Bytes sum;
  Fold fold;
  std::map<int, Bytes> parts;
  {
    const std::lock_guard lock(mutex_);
    Arrived& arrived = arrived_[call];
    if (!arrived.fold || int(arrived.parts.size()) < treeChildren(me, root, size)) return;
    sum = std::move(arrived.mine);
    fold = std::exchange(arrived.fold, {});
    parts.swap(arrived.parts);
  }
  for (const auto& [source, part] : parts) fold(sum, part);
  // The root sends the whole to itself, and receive() passes it on to its children.
  if (const int parent = treeParent(me, root, size); parent < 0)
    send(me, Kind::Whole, call, root, std::move(sum));
  else
    send(parent, Kind::Up, call, root, std::move(sum));
}

// Tells each rank how many ranks send it a direct part, in log2(P) steps for P ranks: in step i a rank hands
// all notices on, to the rank 2^i further, whose way to their rank is such that 2^i is a part of it (Bruck et
// al., "Efficient algorithms for all-to-all communications in multiport message-passing systems", 1997).
// Returns the number for this rank.
size_t Collective::countNotices(Call call, const std::vector<int>& destinations) {
  const int me = transport_.rank(), ranks = transport_.size();
  std::map<int32_t, uint32_t> notices;  // how many, by rank that they are for
  for (const int r : destinations) notices[r] = 1;
  for (int step = 0; (int64_t(1) << step) < ranks; ++step) {
    const int64_t reach = int64_t(1) << step;
    Writer onward;
    std::erase_if(notices, [&](const auto& notice) {
      const bool goes = ((int64_t(notice.first) - me + ranks) % ranks & reach) != 0;
      if (goes) onward.write(notice.first).write(notice.second);
      return goes;
    });
    send(int((me + reach) % ranks), Kind::Notice, call, step, onward.take());
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return arrived_[call].notices.count(step) > 0; });
    const Bytes came = std::move(arrived_[call].notices.at(step));
    lock.unlock();
    for (Reader reader(came, "notices"); !reader.rest().empty();) {
      const auto rank = reader.read<int32_t>();
      notices[rank] += reader.read<uint32_t>();
    }
  }
  return notices[me];
}

Bytes Collective::waitForWhole(Call call) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] {
    const auto found = arrived_.find(call);
    return found != arrived_.end() && found->second.whole;
  });
  return std::move(*arrived_.extract(call).mapped().whole);
}

// ----------------------------------------------------------------------------------------------------------
// messages

void Collective::receive(int source, const Bytes& message) {
  Reader reader(message, "collective");
  const auto header = reader.read<Header>();
  const Call call{header.key, header.step};
  auto body = reader.readVector<std::byte>();
  reader.expectEnd();
  if (header.kind > Kind::Notice || header.at < 0 || header.at >= transport_.size())
    reader.fail("kind " + std::to_string(int(header.kind)) + ", root or step " + std::to_string(header.at));
  if (header.kind != Kind::Whole) return receivePart(source, header.kind, call, header.at, std::move(body));
  sendDownTree(call, header.at, body);
  {
    std::lock_guard lock(mutex_);
    arrived_[call].whole = std::move(body);
  }
  changed_.notify_all();
}

void Collective::receivePart(int source, Kind kind, Call call, int at, Bytes body) {
  if (kind == Kind::Up && treeParent(source, at, transport_.size()) != transport_.rank())
    throw Error("collective: rank " + std::to_string(source) +
                " is no child of this rank in the tree of rank " + std::to_string(at));
  {
    std::lock_guard lock(mutex_);
    Arrived& arrived = arrived_[call];
    auto& parts = kind == Kind::Notice ? arrived.notices : arrived.parts;
    if (!parts.emplace(kind == Kind::Notice ? at : source, std::move(body)).second)
      throw Error("collective: rank " + std::to_string(source) + " made call " + std::to_string(call.second) +
                  " of key " + std::to_string(call.first) + " twice");
  }
  if (kind == Kind::Up)
    sendUpTree(call, at);
  else
    changed_.notify_all();
}

}  // namespace gxy
