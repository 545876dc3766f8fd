// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/outbox.h"

#include <algorithm>
#include <chrono>

#include "multiserver/protocol/json.h"

namespace gxy {

using protocol::MessageChannel;
using protocol::PixelKind;

namespace {

PixelKind kindOf(const protocol::WireMessage& message) { return protocol::pixelHeader(message.payload).kind; }

}  // namespace

Outbox::Outbox(Limits limits, std::function<void()> wake, LedgerEntry memory)
    : limits_(limits), wake_(std::move(wake)), memory_(std::move(memory)) {}

void Outbox::account(int64_t bytes) {
  counters_.queuedBytes += uint64_t(bytes);
  counters_.mostQueuedBytes = std::max(counters_.mostQueuedBytes, counters_.queuedBytes);
  memory_.resize(int64_t(counters_.queuedBytes));
}

void Outbox::chargeTo(LedgerEntry memory) {
  const std::lock_guard lock(mutex_);
  memory_ = std::move(memory);
  memory_.resize(int64_t(counters_.queuedBytes));
}

// Called with the lock held.
void Outbox::add(std::deque<WireMessage>& queue, WireMessage message) {
  account(int64_t(message.payload.size()));
  queue.push_back(std::move(message));
}

void Outbox::control(std::string_view text) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    add(control_, protocol::textMessage(MessageChannel::Control, 0, text));
  }
  wake_();
}

void Outbox::farewell(std::string_view text) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    farewell_ = protocol::textMessage(MessageChannel::Control, 0, text);
  }
  wake_();
}

void Outbox::reply(uint32_t id, std::string_view text) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    textBytes_ += text.size();
    add(text_, protocol::textMessage(MessageChannel::Reply, id, text));
  }
  wake_();
}

bool Outbox::event(const nlohmann::json& event) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return false;
    if (textBytes_ > limits_.text) {
      lost_++;
      counters_.eventsLost++;
      return false;
    }
    const auto put = [this](const nlohmann::json& json) {
      WireMessage message = protocol::textMessage(MessageChannel::Event, 0, protocol::dump(json));
      textBytes_ += message.payload.size();
      add(text_, std::move(message));
    };
    if (lost_) put({{"event", "lost"}, {"count", std::exchange(lost_, 0)}});
    put(event);
  }
  wake_();
  return true;
}

// Ends of frames are not dropped, because the protocol promises that each is sent.
void Outbox::dropTilesOf(Window& window, bool endsOfPassesToo) {
  std::deque<WireMessage> kept;
  if (endsOfPassesToo) window.sent = nullptr;
  for (WireMessage& message : window.records) {
    const PixelKind kind = kindOf(message);
    if (kind == PixelKind::EndOfFrame || (kind == PixelKind::EndOfPass && !endsOfPassesToo)) {
      kept.push_back(std::move(message));
      continue;
    }
    counters_.tilesDropped += kind == PixelKind::Tile;
    pixelBytes_ -= message.payload.size();
    account(-int64_t(message.payload.size()));
  }
  window.records = std::move(kept);
}

bool Outbox::pixels(Bytes record, std::function<void()> sent) {
  const protocol::PixelHeader header = protocol::pixelHeader(record);
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return true;
    Window& window = windows_[header.window];
    if (header.kind == PixelKind::Tile) {
      const bool otherFrame = window.frame != header.frame;
      // Coarser levels stay, because they are small and are seen first.
      if (otherFrame || (window.scale == header.scale && window.pass != header.pass))
        dropTilesOf(window, otherFrame);
      window.frame = header.frame;
      window.scale = header.scale;
      window.pass = header.pass;
      if (pixelBytes_ + record.size() > limits_.pixels) {
        counters_.tilesDropped++;
        return false;
      }
    }
    if (sent) window.sent = std::move(sent);
    pixelBytes_ += record.size();
    if (header.kind == PixelKind::EndOfFrame)
      textBytes_ += record.size();  // counted as text, since they are never dropped
    add(window.records, {MessageChannel::Pixels, 0, std::move(record)});
  }
  wake_();
  return true;
}

void Outbox::dropTiles(uint32_t id) {
  const std::lock_guard lock(mutex_);
  const auto window = windows_.find(id);
  if (window != windows_.end()) dropTilesOf(window->second, true);
}

