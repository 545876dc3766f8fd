// SPDX-License-Identifier: Apache-2.0
// ReadyQueue: which of the tasks and tiles that wait on a rank comes next.
#pragma once
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>

#include "core/render/credits.h"
#include "core/render/priority.h"

namespace gxy {

/// The tiles of a frame that are still to be spawned. A ReadyQueue calls it with its lock held, so it must
/// not call the ReadyQueue.
class TileSource {
 public:
  virtual ~TileSource() = default;
  virtual bool empty() const = 0;
  virtual int64_t cost() const = 0;  ///< credits of the next tile
  /// Removes the next tile and returns a task that spawns it. The task and the tile's rays give its credits
  /// back in the end.
  virtual std::function<void()> take() = 0;
};

/// Schedules the tasks of frames, and spawns tiles only when it is their turn, so that few rays wait in
/// memory.
///
/// Tenants share the processors by the time that their tasks take, and so do the streams of a tenant: whoever
/// has used least time is next. A tenant or stream that is new, or comes back after a pause, starts with the
/// least time that any active one has used (if it has an interactive frame, that any other with such a frame
/// has used). It thus neither waits nor catches up on time that it did not want. A tenant or stream with an
/// interactive frame goes before others until it is ahead of them by Options::ahead (Duda and Cheriton,
/// "Borrowed-virtual-time scheduling", 1999): it does not wait, and in the long run each has its share.
///
/// Within a stream interactive frames go before others, and older frames before newer ones. Within a frame
/// the rest of tasks that gave way comes first, then tiles as long as there are credits, then other tasks. If
/// a tile finds too few credits, nobody whose turn is later and who has as many credits out, or more, spawns
/// meanwhile. Thread safe.
class ReadyQueue {
 public:
  using Task = std::function<void()>;
  using Time = std::chrono::nanoseconds;
  struct Options {
    /// Credits of this rank (credits.h).
    int64_t credits = 1;
    /// Processor time by which interactive frames may get ahead of others.
    Time ahead{0};
  };

  ReadyQueue() : ReadyQueue(Options{}) {}
  explicit ReadyQueue(const Options& options) : options_(options), credits_(options.credits) {}

  /// Adds a task of a frame. `first` puts it before the other tasks and the tiles of its frame; this is for
  /// the rest of a task that gave way. All that waits of a frame counts as interactive if what was added last
  /// is.
  void push(const Priority& priority, uint64_t frame, Task task, bool first = false);
  /// Adds the tiles of a frame, if there are any.
  void addTiles(const Priority& priority, uint64_t frame, std::shared_ptr<TileSource> tiles);
  /// Removes the tiles of a frame that are not spawned yet. Returns whether there were any.
  bool dropTiles(const Priority& priority, uint64_t frame);

  struct Next {
    Task task;
    Priority priority;
    Time expected{0};  ///< time that is charged already
    explicit operator bool() const { return bool(task); }
  };
  /// Takes the next task and charges its tenant and stream the time of the stream's last task. Returns an
  /// empty one if nothing may be done now.
  Next pop();
  /// Says that what pop() returned has been done, and how much processor time it took. Call it once for each.
  void ran(const Next& done, Time took);
  /// Whether pop() would return a task.
  bool ready();

  void giveBack(const Priority& priority, int64_t credits);
  /// A copy of the present state.
  Credits credits() const;
  /// The number of tasks that wait, without tiles.
  size_t size() const;

 private:
  /// The turn of a tenant among tenants, or of a stream among those of its tenant.
  struct Turn {
    Time used{0};          ///< processor time charged, from the start value that the class comment describes
    Time last{0};          ///< processor time of its last task
    uint64_t served = 0;   ///< the queue's turn_ when it was last served
    int running = 0;       ///< number of its tasks that run
    bool wants = false;    ///< something of it may be done now
    bool watched = false;  ///< a frame of it that waits is interactive
    bool takesPart = false;  ///< it competes: it wants something or something of it runs
  };
  struct Entry {
    bool interactive = false;
    std::deque<Task> rests, others;  ///< tasks pushed with and without `first`
    std::shared_ptr<TileSource> tiles;
    bool empty() const { return rests.empty() && others.empty() && !tiles; }
  };
  struct Stream {
    Turn turn;
    std::map<uint64_t, Entry> frames;  ///< key: frame; only frames with something that waits
  };
  struct Tenant {
    Turn turn;
    /// The least time used by a stream that takes part. It never decreases.
    Time least{0};
    std::map<uint64_t, Stream> streams;
  };
  enum class Kind { Rest, SpawnTile, Other };
  struct Pick {
    Stream* stream = nullptr;
    uint64_t frame = 0;
    Kind kind = Kind::Rest;
    Priority priority;
  };
  struct Blocked;

  Entry& entry(const Priority& priority, uint64_t frame);
  bool mayDo(const Priority& priority, const Stream& stream) const;
  Pick pick(const Priority& priority, Stream& stream, Blocked& blocked) const;
  Pick choose();
  void refresh();
  template <class Children>
  static void letTakePart(Children& children, Time& least);
  Task take(const Pick& pick);
  template <class Children>
  auto inTurn(Children& children) const;

  const Options options_;
  mutable std::mutex mutex_;
  Credits credits_;
  std::map<uint32_t, Tenant> tenants_;
  Time least_{0};  ///< the same for tenants
  size_t tasks_ = 0;
  uint64_t turn_ = 0;
};

}  // namespace gxy
