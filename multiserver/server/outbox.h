// SPDX-License-Identifier: Apache-2.0
// What waits to be sent to one client: bounded, whatever the client reads.
#pragma once
#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "core/space/ledger.h"
#include "multiserver/protocol/frame.h"
#include "multiserver/protocol/pixel_record.h"

namespace gxy {

/// Frames by kind, each with its own answer to a slow reader: for text the server stops reading the client's requests
/// (`congested`), events are left out, files wait (`file` blocks), tiles of a pass are dropped once a newer pass of their
/// window comes. Sent in this order: control, replies and events, tiles (windows in turn), files.
///
/// Thread safe. After close() everything given is dropped and nobody waits.
class Outbox {
 public:
  struct Limits {
    size_t text = 4 << 20, files = 64 << 20, pixels = 256 << 20;  ///< bytes that wait
  };

  /// `wake` is called, from any thread, when there is something to send; it must be short and take no lock that calls
  /// into the Outbox are made with. What waits is in `memory`.
  Outbox(Limits limits, std::function<void()> wake, LedgerEntry memory);

  /// What waits is in `memory` instead, from now on.
  void chargeTo(LedgerEntry memory);

  void control(std::string_view text);
  /// A last control frame: sent after replies and events that wait; nothing follows it.
  void farewell(std::string_view text);
  void reply(uint32_t id, std::string_view text);
  /// False: left out, and counted in the next `lost` event.
  bool event(const nlohmann::json& event);

  /// A record of pixel_record.h. A tile of another frame, or of another pass of the same level, than the last of its window
  /// drops the window's older tiles. False: the tile was dropped, since too much waits.
  /// `sent`, of the end of a pass, is called (on the thread of next()) when this record or a later one of its kind has been
  /// taken; not if it was dropped. A window has one at a time.
  bool pixels(Bytes record, std::function<void()> sent = {});
  /// Drops the tiles of a window.
  void dropTiles(uint32_t window);

  /// Waits while too much waits. False: the client has gone, or `cancelled` has become true.
  bool file(uint32_t id, Bytes payload, const std::function<bool()>& cancelled);

  /// The next frame to send.
  std::optional<protocol::Frame> next();
  /// Text that waits exceeds its limit.
  bool congested() const;
  /// The same; if so, `drained` is called once (on the thread of next()) when it no longer does, not if it closes before.
  bool congested(std::function<void()> drained);
  bool empty() const;
  void close();
  /// Calls `action` when it closes, at once if it has. The same as of `wake` holds.
  void onClose(std::function<void()> action);

  struct Counters {
    uint64_t queuedBytes = 0, sentBytes = 0, tilesSent = 0, tilesDropped = 0, eventsLost = 0;
    uint64_t mostQueuedBytes = 0;
  };
  Counters counters() const;

 private:
  using Frame = protocol::Frame;
  struct Window {
    std::deque<Frame> records;
    uint64_t frame = 0;
    uint32_t scale = 0, pass = 0;
    std::function<void()> sent;  ///< of an end of a pass that waits
  };

  void add(std::deque<Frame>& queue, Frame frame);
  void dropTilesOf(Window& window, bool endsOfPassesToo);
  void account(int64_t bytes);
  Frame taken(std::deque<Frame>& queue);
  std::optional<Frame> takeNext(std::vector<std::function<void()>>& then);

  const Limits limits_;
  const std::function<void()> wake_;
  mutable std::mutex mutex_;
  std::condition_variable filesLeft_;
  LedgerEntry memory_;
  bool closed_ = false, gone_ = false;  ///< nothing is taken any more; close() was called
  std::optional<Frame> farewell_;
  std::deque<Frame> control_, text_, files_;
  std::map<uint32_t, Window> windows_;
  uint32_t lastWindow_ = 0;
  std::vector<std::function<void()>> drained_, closeActions_;
  uint64_t textBytes_ = 0, fileBytes_ = 0, pixelBytes_ = 0, lost_ = 0;
  Counters counters_;
};

}  // namespace gxy
