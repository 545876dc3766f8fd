// SPDX-License-Identifier: Apache-2.0
#include "core/rays/ray_list.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

namespace gxy {

namespace {

#define GXY_COUNT(type, name, primary, secondary) +1
constexpr int kFields = 0 GXY_RAY_FIELDS(GXY_COUNT);
#undef GXY_COUNT
constexpr std::align_val_t kAlignment{64};

size_t padded(int capacity) { return (size_t(capacity) + 15) / 16 * 16; }

}  // namespace

void RayList::Free::operator()(uint32_t* p) const { ::operator delete[](p, kAlignment); }

RayList::RayList(int capacity) : capacity_(capacity) {
  const size_t stride = padded(capacity);
  auto* p = static_cast<uint32_t*>(::operator new[](stride* kFields * sizeof(uint32_t), kAlignment));
  storage_.reset(p);
#define GXY_POINT(type, name, primary, secondary) \
  view_.name = reinterpret_cast<type*>(p);        \
  p += stride;
  GXY_RAY_FIELDS(GXY_POINT)
#undef GXY_POINT
}

RayList::RayList(std::shared_ptr<const DeviceRays> kept, std::vector<uint32_t> places)
    : size_(int(places.size())), capacity_(size_), kept_(std::move(kept)), places_(std::move(places)) {}

int64_t RayList::bytes() const {
  if (kept_) return int64_t(places_.size() * sizeof(uint32_t));
  return storage_ ? int64_t(padded(capacity_) * kFields * sizeof(uint32_t)) : 0;
}

RayList RayList::gather(std::span<const int> which) const {
  RayList list(int(which.size()));
  list.resize(int(which.size()));
  list.complete_ = complete_;
#define GXY_GATHER(type, name, primary, secondary) \
  if (primary || secondary)                        \
    for (size_t k = 0; k < which.size(); k++) list.view_.name[k] = view_.name[which[k]];
  GXY_RAY_FIELDS(GXY_GATHER)
#undef GXY_GATHER
  return list;
}

std::vector<RayList> RayList::split(int size) const {
  std::vector<RayList> parts;
  for (int i = 0; i < size_; i += size) {
    if (kept_) {
      const auto some = places().subspan(size_t(i), size_t(std::min(size, size_ - i)));
      parts.push_back({kept_, {some.begin(), some.end()}});
      continue;
    }
    RayList& part = parts.emplace_back(std::min(size, size_ - i));
    part.resize(std::min(size, size_ - i));
    part.complete_ = complete_;
#define GXY_SLICE(type, name, primary, secondary) \
  if (primary || secondary) std::memcpy(part.view_.name, view_.name + i, 4 * size_t(part.size_));
    GXY_RAY_FIELDS(GXY_SLICE)
#undef GXY_SLICE
  }
  return parts;
}

int RayList::wireBytes(bool primary) {
#define GXY_WIDTH(type, name, onPrimary, onSecondary) +4 * (primary ? onPrimary : onSecondary)
  return 0 GXY_RAY_FIELDS(GXY_WIDTH);
#undef GXY_WIDTH
}

void RayList::write(std::span<const int> which, bool primary, Bytes& out) const {
  size_t at = out.size();
  out.resize(at + which.size() * size_t(wireBytes(primary)));
#define GXY_WRITE(type, name, onPrimary, onSecondary)  \
  if (primary ? onPrimary : onSecondary)               \
    for (int i : which) {                              \
      std::memcpy(out.data() + at, view_.name + i, 4); \
      at += 4;                                         \
    }
  GXY_RAY_FIELDS(GXY_WRITE)
#undef GXY_WRITE
}

RayList RayList::read(std::span<const std::byte> in, int count, bool primary) {
  RayList list(count);
  list.resize(count);
  list.complete_ = !primary;
  size_t at = 0;
#define GXY_READ(type, name, onPrimary, onSecondary)                 \
  if (primary ? onPrimary : onSecondary) {                           \
    std::memcpy(list.view_.name, in.data() + at, 4 * size_t(count)); \
    at += 4 * size_t(count);                                         \
  }
  GXY_RAY_FIELDS(GXY_READ)
#undef GXY_READ
  return list;
}

}  // namespace gxy
