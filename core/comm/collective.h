// SPDX-License-Identifier: Apache-2.0
// Exchanges in which all ranks take part, for requests (import, scene build) that run side by side.
#pragma once
#include <condition_variable>
#include <cstdint>
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
class Collective {
 public:
  explicit Collective(Transport& transport);
  ~Collective();

  Collective(const Collective&) = delete;
  Collective& operator=(const Collective&) = delete;

  /// Returns the bytes that each rank gave, by rank. One rank collects them and sends the whole down a binary
  /// tree: 2 P messages for P ranks.
  std::vector<Bytes> allGather(uint64_t key, Bytes mine);

  /// Sends `perRank[r]` to rank r. Returns the bytes that each rank sent to this one, by rank. Throws Error
  /// unless `perRank` has one entry per rank.
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
    std::vector<std::optional<Bytes>> parts;  ///< by source rank
    int count = 0;                            ///< number of parts that have arrived
    std::optional<Bytes> whole;               ///< bytes that came down the tree
  };

  Call next(uint64_t key);
  void send(int destination, Kind kind, Call call, int root, Bytes body);
  void sendDownTree(Call call, int root, const Bytes& body);
  void receive(int source, const Bytes& message);
  void receivePart(int source, Kind kind, Call call, Bytes body);
  Bytes waitForWhole(Call call);

  Transport& transport_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<Call, Arrived> arrived_;
  std::map<uint64_t, uint64_t> calls_;  ///< number of calls made so far, by key
};

}  // namespace gxy
