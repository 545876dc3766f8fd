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
/// *Seeded* (the default): everything happens in step() and run(), on the caller's thread. Each step picks
/// one of the messages under way and tasks posted, and only the seed decides which. Seeds differ in what
/// they delay: some delay single messages, all messages of a channel, all tasks, or everything of some
/// ranks for very long, but never for ever. The same seed and the same program give the same schedule
/// everywhere. Tasks must not wait.
///
/// *Threaded*: each rank has a progress thread, which takes its waiting messages in random order. Tasks run
/// on threads shared by all ranks. Use it for code that waits (collective.h), and with the thread sanitizer:
/// it uses no oneTBB, which the sanitizer cannot follow.
class InProcessWorld {
 public:
  struct Options {
    bool threaded = false;
    int workers = 2;  ///< threads for tasks of all ranks, when threaded
    /// Gets the exceptions of handlers and tasks. When empty, step() and run() throw them (seeded), or they
    /// are logged (threaded).
    ErrorReport onError;
  };

  /// Throws Error for fewer than one rank.
  InProcessWorld(int ranks, uint64_t seed, Options options);
  InProcessWorld(int ranks, uint64_t seed) : InProcessWorld(ranks, seed, Options{}) {}

  /// When threaded, first delivers all messages and runs all tasks: handlers that are still set must be
  /// valid until then.
  ~InProcessWorld();

  /// The connection of rank `rank`. It lives as long as the world.
  Transport& rank(int rank);
  int size() const;

  /// Delivers one message or runs one task; returns false when there is none. Throws Error in a threaded world.
  bool step();

  /// Returns when no message is under way, and no task is posted, running or expected
  /// (Transport::expectPost). A seeded world runs them here; a threaded world waits for them.
  void run();

  class World;

 private:
  std::unique_ptr<World> world_;
};

}  // namespace gxy
