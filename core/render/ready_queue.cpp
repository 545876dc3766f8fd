// SPDX-License-Identifier: Apache-2.0
#include "core/render/ready_queue.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace gxy {

/// Tenants and streams whose turn it is but whose tile found too few credits. Others with as many credits
/// out, or more, may not take any before them.
struct ReadyQueue::Blocked {
  /// The least credits out of a tenant that waits, and of a stream of `whose` that waits.
  int64_t tenant = INT64_MAX, stream = INT64_MAX;
  uint32_t whose = 0;  ///< the tenant that waits first
  void add(const Credits& credits, const Priority& priority) {
    if (tenant == INT64_MAX) whose = priority.tenant;
    tenant = std::min(tenant, credits.outOfTenant(priority));
    if (priority.tenant == whose) stream = std::min(stream, credits.outOfStream(priority));
  }
  bool hinders(const Credits& credits, const Priority& priority) const {
    if (tenant == INT64_MAX) return false;
    return priority.tenant == whose ? credits.outOfStream(priority) >= stream
                                    : credits.outOfTenant(priority) >= tenant;
  }
};

ReadyQueue::Entry& ReadyQueue::entry(const Priority& priority, uint64_t frame) {
  Entry& entry = tenants_[priority.tenant].streams[priority.stream].frames[frame];
  entry.interactive = priority.interactive;
  return entry;
}

void ReadyQueue::push(const Priority& priority, uint64_t frame, Task task, bool first) {
  const std::lock_guard lock(mutex_);
  Entry& frames = entry(priority, frame);
  if (first)
    frames.rests.push_front(std::move(task));
  else
    frames.others.push_back(std::move(task));
  tasks_++;
}

void ReadyQueue::addTiles(const Priority& priority, uint64_t frame, std::shared_ptr<TileSource> tiles) {
  const std::lock_guard lock(mutex_);
  if (!tiles->empty()) entry(priority, frame).tiles = std::move(tiles);
}

bool ReadyQueue::dropTiles(const Priority& priority, uint64_t frame) {
  std::shared_ptr<TileSource> dropped;  // destroyed after the lock is released
  const std::lock_guard lock(mutex_);
  const auto tenant = tenants_.find(priority.tenant);
  if (tenant == tenants_.end()) return false;
  const auto stream = tenant->second.streams.find(priority.stream);
  if (stream == tenant->second.streams.end()) return false;
  const auto found = stream->second.frames.find(frame);
  if (found == stream->second.frames.end()) return false;
  dropped.swap(found->second.tiles);
  if (found->second.empty()) stream->second.frames.erase(found);
  return dropped != nullptr;
}

// Whether something of a stream may be done now, provided that nobody before it waits for credits.
bool ReadyQueue::mayDo(const Priority& priority, const Stream& stream) const {
  return std::ranges::any_of(stream.frames, [&](const auto& frame) {
    const Entry& entry = frame.second;
    return !entry.rests.empty() || !entry.others.empty() ||
           (entry.tiles && credits_.mayTake(priority, entry.tiles->cost()));
  });
}

// Lets children that want something take part, and makes them begin where the others are. `least` becomes the
// least time used by a child that takes part, but never decreases.
template <class Children>
void ReadyQueue::letTakePart(Children& children, Time& least) {
  const auto leastOf = [&](auto&& counts, Time otherwise) {
    Time found = Time::max();
    for (const auto& [key, child] : children)
      if (child.turn.takesPart && counts(child.turn)) found = std::min(found, child.turn.used);
    return found == Time::max() ? otherwise : found;
  };
  for (auto& [key, child] : children)
    if (!child.turn.wants && child.turn.running == 0) child.turn.takesPart = false;
  const Time ofWatched = leastOf([](const Turn& turn) { return turn.watched; }, least);
  for (auto& [key, child] : children) {
    Turn& turn = child.turn;
    if (turn.takesPart || (!turn.wants && turn.running == 0)) continue;
    turn.used = std::max({turn.used, least, turn.watched ? ofWatched : least});
    turn.takesPart = true;
  }
  least = std::max(least, leastOf([](const Turn&) { return true; }, least));
}

