// SPDX-License-Identifier: Apache-2.0
#include "core/rays/heads.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>

namespace gxy {

namespace {

#define GXY_COUNT(type, name, sent) +1
constexpr int kFields = 0 GXY_HEAD_FIELDS(GXY_COUNT);
constexpr int kMeshFields = 0 GXY_MESH_HEAD_FIELDS(GXY_COUNT);
#undef GXY_COUNT
constexpr std::align_val_t kAlignment{64};

size_t padded(int size) { return (size_t(size) + 15) / 16 * 16; }
size_t fieldsOf(uint32_t kind) { return size_t(kFields + (kind == kMeshHeads ? kMeshFields : 0)); }

}  // namespace

void HeadList::Free::operator()(uint32_t* p) const { ::operator delete[](p, kAlignment); }

HeadList::HeadList(int partition, int size, uint32_t kind) : partition(partition), size_(size), kind_(kind) {
  const size_t stride = padded(size);
  auto* p = static_cast<uint32_t*>(::operator new[](stride* fieldsOf(kind) * sizeof(uint32_t), kAlignment));
  storage_.reset(p);
#define GXY_POINT(type, name, sent)        \
  view_.name = reinterpret_cast<type*>(p); \
  p += stride;
  GXY_HEAD_FIELDS(GXY_POINT)
  if (kind == kMeshHeads) {
    GXY_MESH_HEAD_FIELDS(GXY_POINT)
  }
#undef GXY_POINT
}

int64_t HeadList::bytes() const {
  return storage_ ? int64_t(padded(size_) * fieldsOf(kind_) * sizeof(uint32_t)) : 0;
}

void HeadList::clear(int i, uint64_t line, bool backward) {
#define GXY_ZERO(type, name, sent) view_.name[i] = 0;
  GXY_HEAD_FIELDS(GXY_ZERO)
  if (kind_ == kMeshHeads) {
    GXY_MESH_HEAD_FIELDS(GXY_ZERO)
  }
#undef GXY_ZERO
  view_.line[i] = uint32_t(line);
  view_.info[i] = (uint32_t(line >> 32) & HEAD_LINE_HIGH) | (backward ? HEAD_BACKWARD : 0);
}

void HeadList::start(int i, uint64_t line, bool backward, const Index3& cell, const float (&fraction)[3]) {
  clear(i, line, backward);
  view_.cellX[i] = int32_t(cell[0]), view_.cellY[i] = int32_t(cell[1]), view_.cellZ[i] = int32_t(cell[2]);
  view_.fx[i] = fraction[0], view_.fy[i] = fraction[1], view_.fz[i] = fraction[2];
}

HeadList HeadList::gather(int to, std::span<const int> which) const {
  HeadList list(to, int(which.size()), kind_);
#define GXY_GATHER(type, name, sent) \
  for (size_t k = 0; k < which.size(); k++) list.view_.name[k] = view_.name[which[k]];
  GXY_HEAD_FIELDS(GXY_GATHER)
  if (kind_ == kMeshHeads) {
    GXY_MESH_HEAD_FIELDS(GXY_GATHER)
  }
#undef GXY_GATHER
  return list;
}

std::vector<HeadList> HeadList::split(int most) const {
  std::vector<HeadList> parts;
  for (int i = 0; i < size_; i += most) {
    HeadList& part = parts.emplace_back(partition, std::min(most, size_ - i), kind_);
#define GXY_SLICE(type, name, sent) std::memcpy(part.view_.name, view_.name + i, 4 * size_t(part.size_));
    GXY_HEAD_FIELDS(GXY_SLICE)
    if (kind_ == kMeshHeads) {
      GXY_MESH_HEAD_FIELDS(GXY_SLICE)
    }
#undef GXY_SLICE
  }
  return parts;
}

void HeadList::write(Bytes& out) const {
  size_t at = out.size();
  out.resize(at + size_t(size_) * size_t(wireBytes(kind_)));
#define GXY_WRITE(type, name, sent)                              \
  if (sent && size_ > 0) {                                       \
    std::memcpy(out.data() + at, view_.name, 4 * size_t(size_)); \
    at += 4 * size_t(size_);                                     \
  }
  GXY_HEAD_FIELDS(GXY_WRITE)
  if (kind_ == kMeshHeads) {
    GXY_MESH_HEAD_FIELDS(GXY_WRITE)
  }
#undef GXY_WRITE
}

int HeadList::wireBytes(uint32_t kind) {
#define GXY_WIDTH(type, name, sent) +4 * sent
  constexpr int kBytes = 0 GXY_HEAD_FIELDS(GXY_WIDTH);
  constexpr int kMeshBytes = 0 GXY_MESH_HEAD_FIELDS(GXY_WIDTH);
#undef GXY_WIDTH
  return kind >= kHeadKinds ? 0 : kBytes + (kind == kMeshHeads ? kMeshBytes : 0);
}

HeadList HeadList::read(int partition, std::span<const std::byte> in, int count, uint32_t kind) {
  HeadList list(partition, count, kind);
  size_t at = 0;
#define GXY_READ(type, name, sent)                                   \
  if (sent && count > 0) {                                           \
    std::memcpy(list.view_.name, in.data() + at, 4 * size_t(count)); \
    at += 4 * size_t(count);                                         \
  }
  GXY_HEAD_FIELDS(GXY_READ)
  if (kind == kMeshHeads) {
    GXY_MESH_HEAD_FIELDS(GXY_READ)
  }
#undef GXY_READ
  std::fill_n(list.view_.fresh, count, 0);
  std::fill_n(list.view_.reason, count, 0);
  return list;
}

const char* wrongCountsOf(const HeadList& heads, int i) {
  const HeadView& h = heads.view();
  if (h.steps[i] < 0) return "a head of a line has been in less than no cell";
  if (h.stalled[i] < 0 || h.stalled[i] > kMostStalled) return "a head of a line has stood still too often";
  if (h.points[i] < 0 || h.points[i] > kMostPoints) return "a head of a line has too many points";
  return nullptr;
}

const char* wrongIn(const HeadList& heads, const Extent& extent) {
  const HeadView& h = heads.view();
  for (int i = 0; i < heads.size(); i++) {
    if (h.info[i] & ~(HEAD_LINE_HIGH | HEAD_BACKWARD)) return "a head of a line has unknown flags";
    const int64_t cell[3] = {h.cellX[i], h.cellY[i], h.cellZ[i]};
    for (size_t a = 0; a < 3; a++)
      if (cell[a] < extent.first[a] || cell[a] >= extent.first[a] + extent.points[a] - 1)
        return "a head of a line is in a cell that the partition does not have";
    for (float f : {h.fx[i], h.fy[i], h.fz[i]})
      if (!(f >= 0 && f <= 1)) return "a head of a line is outside its cell";
    for (float x : {h.time[i], h.length[i], h.way[i]})
      if (!(x >= 0 && std::isfinite(x))) return "a head of a line has a time or a length below 0";
    for (float x : {h.timeRest[i], h.lengthRest[i]})
      if (!std::isfinite(x)) return "a head of a line has a time or a length that is not finite";
    if (const char* wrong = wrongCountsOf(heads, i)) return wrong;
  }
  return nullptr;
}

}  // namespace gxy
