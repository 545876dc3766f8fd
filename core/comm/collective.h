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

/// Collectives over a Transport. Each call blocks its thread until its part is done: call from the main
/// thread or a postWaiting() or postLong() task, never from a handler or a post() task, nor in a seeded in-process world.
///
/// A key names a request in all ranks. Within a key all ranks make the same calls in the same order; calls of
/// different keys neither wait for each other nor mix, whatever their order on each rank. A rank that fails
/// before a call still has to make it, or others wait for ever: agree() is for that.
class Collective {
 public:
  explicit Collective(Transport& transport);
  ~Collective();

  Collective(const Collective&) = delete;
  Collective& operator=(const Collective&) = delete;

  /// What each rank gave, by rank. One rank collects, and passes the whole on over a binary tree: 2 P
  /// messages.
  std::vector<Bytes> allGather(uint64_t key, Bytes mine);

  /// `perRank[r]` goes to rank r; returns what each rank had for this one, by rank. Throws Error unless there
  /// is one entry per rank.
  std::vector<Bytes> allToAll(uint64_t key, std::vector<Bytes> perRank);

  /// What `root` gave, on all ranks, over a binary tree; the others' bytes are ignored. The root does not
  /// wait.
  Bytes broadcast(uint64_t key, int root, Bytes bytes);

  /// Returns when all ranks have called it.
  void barrier(uint64_t key);

  /// Turns an error of any rank into one on every rank: each passes its own error or nothing, and if there
  /// was one, Error "rank 3: <its message>; rank 5: ..." is thrown on all.
  void agree(uint64_t key, const std::optional<std::string>& error);

  /// This rank makes no more calls with the key, and forgets it (after which it may be used for another
  /// request only if all ranks have finished it, as after a barrier).
  void finish(uint64_t key);

 private:
  enum class Kind : uint8_t;
  struct Header;
  using Call = std::pair<uint64_t, uint64_t>;  ///< key, and how many calls of the key came before

  struct Arrived {
    std::vector<std::optional<Bytes>> parts;  ///< by source
    int count = 0;                            ///< of the parts that are there
    std::optional<Bytes> whole;               ///< what came down a tree
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
  std::map<uint64_t, uint64_t> calls_;  ///< made so far, by key
};

}  // namespace gxy
