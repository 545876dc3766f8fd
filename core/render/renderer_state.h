// SPDX-License-Identifier: Apache-2.0
// The state that a Renderer keeps of a frame. Only for the Renderer's own sources.
#pragma once
#include <atomic>
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
  std::shared_ptr<const DeviceFrame> device;  ///< null if this rank could not begin the frame
  int owner = 0;
  int samples = 1;                           ///< rays per pixel
  int64_t perPrimary = 1;                    ///< credits that a primary ray takes
  RayLimits limits;                          ///< what rays that arrive are checked against
  std::unique_ptr<Framebuffer> framebuffer;  ///< on the owner; null if it could not begin the frame
  const Account* shared = nullptr;           ///< the Renderer's, for frames that name no account
  std::optional<Account> own;                ///< of a frame that names an account
  LedgerEntry tileMemory;
  std::vector<SpawnTile> tiles;  ///< tiles of the first sample
  /// Index of the tile that is spawned next: all tiles of a sample, then those of the next sample. Guarded by
  /// the ReadyQueue's lock.
  size_t next = 0;
  std::atomic<size_t> tilesLeft = 0;  ///< tiles that are not yet spawned completely
  PacketSize packet;
  const uint64_t mostUrgentWork;
  std::atomic<uint64_t> work = 0;       ///< nanoseconds of this rank's processors or device
  std::atomic<bool> cancelled = false;  ///< set by cancel()
  std::atomic<bool> failed = false;     ///< this rank has told rank 0 of an error
  const Trace::Clock::time_point begin = Trace::Clock::now();

  /// Makes the frame's waiting rays end untraced, also those that the device queues.
  void cancel() {
    cancelled = true;
    if (device) device->cancel();
  }
  const Account& account() const { return own ? *own : *shared; }
  /// The request's share, but no longer interactive when the frame has taken more than Options::urgentWork on
  /// this rank.
  Priority priority() const {
    return {request.priority.tenant, request.priority.interactive && work <= mostUrgentWork,
            request.priority.stream};
  }
  size_t allTiles() const { return tiles.size() * size_t(samples); }
  SpawnTile nextTile() const {
    SpawnTile tile = tiles[next % tiles.size()];
    tile.sample += int(next / tiles.size());
    return tile;
  }
  /// Credits that the rays of nextTile() take.
  int64_t nextCost() const {
    const SpawnTile tile = nextTile();
    return int64_t(tile.x1 - tile.x0) * (tile.y1 - tile.y0) * perPrimary;
  }
};

/// The tiles of a frame that a ReadyQueue spawns.
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

/// A message that arrived before the start of its frame.
struct Renderer::EarlyMessage {
  Channel channel;
  Bytes message;
  std::shared_ptr<Completion::Active> active;
  LedgerEntry memory;
};

/// A list of rays on this rank, and its entry in the ledger.
struct Renderer::QueuedRays {
  LeavingRays list;
  LedgerEntry memory;
};

/// A call to a device. The answer may come before or after the call returns; whichever is second takes `next`
/// and goes on. What the device may still keep of the call then holds nothing.
struct Renderer::PendingDeviceCall {
  struct Next {
    std::shared_ptr<void> inside, expected;  ///< make this Renderer and the Transport wait for the answer
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
