// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/trace_share.h"

#include <algorithm>
#include <utility>

namespace gxy {

namespace {

constexpr int64_t kMemoryStep = int64_t(1) << 20;
/// Points of results that are smaller than this are copied together.
constexpr size_t kPiece = size_t(1) << 14;

int64_t bytesOfPiece(size_t values) {
  return int64_t(kPiece * (sizeof(uint64_t) + sizeof(int32_t) + sizeof(glm::dvec3) + 2 * sizeof(double) +
                           (1 + values) * sizeof(float)));
}

PathPoints newPiece(size_t values) {
  PathPoints piece;
  piece.line.reserve(kPiece);
  piece.number.reserve(kPiece);
  piece.position.reserve(kPiece);
  piece.time.reserve(kPiece);
  piece.length.reserve(kPiece);
  piece.speed.reserve(kPiece);
  piece.values.resize(values);
  for (auto& v : piece.values) v.reserve(kPiece);
  return piece;
}

template <class T>
void addTo(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

void addTo(PathPoints& to, const PathPoints& from) {
  addTo(to.line, from.line);
  addTo(to.number, from.number);
  addTo(to.position, from.position);
  addTo(to.time, from.time);
  addTo(to.length, from.length);
  addTo(to.speed, from.speed);
  for (size_t k = 0; k < to.values.size(); k++) addTo(to.values[k], from.values[k]);
}

}  // namespace

void TraceShare::takeMemory(int64_t bytes) {
  bytes = (bytes + kMemoryStep - 1) / kMemoryStep * kMemoryStep;
  stored_.memory.reserve(stored_.memory.size() + 1);
  stored_.memory.push_back(request.takeMemory(bytes));
}

void TraceShare::storePoints(PathPoints& points) {
  if (points.size() == 0) return;
  if (points.size() >= kPiece) {
    takeMemory(points.bytes());
    // Before the piece that has room left, if there is one.
    stored_.points.insert(stored_.points.end() - (open_ ? 1 : 0), std::move(points));
    return;
  }
  if (!open_ || stored_.points.back().size() + points.size() > kPiece) {
    const size_t values = points.values.size();
    takeMemory(bytesOfPiece(values));
    stored_.points.push_back(newPiece(values));
    open_ = true;
  }
  addTo(stored_.points.back(), points);
}

void TraceShare::storeEnds(const std::vector<LineEnd>& ends) {
  std::vector<LineEnd>& all = stored_.ends;
  if (all.size() + ends.size() > all.capacity()) {
    const size_t room = std::max({all.size() + ends.size(), 2 * all.capacity(), kPiece});
    takeMemory(int64_t((room - all.capacity()) * sizeof(LineEnd)));
    all.reserve(room);
  }
  addTo(all, ends);
  ends_ += ends.size();
}

void TraceShare::store(AdvanceResult& result) {
  const std::lock_guard lock(mutex_);
  stored_.counters += result.counters;
  storePoints(result.points);
  storeEnds(result.ends);
}

void TraceShare::end() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  changed_.notify_all();
}

bool TraceShare::waitForEnd(std::chrono::milliseconds most) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, most, [this] { return ended_; });
}

TracedLines TraceShare::take() {
  const std::lock_guard lock(mutex_);
  open_ = false;
  return std::exchange(stored_, {});
}

}  // namespace gxy
