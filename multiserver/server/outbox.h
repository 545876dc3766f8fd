// SPDX-License-Identifier: Apache-2.0
// The queue of messages to one client. Its size is bounded, however slowly the client reads.
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
#include "multiserver/protocol/pixel_record.h"
#include "multiserver/protocol/wire_message.h"

namespace gxy {

/// Queues messages by kind. Each kind has its own answer to a slow reader. While too much text waits
/// (aboveWatermark()), the server stops reading the client's requests, and events are left out. Files wait: file()
/// blocks. Tiles of a pass are dropped when a newer pass of their window comes. Messages are sent in this
/// order: control, replies and events, tiles (windows in turn), files.
///
/// Thread safe. After close() all new messages are dropped and nobody waits.
class Outbox {
 public:
  struct Limits {
    size_t text = 4 << 20, files = 64 << 20, pixels = 256 << 20;  ///< bytes in the queue, by kind
  };

  /// `wake` is called from any thread when there is something to send. It must be short, and must not take a
  /// lock that is held during calls of the Outbox. `memory` is resized to the bytes in the queue.
  Outbox(Limits limits, std::function<void()> wake, LedgerEntry memory);

  /// From now on, the queue is charged to `memory` instead.
  void chargeTo(LedgerEntry memory);

  void control(std::string_view text);
  /// Adds a last control message. It is sent after waiting replies and events, and nothing is sent after it.
  void farewell(std::string_view text);
  void reply(uint32_t id, std::string_view text);
  /// Returns false if the event was left out; it is then counted in the next `lost` event.
  bool event(const nlohmann::json& event);

  /// Adds a record of pixel_record.h. If it is a tile of another frame, or of another pass of the same level,
  /// than the last one of its window, the window's older tiles are dropped. Returns false if the tile itself
  /// was dropped because too much waits. For the end of a pass, `sent` is called on the thread of next() when
  /// this record or a later end of a pass has been taken, but not if it was dropped. A window has one such
  /// function at a time.
  bool pixels(Bytes record, std::function<void()> sent = {});
  /// Drops the tiles and ends of passes of a window.
  void dropTiles(uint32_t window);

  /// Adds a file record, and blocks while too many bytes of files wait. Returns false if the client has gone
  /// or `cancelled` returns true.
  bool file(uint32_t id, Bytes payload, const std::function<bool()>& cancelled);

  /// Takes the next message to send.
  std::optional<protocol::WireMessage> next();
  /// Whether more text waits than the limit.
  bool aboveWatermark() const;
  /// The same. If true, `belowWatermark` is called once on the thread of next() when it is no longer so; not if the
  /// Outbox is closed before.
  bool aboveWatermark(std::function<void()> belowWatermark);
  bool empty() const;
  void close();
  /// Calls `action` on close(), or at once if it is closed. `action` must satisfy the conditions of `wake`.
  void onClose(std::function<void()> action);

  struct Counters {
    uint64_t queuedBytes = 0, sentBytes = 0, tilesSent = 0, tilesDropped = 0, eventsLost = 0;
    uint64_t mostQueuedBytes = 0;
  };
  Counters counters() const;

 private:
  using WireMessage = protocol::WireMessage;
  struct Window {
    std::deque<WireMessage> records;
    uint64_t frame = 0;
    uint32_t scale = 0, pass = 0;
    std::function<void()> sent;  ///< function of the end of a pass that waits
  };

  void add(std::deque<WireMessage>& queue, WireMessage message);
  void dropTilesOf(Window& window, bool endsOfPassesToo);
  void account(int64_t bytes);
  WireMessage taken(std::deque<WireMessage>& queue);
  std::optional<WireMessage> takeNext(std::vector<std::function<void()>>& then);

  const Limits limits_;
  const std::function<void()> wake_;
  mutable std::mutex mutex_;
  std::condition_variable filesLeft_;
  LedgerEntry memory_;
  bool closed_ = false, gone_ = false;  ///< no more messages are accepted; close() was called
  std::optional<WireMessage> farewell_;
  std::deque<WireMessage> control_, text_, files_;
  std::map<uint32_t, Window> windows_;
  uint32_t lastWindow_ = 0;
  std::vector<std::function<void()>> belowWatermark_, closeActions_;
  uint64_t textBytes_ = 0, fileBytes_ = 0, pixelBytes_ = 0, lost_ = 0;
  Counters counters_;
};

}  // namespace gxy
