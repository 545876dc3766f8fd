// SPDX-License-Identifier: Apache-2.0
// What a Renderer keeps of a frame; for its own sources only.
#pragma once
#include <atomic>
#include <condition_variable>
#include <memory>
#include <optional>
#include <vector>

#include "core/rays/packet_size.h"
#include "core/render/check_rays.h"
#include "core/render/renderer.h"
#include "core/render/tiles.h"

namespace gxy {

struct Renderer::Scene {
  std::shared_ptr<const CompiledScene> compiled;
  std::shared_ptr<const DeviceScene> device;
};

struct Renderer::Frame {
  explicit Frame(const Options& options)
      : packet(options.packetRays), mostUrgentWork(uint64_t(options.urgentWork.count())) {}

  FrameId id = 0;
  FrameRequest request;
  Scene scene;
  std::shared_ptr<const DeviceFrame> device;  ///< null where this rank could not begin the frame
  int owner = 0;
  int samples = 1;                           ///< of a pixel
  int64_t perPrimary = 1;                    ///< credits of a primary ray
  RayLimits limits;                          ///< of rays that may come
  std::unique_ptr<Framebuffer> framebuffer;  ///< on the owner, unless it could not begin
  const Account* shared = nullptr;           ///< of frames that name no account
  std::optional<Account> own;
  LedgerEntry tileMemory;
  std::vector<Tile> tiles;  ///< of the first sample
  size_t next = 0;  ///< to be spawned: all tiles of a sample, then those of the next; ReadyQueue's lock
  std::atomic<size_t> tilesLeft = 0;  ///< not yet spawned completely
  PacketSize packet;
  const uint64_t mostUrgentWork;
  std::atomic<uint64_t> work = 0;       ///< nanoseconds of this rank's processors, or of its device
  std::atomic<bool> cancelled = false;  ///< by cancel()
  std::atomic<bool> failed = false;     ///< rank 0 has been told, by this rank
  const Trace::Clock::time_point begin = Trace::Clock::now();

  /// What waits of it is not done any more.
  void cancel() {
    cancelled = true;
    if (device) device->cancel();
  }
  const Account& account() const { return own ? *own : *shared; }
  /// A frame that takes long is no longer before all others.
  Share share() const {
    return {request.share.tenant, request.share.interactive && work <= mostUrgentWork, request.share.stream};
  }
  size_t allTiles() const { return tiles.size() * size_t(samples); }
  Tile nextTile() const {
    Tile tile = tiles[next % tiles.size()];
    tile.sample += int(next / tiles.size());
    return tile;
  }
  /// Credits of nextTile().
  int64_t nextCost() const {
    const Tile tile = nextTile();
    return int64_t(tile.x1 - tile.x0) * (tile.y1 - tile.y0) * perPrimary;
  }
};

/// Those of a frame, for the ReadyQueue.
class Renderer::Tiles : public TileSource {
 public:
  Tiles(Renderer& renderer, FramePtr frame) : renderer_(renderer), frame_(std::move(frame)) {}
  bool empty() const override { return frame_->next == frame_->allTiles(); }
  int64_t cost() const override { return frame_->nextCost(); }
  std::function<void()> take() override;

 private:
  Renderer& renderer_;
  const FramePtr frame_;
};

struct Renderer::Parked {
  Channel channel;
  Bytes message;
  std::shared_ptr<Completion::Active> active;
  LedgerEntry memory;
};

/// Rays on this rank.
struct Renderer::Held {
  LeavingRays list;
  LedgerEntry memory;
};

/// Lets tasks in until it is closed, and knows how many are inside: a task may still run when the frame that it worked for
/// has been reported, and a device may still trace.
class Renderer::Tasks : public std::enable_shared_from_this<Tasks> {
 public:
  void run(std::function<void()>& task) {
    {
      std::lock_guard lock(mutex_);
      if (closed_) return;
      inside_++;
    }
    const std::shared_ptr<void> leave(nullptr, [&](void*) {
      task = nullptr;  // what it holds goes before the Renderer may
      left();
    });
    task();
  }
  /// For somebody inside: is inside, too, while what it returns lives.
  std::shared_ptr<void> stay() {
    std::lock_guard lock(mutex_);
    inside_++;
    return {this, [self = shared_from_this()](void*) { self->left(); }};
  }
  void close() {
    std::unique_lock lock(mutex_);
    closed_ = true;
    empty_.wait(lock, [this] { return inside_ == 0; });
  }

 private:
  void left() {
    std::lock_guard lock(mutex_);
    if (--inside_ == 0) empty_.notify_all();
  }
  std::mutex mutex_;
  std::condition_variable empty_;
  size_t inside_ = 0;
  bool closed_ = false;
};

/// A call to a device. Whoever comes second, the answer or the caller's return, takes what is to be done then: what the
/// device keeps of the call holds nothing any more.
struct Renderer::Asked {
  struct Next {
    std::shared_ptr<void> inside, expected;  ///< this Renderer, and the Transport, wait for the answer
    FramePtr frame;
    int origin;
    Then then;
    Completion::Active active;
    TraceResult answer;
  };
  std::mutex mutex;
  bool answered = false, left = false;
  std::shared_ptr<Next> next;
};

}  // namespace gxy
