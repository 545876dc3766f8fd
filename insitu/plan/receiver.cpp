// SPDX-License-Identifier: Apache-2.0
#include "insitu/plan/receiver.h"

#include <algorithm>

#include "core/comm/error.h"

namespace gxy::insitu {

Receiver::Receiver(std::vector<Source> sources) { expect(std::move(sources)); }

void Receiver::expect(std::vector<Source> sources) {
  if (state_ != State::Closed) throw Error("another form of steps while there is room, expected none");
  cursors_.clear();
  for (Source& s : sources) cursors_.push_back({std::move(s)});
}

void Receiver::restart(uint64_t count) {
  current_ = count;
  missing_ = 0;
  for (Cursor& c : cursors_) {
    c.item = 0;
    c.offset = 0;
    if (!c.source.empty()) missing_++;
  }
}

void Receiver::open() {
  state_ = State::Open;
  restart(0);
}

bool Receiver::accept(int rank, const PieceHeader& header, uint64_t bytes) {
  if (header.count <= last_ || (state_ == State::Open && header.count < current_)) return false;
  if (state_ != State::Open)
    throw Error("step of publish " + std::to_string(header.count) + ", which was not asked for");
  if (header.count > current_) restart(header.count);
  Cursor& c = cursors_.at(size_t(rank));
  if (c.item >= c.source.size() || header.item != c.item || header.offset != c.offset)
    throw Error("chunk at byte " + std::to_string(header.offset) + " of item " + std::to_string(header.item) +
                ", expected byte " + std::to_string(c.offset) + " of item " + std::to_string(c.item) +
                " of " + std::to_string(c.source.size()));
  const Item& item = c.source[c.item];
  if (item.first && c.offset == 0) {
    if (header.points > kMostParticles)
      throw Error(std::to_string(header.points) +
                  " points, cells or corners of cells of one rank, expected at most 2^32 - 2");
    c.entries = header.points;
  }
  const uint64_t points = item.number < 0 ? item.points : c.entries;
  const uint64_t size = points * item.bytesPerPoint, left = size - c.offset;
  if (header.points != points || (bytes == 0 && size > 0) || bytes > left || bytes % item.bytesPerPoint != 0)
    throw Error("chunk of " + std::to_string(bytes) + " bytes, of an item of " +
                std::to_string(header.points) + " points, expected one of " + std::to_string(points) +
                " points, whole points of " + std::to_string(item.bytesPerPoint) + " bytes, and at most " +
                std::to_string(left) + " bytes");
  c.offset += bytes;
  if (c.offset == size) {
    c.item++;
    c.offset = 0;
    if (c.item == c.source.size()) missing_--;
  }
  return true;
}

void Receiver::refuse(uint64_t count) {
  last_ = std::max(last_, count);
  if (state_ == State::Open && current_ <= count) restart(0);
}

bool Receiver::take(uint64_t count) {
  const bool nothingComes =
      std::all_of(cursors_.begin(), cursors_.end(), [](const Cursor& c) { return c.source.empty(); });
  if (state_ != State::Open || !(nothingComes || (complete() && current_ == count))) return false;
  state_ = State::Taken;
  last_ = count;
  return true;
}

void Receiver::close(uint64_t upTo) {
  state_ = State::Closed;
  last_ = std::max({last_, current_, upTo});
}

}  // namespace gxy::insitu
