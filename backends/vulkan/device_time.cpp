// SPDX-License-Identifier: Apache-2.0
#include "backends/vulkan/device_time.h"

#include <algorithm>
#include <iterator>

namespace gxy::vulkan {

namespace {

constexpr size_t kLatest = 16;  // more than batches under way at once, and so than can be told late

}  // namespace

int64_t Intervals::add(uint64_t begin, uint64_t end) {
  if (end <= begin) return 0;
  auto added = int64_t(end - begin);
  auto next = ends_.upper_bound(begin);
  if (next != ends_.begin() && std::prev(next)->second >= begin) --next;
  while (next != ends_.end() && next->first <= end) {
    const auto [first, last] = *next;
    added -= int64_t(std::min(last, end)) - int64_t(std::max(first, begin));
    begin = std::min(begin, first);
    end = std::max(end, last);
    next = ends_.erase(next);
  }
  ends_.emplace_hint(next, begin, end);
  return added;
}

void Intervals::forget(uint64_t time) {
  while (ends_.size() > kLatest && ends_.begin()->second < time) ends_.erase(ends_.begin());
}

uint64_t DeviceTime::unwound(uint64_t time) {
  if (round_ > 0) {
    time += (latest_ - latest_ % round_);
    if (time + round_ / 2 < latest_) time += round_;
    if (time > latest_ + round_ / 2 && time >= round_ && latest_ > 0) time -= round_;
  }
  latest_ = std::max(latest_, time);
  return time;
}

DeviceTime::Spent DeviceTime::worked(uint64_t frame, uint64_t began, uint64_t ended) {
  std::lock_guard lock(mutex_);
  began = unwound(began);
  ended = unwound(ended);
  if (ended <= began) return {};
  Span& span = underWay_.try_emplace(frame, Span{began, ended}).first->second;
  span = {std::min(span.began, began), std::max(span.ended, ended)};
  Spent spent;
  spent.busy = work_.add(began, ended);
  spent.idle = frames_.add(span.began, span.ended) - spent.busy;  // since all work is some frame's
  return spent;
}

void DeviceTime::over(uint64_t frame) {
  std::lock_guard lock(mutex_);
  underWay_.erase(frame);
  uint64_t first = UINT64_MAX;
  for (const auto& [number, span] : underWay_) first = std::min(first, span.began);
  frames_.forget(first);
  work_.forget(first);
}

size_t DeviceTime::remembered() const {
  std::lock_guard lock(mutex_);
  return frames_.size() + work_.size();
}

}  // namespace gxy::vulkan
