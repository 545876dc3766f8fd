// SPDX-License-Identifier: Apache-2.0
// Which of the things that wait on a rank is done next.
#pragma once
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>

#include "core/render/credits.h"
#include "core/render/share.h"

namespace gxy {

/// Tiles of a frame that are to be spawned. Called by a ReadyQueue, which it must not call.
class TileSource {
 public:
  virtual ~TileSource() = default;
  virtual bool empty() const = 0;
  virtual int64_t cost() const = 0;  ///< of the next tile, in credits
  /// The next tile as a task, which gives back those credits in the end.
  virtual std::function<void()> take() = 0;
};

/// Tasks of frames, and tiles that are spawned only when their turn has come, so that few rays wait for theirs.
///
/// Tenants share the processors by the time that they take, and so do the streams of a tenant: whoever has been given least is
/// next. Those that come (again) begin where the one with least is, of those that are watched if they are, so that they neither
/// wait nor catch up on what they did not want. Where somebody looks at a frame it goes before others, until its tenant or stream is ahead of them by Options::ahead
/// (Duda and Cheriton, "Borrowed-virtual-time scheduling", 1999): it does not wait, and in the long run each has its share.
/// Within a stream the oldest frame is first, watched ones before others; of a frame the rest of what has begun, then tiles as
/// long as there are credits, then other tasks. Where a tile finds no room in the credits, nobody who has as many out or more,
/// and whose turn is later, spawns meanwhile. Thread safe.
class ReadyQueue {
 public:
  using Task = std::function<void()>;
  using Time = std::chrono::nanoseconds;
  struct Options {
    int64_t credits = 1;
    Time ahead{0};
  };

  ReadyQueue() : ReadyQueue(Options{}) {}
  explicit ReadyQueue(const Options& options) : options_(options), credits_(options.credits) {}

  /// `first`: before the other tasks and the tiles of its frame, as the rest of one that gave way. What waits of the frame is
  /// as interactive as what came last.
  void push(const Share& share, uint64_t frame, Task task, bool first = false);
  void addTiles(const Share& share, uint64_t frame, std::shared_ptr<TileSource> tiles);
  /// Whether there were any left; they are not spawned any more.
  bool dropTiles(const Share& share, uint64_t frame);

  struct Next {
    Task task;
    Share share;
    Time expected{0};  ///< was charged already
    explicit operator bool() const { return bool(task); }
  };
  /// Takes what is next; empty if there is nothing that may be done now.
  Next pop();
  /// What was taken has been done, and took so long.
  void ran(const Next& done, Time took);
  /// Whether pop() would find something.
  bool ready();

  void giveBack(const Share& share, int64_t credits);
  /// A copy, to be looked at.
  Credits credits() const;
  /// Tasks that wait.
  size_t size() const;

 private:
  /// Of a tenant among tenants, or a stream among those of its tenant.
  struct Turn {
    Time used{0};         ///< of the processors, counted as said above
    Time last{0};         ///< that its last task took
    uint64_t served = 0;  ///< when it was
    int running = 0;      ///< its tasks that do
    bool wants = false;   ///< something may be done now
    bool watched = false;
    bool takesPart = false;
  };
  struct Entry {
    bool interactive = false;
    std::deque<Task> rests, others;
    std::shared_ptr<TileSource> tiles;
    bool empty() const { return rests.empty() && others.empty() && !tiles; }
  };
  struct Stream {
    Turn turn;
    std::map<uint64_t, Entry> frames;  ///< where something waits
  };
  struct Tenant {
    Turn turn;
    Time least{0};  ///< that one of its streams which take part has used, and never less than before
    std::map<uint64_t, Stream> streams;
  };
  enum class Kind { Rest, Tile, Other };
  struct Pick {
    Stream* stream = nullptr;
    uint64_t frame = 0;
    Kind kind = Kind::Rest;
    Share share;
  };
  struct Blocked;

  Entry& entry(const Share& share, uint64_t frame);
  bool mayDo(const Share& share, const Stream& stream) const;
  Pick pick(const Share& share, Stream& stream, Blocked& blocked) const;
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
  Time least_{0};  ///< as Tenant::least
  size_t tasks_ = 0;
  uint64_t turn_ = 0;
};

}  // namespace gxy
