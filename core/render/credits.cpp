// SPDX-License-Identifier: Apache-2.0
#include "core/render/credits.h"

#include <algorithm>

namespace gxy {

namespace {

constexpr int64_t kOfFree = 7;  // credits out are at most this multiple of the credits that stay free

// Whether somebody with `out` credits of a pool may take `cost` more while `free` are left.
bool fits(int64_t out, int64_t cost, int64_t free) {
  return cost <= free && (out <= 0 || out + cost <= kOfFree * (free - cost));
}

template <class Map, class Key>
int64_t at(const Map& map, const Key& key) {
  const auto found = map.find(key);
  return found == map.end() ? 0 : found->second;
}

template <class Map, class Key>
void add(Map& map, const Key& key, int64_t by) {
  const auto entry = map.try_emplace(key, 0).first;
  if ((entry->second += by) == 0) map.erase(entry);
}

}  // namespace

int64_t Credits::outOfTenant(const Priority& priority) const { return at(tenants_, priority.tenant); }

int64_t Credits::outOfStream(const Priority& priority) const {
  return at(streams_, std::pair(priority.tenant, priority.stream));
}

bool Credits::mayTake(const Priority& priority, int64_t cost) const {
  if (out_ <= 0) return true;
  const int64_t free = all_ - out_, ofTenant = outOfTenant(priority);
  if (!fits(ofTenant, cost, free)) return false;
  const int64_t room = ofTenant > 0 ? (kOfFree * free - ofTenant) / (1 + kOfFree) : free;
  return fits(outOfStream(priority), cost, room);
}

void Credits::change(const Priority& priority, int64_t by) {
  out_ += by;
  mostOut_ = std::max(mostOut_, out_);
  add(tenants_, priority.tenant, by);
  add(streams_, std::pair(priority.tenant, priority.stream), by);
}

void Credits::take(const Priority& priority, int64_t cost) { change(priority, cost); }

void Credits::giveBack(const Priority& priority, int64_t credits) { change(priority, -credits); }

}  // namespace gxy
