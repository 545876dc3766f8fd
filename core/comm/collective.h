// SPDX-License-Identifier: Apache-2.0
// Exchanges in which all ranks take part, for requests (import, scene build) that run side by side.
#pragma once
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/comm/transport.h"

namespace gxy {

/// Collectives over a Transport. Each call blocks its thread until its part is done. Call them from the main
/// thread or from a postWaiting() or postLong() task, never from a handler or a post() task, and not in a
/// seeded in-process world.
///
/// A key names a request on all ranks. Within a key all ranks make the same calls in the same order. Calls of
/// different keys neither wait for each other nor mix, whatever their order on each rank. A rank that fails
/// before a call must still make it, or others wait for ever: agree() is for that.
///
/// No rank sends or receives more than a number of messages that grows with the logarithm of the number of
/// ranks, but for the messages of allToAll() that have bytes in them.
class Collective {
 public:
  /// Makes one of two ranks' bytes. It must not throw, and what it makes of all ranks' must not depend on the
  /// order in which it gets them.
  using Fold = std::function<void(Bytes& into, const Bytes& other)>;

  explicit Collective(Transport& transport);
  ~Collective();

  Collective(const Collective&) = delete;
  Collective& operator=(const Collective&) = delete;

  /// Returns the bytes that each rank gave, by rank. They go up a binary tree, and all of them come down it.
  /// Ranks that give none cost no bytes.
  std::vector<Bytes> allGather(uint64_t key, Bytes mine);

  /// Returns, on all ranks, what `fold` makes of the bytes that the ranks give. Each rank folds its own and
  /// those of its children in a binary tree. `fold` may be called on another thread than the caller's.
  Bytes allReduce(uint64_t key, Bytes mine, Fold fold);

  /// Sends `perRank[r]` to rank r, unless it is empty. Returns the bytes that each rank sent to this one, by
  /// rank. Throws Error unless `perRank` has one entry per rank.
  std::vector<Bytes> allToAll(uint64_t key, std::vector<Bytes> perRank);

  /// Returns the bytes that rank `root` gave, on all ranks, by way of a binary tree. The bytes of other ranks
  /// are ignored. The root does not wait.
  Bytes broadcast(uint64_t key, int root, Bytes bytes);

  /// Returns when all ranks have called it.
  void barrier(uint64_t key);

  /// Turns an error on any rank into an error on every rank. Each rank passes its own error or nothing. If
  /// there was any, all ranks throw Error "rank 3: <its message>; rank 5: ...".
  void agree(uint64_t key, const std::optional<std::string>& error);

  /// Forgets the key: this rank makes no more calls with it. The key may be used for another request only
  /// after all ranks have finished their calls with it, as after a barrier.
  void finish(uint64_t key);

 private:
  enum class Kind : uint8_t;
  struct Header;
  using Call = std::pair<uint64_t, uint64_t>;  ///< key, and the number of earlier calls with the key

  struct Arrived {
    std::map<int, Bytes> parts;    ///< by source rank: of children in the tree, or of allToAll()
    std::map<int, Bytes> notices;  ///< by step of countNotices()
    std::optional<Bytes> whole;    ///< bytes that came down the tree
    Bytes mine;                    ///< what this rank gave to allReduce()
    Fold fold;                     ///< set between this rank's call and the moment when the parts are folded
  };

  Call next(uint64_t key);
  void send(int destination, Kind kind, Call call, int at, Bytes body);
  void sendDownTree(Call call, int root, const Bytes& body);
  void sendUpTree(Call call, int root);
  size_t countNotices(Call call, const std::vector<int>& destinations);
  void receive(int source, const Bytes& message);
  void receivePart(int source, Kind kind, Call call, int at, Bytes body);
  Bytes waitForWhole(Call call);

  Transport& transport_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<Call, Arrived> arrived_;
  std::map<uint64_t, uint64_t> calls_;  ///< number of calls made so far, by key
};

}  // namespace gxy
