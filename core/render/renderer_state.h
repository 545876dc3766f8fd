// SPDX-License-Identifier: Apache-2.0
// The state that a Renderer keeps of a frame. Only for the Renderer's own sources.
#pragma once
#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/render/check_rays.h"
#include "core/render/picture_parts.h"
#include "core/render/renderer.h"
#include "core/render/tiles.h"

namespace gxy {

struct Renderer::Scene {
  std::shared_ptr<const CompiledScene> compiled;
  std::shared_ptr<const DeviceScene> device;
};

/// What a message on Channel::Contributions begins with, before the number of the frame.
enum class PixelMessage : uint8_t {
  Contributions,  ///< to the rank of a part, while the frame is under way
  Parts,          ///< finished ones, to the rank of the part above them in the tree
};

/// A frame as a flight: its items are rays, its chunks are tiles, and its act is to trace and to shade.
struct Renderer::Frame final : Flight<TraceResult>, std::enable_shared_from_this<Frame> {
  Frame(Renderer& renderer, FrameId id, FrameRequest request)
      : Flight(id, renderer.options_.packetRays),
        renderer(renderer),
        request(std::move(request)),
        parts(id, this->request.camera.dimensions, renderer.transport_.size(),
              renderer.options_.ranksPerPart),
        part(parts.ofRank(renderer.transport_.rank())),
        mostUrgentWork(uint64_t(renderer.options_.urgentWork.count())) {}

  Renderer& renderer;
  FrameRequest request;
  /// The operation of the frame's picture as rank 0 has written it; empty where the request holds it already.
  Bytes operation;
  Scene scene;
  std::shared_ptr<const DeviceFrame> device;  ///< null if this rank could not begin the frame
  const PictureParts parts;                   ///< of its picture
  const std::optional<int> part;              ///< the one of this rank
  int samples = 1;                            ///< rays per pixel
  int64_t perPrimary = 1;                     ///< credits that a primary ray takes
  RayLimits limits;                           ///< what rays that arrive are checked against
  std::unique_ptr<Framebuffer> framebuffer;   ///< of this rank's part; null if it could not begin the frame
  /// Messages with finished parts, by the rank that they came from, and their memory: this rank's own part, and
  /// the parts below it in the tree. Guarded by Renderer::mutex_ until all have come.
  std::map<int, Bytes> finished;
  LedgerEntry finishedMemory;
  std::optional<Account> own;  ///< of a frame that names an account
  LedgerEntry tileMemory;
  std::vector<SpawnTile> tiles;  ///< tiles of the first sample
  /// Index of the tile that is spawned next: all tiles of a sample, then those of the next sample. Guarded by
  /// the ReadyQueue's lock.
  size_t next = 0;
  const uint64_t mostUrgentWork;
  std::atomic<uint64_t> work = 0;  ///< nanoseconds of this rank's processors or device
  const Trace::Clock::time_point begun = Trace::Clock::now();

  bool ownsPicture() const { return part == 0; }
  const Account& account() const { return own ? *own : renderer.account_; }
  SpawnTile nextTile() const {
    SpawnTile tile = tiles[next % tiles.size()];
    tile.sample += int(next / tiles.size());
    return tile;
  }

  // The flight:
  void prepare() override { renderer.prepare(*this); }
  /// The request's share, but no longer interactive when the frame has taken more than Options::urgentWork on
  /// this rank.
  Priority priority() const override {
    return {request.priority.tenant, request.priority.interactive && work <= mostUrgentWork,
            request.priority.stream};
  }
  size_t chunks() const override { return tiles.size() * size_t(samples) - next; }
  int64_t cost() const override;
  int64_t creditsOf(uint32_t kind) const override { return kind == 1 ? perPrimary : 1; }
  LedgerEntry hold(int64_t bytes) const override { return account().rays.another(bytes); }
  void onCancel() override {
    if (device) device->cancel();
  }
  void end(bool hasPicture) override { renderer.finish(shared_from_this(), hasPicture); }
  int owner(int partition) const override { return scene.compiled->partitioning->owner(partition); }
  std::function<void(Done)> takeChunk() override;
  void advance(LeavingRays packet, Done done) override;
  void deposit(TraceResult& result) override { renderer.takeResult(*this, result); }
  LeavingRays read(int partition, uint32_t kind, int count, std::span<const std::byte> bytes) const override;
};

}  // namespace gxy