// Finds out who wants something and takes part, and forgets tenants and streams that hold nothing worth
// keeping.
void ReadyQueue::refresh() {
  for (auto& [number, tenant] : tenants_) {
    Turn& all = tenant.turn;
    all.wants = all.watched = false;
    for (auto& [key, stream] : tenant.streams) {
      Turn& turn = stream.turn;
      turn.wants = mayDo({number, false, key}, stream);
      turn.watched =
          std::ranges::any_of(stream.frames, [](const auto& frame) { return frame.second.interactive; });
      all.wants = all.wants || turn.wants;
      all.watched = all.watched || turn.watched;
    }
    letTakePart(tenant.streams, tenant.least);
    std::erase_if(tenant.streams, [least = tenant.least](const auto& stream) {
      const Turn& turn = stream.second.turn;
      return stream.second.frames.empty() && turn.running == 0 && turn.used <= least;
    });
  }
  letTakePart(tenants_, least_);
  std::erase_if(tenants_, [&](const auto& tenant) {
    const Turn& turn = tenant.second.turn;
    return tenant.second.streams.empty() && turn.running == 0 && turn.used <= least_;
  });
}

// Returns the tenants, or the streams of a tenant, in the order of their turns.
template <class Children>
auto ReadyQueue::inTurn(Children& children) const {
  using Child = std::pair<std::pair<Time, uint64_t>, typename Children::value_type*>;
  std::vector<Child> order;
  for (auto& child : children) {
    const Turn& turn = child.second.turn;
    order.push_back({{turn.used - (turn.watched ? options_.ahead : Time(0)), turn.served}, &child});
  }
  std::ranges::sort(order, {}, &Child::first);
  return order;
}

ReadyQueue::Pick ReadyQueue::pick(const Priority& priority, Stream& stream, Blocked& blocked) const {
  bool spawns = true;
  for (const bool interactive : {true, false})
    for (auto& [frame, entry] : stream.frames) {
      if (entry.interactive != interactive) continue;
      const Pick found{&stream, frame, Kind::Rest, {priority.tenant, interactive, priority.stream}};
      if (!entry.rests.empty()) return found;
      if (entry.tiles && spawns && !blocked.hinders(credits_, priority)) {
        if (credits_.mayTake(priority, entry.tiles->cost()))
          return {&stream, frame, Kind::SpawnTile, found.priority};
        blocked.add(credits_, priority);
      }
      spawns = spawns && !entry.tiles;  // tiles of newer frames wait for those of this frame
      if (!entry.others.empty()) return {&stream, frame, Kind::Other, found.priority};
    }
  return {};
}

ReadyQueue::Pick ReadyQueue::choose() {
  refresh();
  Blocked blocked;
  for (const auto& [order, tenant] : inTurn(tenants_))
    for (const auto& [inTenant, stream] : inTurn(tenant->second.streams))
      if (const Pick found = pick({tenant->first, false, stream->first}, stream->second, blocked);
          found.stream)
        return found;
  return {};
}

ReadyQueue::Task ReadyQueue::take(const Pick& pick) {
  const auto at = pick.stream->frames.find(pick.frame);
  Entry& entry = at->second;
  Task task;
  if (pick.kind == Kind::SpawnTile) {
    credits_.take(pick.priority, entry.tiles->cost());
    task = entry.tiles->take();
    if (entry.tiles->empty()) entry.tiles = nullptr;
  } else {
    std::deque<Task>& tasks = pick.kind == Kind::Rest ? entry.rests : entry.others;
    task = std::move(tasks.front());
    tasks.pop_front();
    tasks_--;
  }
  if (entry.empty()) pick.stream->frames.erase(at);
  return task;
}

ReadyQueue::Next ReadyQueue::pop() {
  const std::lock_guard lock(mutex_);
  const Pick found = choose();
  if (!found.stream) return {};
  const Time expected = found.stream->turn.last;
  turn_++;
  for (Turn* turn : {&tenants_.at(found.priority.tenant).turn, &found.stream->turn}) {
    turn->served = turn_;
    turn->running++;
    turn->used += expected;
  }
  return {take(found), found.priority, expected};
}

void ReadyQueue::ran(const Next& done, Time took) {
  const std::lock_guard lock(mutex_);
  Tenant& tenant = tenants_.at(done.priority.tenant);
  for (Turn* turn : {&tenant.turn, &tenant.streams.at(done.priority.stream).turn}) {
    turn->running--;
    turn->used += took - done.expected;
    turn->last = took;
  }
}

bool ReadyQueue::ready() {
  const std::lock_guard lock(mutex_);
  return choose().stream != nullptr;
}

void ReadyQueue::giveBack(const Priority& priority, int64_t credits) {
  const std::lock_guard lock(mutex_);
  credits_.giveBack(priority, credits);
}

Credits ReadyQueue::credits() const {
  const std::lock_guard lock(mutex_);
  return credits_;
}

size_t ReadyQueue::size() const {
  const std::lock_guard lock(mutex_);
  return tasks_;
}

}  // namespace gxy
