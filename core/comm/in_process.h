// SPDX-License-Identifier: Apache-2.0
// All ranks in one process, for tests: a seeded scheduler that delays and reorders messages at will, or real
// threads.
#pragma once
#include <cstdint>
#include <memory>

#include "core/comm/mailbox.h"
#include "core/comm/transport.h"

namespace gxy {

/// N connected Transports in one process.
///
/// *Seeded* (the default): nothing happens but in step() and run(), on the caller's thread. Each step picks,
/// from the seed alone, any message that is under way or any task that is posted. Seeds differ in what they
/// starve: some hold single messages, all messages of a channel, all tasks, or all that concerns some ranks
/// for very long, though never for ever. The same seed and the same program give the same schedule
/// everywhere. Tasks must not wait.
///
/// *Threaded*: each rank has a progress thread that takes its waiting messages in random order; tasks run on
/// threads shared by all ranks. For code that waits (collective.h), and for the thread sanitizer (no oneTBB
/// inside, which the sanitizer cannot follow).
class InProcessWorld {
 public:
  struct Options {
    bool threaded = false;
    int workers = 2;  ///< threads for tasks of all ranks, when threaded
    /// When empty: step() and run() throw what a handler or task throws (seeded), or it is logged (threaded).
    ErrorReport onError;
  };

  InProcessWorld(int ranks, uint64_t seed, Options options);
  InProcessWorld(int ranks, uint64_t seed) : InProcessWorld(ranks, seed, Options{}) {}

  /// When threaded, first delivers all messages and runs all tasks. Handlers must be valid until then, or
  /// removed.
  ~InProcessWorld();

  /// The rank's connection; lives as long as the world.
  Transport& rank(int rank);
  int size() const;

  /// One event, seeded worlds only; false when there is none.
  bool step();

  /// Until nothing is under way, posted, running or expected (Transport::expectPost): every event (seeded), or waits
  /// (threaded).
  void run();

  class World;

 private:
  std::unique_ptr<World> world_;
};

}  // namespace gxy
