// SPDX-License-Identifier: Apache-2.0
#include "insitu/plan/sender.h"

#include <algorithm>
#include <utility>

#include "core/comm/error.h"

namespace gxy::insitu {

void Sender::begin() {
  const std::lock_guard lock(mutex_);
  settle();
  question_.reset();
  missed_.reset();
  told_ = 0;
  heard_ = true;
  cursors_.clear();
}

void Sender::expect(std::vector<Load> loads) {
  const std::lock_guard lock(mutex_);
  if (slot_ != Slot::Free && slot_ != Slot::Void)
    throw Error("another form of steps while one is under way, expected it between two steps");
  cursors_.clear();
  for (Load& load : loads) cursors_.push_back({std::move(load)});
}

// Frees the slot, or sees to it that filled() does. With the lock held.
void Sender::settle() {
  if (slot_ == Slot::Free || slot_ == Slot::Void) return;
  announcement_.reset();
  const bool isBeingFilled = slot_ == Slot::Appointed && !appointment_.cancel(appointed_);
  slot_ = isBeingFilled ? Slot::Void : Slot::Free;
}

void Sender::await() {
  const std::lock_guard lock(mutex_);
  awaited_ = appointment_.count() + 1;
}

std::optional<Control> Sender::waits() {
  const std::lock_guard lock(mutex_);
  if (awaited_ <= appointment_.count() || awaited_ == told_ || !heard_) return std::nullopt;
  told_ = awaited_;
  heard_ = false;
  return Control{Control::Kind::Waits, awaited_, 0};
}

uint64_t Sender::pointsOf(const Item& item) const {
  return item.number < 0 ? item.points : counts_.at(size_t(item.number));
}

void Sender::filled(int64_t step, double time, Counts counts) {
  const std::lock_guard lock(mutex_);
  if (slot_ == Slot::Void) {
    slot_ = Slot::Free;
    return;
  }
  slot_ = Slot::Full;
  announcement_ = StepHeader{appointed_, step, time};
  counts_ = std::move(counts);
  uint64_t begin = 0;
  for (Cursor& c : cursors_) {
    c.item = 0;
    c.begin = begin;
    c.offset = 0;
    for (const Item& item : c.load.items) begin += pointsOf(item) * item.bytesPerPoint;
  }
}

void Sender::notFilled(bool late) {
  const std::lock_guard lock(mutex_);
  if (std::exchange(slot_, Slot::Free) != Slot::Void)
    missed_ = Control{Control::Kind::Missed, appointed_, late ? appointment_.count() : appointed_ - 1};
}

std::optional<Control> Sender::receive(const Control& message) {
  const std::lock_guard lock(mutex_);
  heard_ = true;
  switch (message.kind) {
    case Control::Kind::AskNewest:
      question_ = message.count;
      return answerNow();
    case Control::Kind::Appoint:
      return appoint(message.count);
    case Control::Kind::Published:
      if (slot_ == Slot::Full && appointed_ == message.count) published_++;
      settle();
      return std::nullopt;
    case Control::Kind::Cancel:
      settle();
      return std::nullopt;
    case Control::Kind::Newest:
    case Control::Kind::Missed:
    case Control::Kind::Waits:
      break;
  }
  throw Error("control message that only simulations send, expected one of a server");
}

// With the lock held, as appoint().
std::optional<Control> Sender::answerNow() {
  if (!question_ || slot_ == Slot::Void) return std::nullopt;
  return Control{Control::Kind::Newest, *std::exchange(question_, std::nullopt), appointment_.count()};
}

std::optional<Control> Sender::answer() {
  const std::lock_guard lock(mutex_);
  if (missed_) return std::exchange(missed_, std::nullopt);
  return answerNow();
}

std::optional<Control> Sender::appoint(uint64_t count) {
  if (slot_ != Slot::Free) return Control{Control::Kind::Missed, count, appointment_.count()};
  slot_ = Slot::Appointed;
  appointed_ = count;
  if (appointment_.appoint(count)) return std::nullopt;
  slot_ = Slot::Free;
  return Control{Control::Kind::Missed, count, appointment_.count()};
}

std::optional<StepHeader> Sender::announcement() {
  const std::lock_guard lock(mutex_);
  return std::exchange(announcement_, std::nullopt);
}

std::optional<Sender::Chunk> Sender::next(int owner) {
  const std::lock_guard lock(mutex_);
  if (slot_ != Slot::Full) return std::nullopt;
  for (Cursor& c : cursors_) {
    if (c.load.owner != owner || c.item == c.load.items.size()) continue;
    const Item& item = c.load.items[c.item];
    const uint64_t points = pointsOf(item), size = points * item.bytesPerPoint;
    const uint64_t bytes = std::min(kChunkBytes / item.bytesPerPoint * item.bytesPerPoint, size - c.offset);
    const Chunk chunk{owner, {appointed_, c.offset, points, c.item, 0}, c.begin + c.offset, bytes};
    c.offset += bytes;
    if (c.offset == size) {
      c.item++;
      c.begin += size;
      c.offset = 0;
    }
    return chunk;
  }
  return std::nullopt;
}

bool Sender::idle() const {
  const std::lock_guard lock(mutex_);
  return slot_ != Slot::Full;
}

}  // namespace gxy::insitu
