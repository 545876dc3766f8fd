// SPDX-License-Identifier: Apache-2.0
// What a Renderer keeps of a frame; for its own sources only.
#pragma once
#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "gxy/render/check_rays.h"
#include "gxy/render/renderer.h"
#include "gxy/render/tiles.h"

namespace gxy {

struct Renderer::Scene {
  std::shared_ptr<const CompiledScene> compiled;
  std::shared_ptr<const DeviceScene> device;
};

struct Renderer::Frame {
  FrameId id = 0;
  FrameRequest request;
  Scene scene;
  std::shared_ptr<const DeviceFrame> device;
  int owner = 0;
  int64_t perPrimary = 1;                    ///< credits of a primary ray
  RayLimits limits;                          ///< of rays that may come
  std::unique_ptr<Framebuffer> framebuffer;  ///< on the owner
  const Account* shared = nullptr;           ///< of frames that name no account
  std::optional<Account> own;
  LedgerEntry framebufferMemory, tileMemory;
  std::vector<Tile> tiles;            ///< still to be spawned, last first
  std::atomic<size_t> tilesLeft = 0;  ///< not yet spawned completely
  uint64_t turn = 0;                  ///< when a tile of it was spawned last
  std::atomic<bool> cancelled = false;
  const Trace::Clock::time_point begin = Trace::Clock::now();

  const Account& account() const { return own ? *own : *shared; }
  int64_t nextCost() const;  ///< credits of the tile that is spawned next
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

}  // namespace gxy