bool Outbox::file(uint32_t id, Bytes payload, const std::function<bool()>& cancelled) {
  {
    std::unique_lock lock(mutex_);
    while (!closed_ && fileBytes_ > 0 && fileBytes_ + payload.size() > limits_.files) {
      if (cancelled()) return false;
      filesLeft_.wait_for(lock, std::chrono::milliseconds(100));
    }
    if (closed_) return false;
    fileBytes_ += payload.size();
    add(files_, {MessageChannel::File, id, std::move(payload)});
  }
  wake_();
  return true;
}

Outbox::WireMessage Outbox::taken(std::deque<WireMessage>& queue) {
  WireMessage message = std::move(queue.front());
  queue.pop_front();
  account(-int64_t(message.payload.size()));
  counters_.sentBytes += message.payload.size() + protocol::kHeaderBytes;
  return message;
}

std::optional<Outbox::WireMessage> Outbox::next() {
  std::vector<std::function<void()>> then;
  std::optional<WireMessage> message = takeNext(then);
  for (const auto& action : then) action();
  return message;
}

std::optional<Outbox::WireMessage> Outbox::takeNext(std::vector<std::function<void()>>& then) {
  const std::lock_guard lock(mutex_);
  if (closed_) return std::nullopt;
  if (textBytes_ <= limits_.text) then.swap(belowWatermark_);
  if (!control_.empty()) return taken(control_);
  // A reply is sent after the files of its request.
  if (farewell_ && text_.empty()) {
    closed_ = true;
    return std::exchange(farewell_, std::nullopt);
  }
  if (!text_.empty() && (farewell_ || files_.empty() || text_.front().channel == MessageChannel::Event ||
                         std::none_of(files_.begin(), files_.end(),
                                      [&](const WireMessage& f) { return f.id == text_.front().id; }))) {
    textBytes_ -= text_.front().payload.size();
    return taken(text_);
  }
  auto window = windows_.upper_bound(lastWindow_);
  for (size_t tried = 0; tried < windows_.size(); tried++, ++window) {
    if (window == windows_.end()) window = windows_.begin();
    if (window->second.records.empty()) continue;
    lastWindow_ = window->first;
    const WireMessage& first = window->second.records.front();
    pixelBytes_ -= first.payload.size();
    const PixelKind kind = kindOf(first);
    counters_.tilesSent += kind == PixelKind::Tile;
    if (kind == PixelKind::EndOfPass && window->second.sent)
      then.push_back(std::exchange(window->second.sent, nullptr));
    if (kind == PixelKind::EndOfFrame) textBytes_ -= first.payload.size();
    WireMessage message = taken(window->second.records);
    if (window->second.records.empty() && kind == PixelKind::EndOfFrame) windows_.erase(window);
    return message;
  }
  if (files_.empty()) return std::nullopt;
  fileBytes_ -= files_.front().payload.size();
  filesLeft_.notify_all();
  return taken(files_);
}

bool Outbox::aboveWatermark() const {
  const std::lock_guard lock(mutex_);
  return textBytes_ > limits_.text;
}

bool Outbox::aboveWatermark(std::function<void()> belowWatermark) {
  const std::lock_guard lock(mutex_);
  if (textBytes_ <= limits_.text) return false;
  belowWatermark_.push_back(std::move(belowWatermark));
  return true;
}

bool Outbox::empty() const {
  const std::lock_guard lock(mutex_);
  return control_.empty() && text_.empty() && files_.empty() &&
         std::all_of(windows_.begin(), windows_.end(),
                     [](const auto& w) { return w.second.records.empty(); });
}

void Outbox::onClose(std::function<void()> action) {
  {
    const std::lock_guard lock(mutex_);
    if (!gone_) return closeActions_.push_back(std::move(action));
  }
  action();
}

void Outbox::close() {
  std::vector<std::function<void()>> actions;
  std::unique_lock lock(mutex_);
  closed_ = gone_ = true;
  actions.swap(closeActions_);
  control_.clear();
  text_.clear();
  files_.clear();
  windows_.clear();
  belowWatermark_.clear();
  counters_.queuedBytes = 0;
  memory_.resize(0);
  filesLeft_.notify_all();
  lock.unlock();
  for (const auto& action : actions) action();
}

Outbox::Counters Outbox::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

}  // namespace gxy
