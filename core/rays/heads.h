// SPDX-License-Identifier: Apache-2.0
// Heads of lines as a structure of arrays, and their wire form. A head is the end of a line that is being
// traced; it has all that is needed to go on with the same bits wherever it is.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/comm/transport.h"
#include "core/data/volume.h"
#include "core/rays/head_fields.h"
#include "core/rays/ray_list.h"

namespace gxy {

/// What kind of field heads go through.
enum HeadKind : uint32_t { kGridHeads, kMeshHeads, kHeadKinds };

/// Pointers to the arrays of a list of heads. ISPC sees the same structure without the fields of meshes, which are null
/// in a list of another kind.
struct HeadView {
#define GXY_FIELD(type, name, sent) type* name;
  GXY_HEAD_FIELDS(GXY_FIELD)
  GXY_MESH_HEAD_FIELDS(GXY_FIELD)
#undef GXY_FIELD
};

/// The largest number that a line can have: 40 bits.
inline constexpr uint64_t kLastLine = (uint64_t(1) << 40) - 1;
/// The most points that a head can store.
inline constexpr int32_t kMostPoints = 1 << 24;
/// The largest value of a head's `stalled`: its trial steps in a cell, times 16, and crossings (kernels/advect.h).
inline constexpr int32_t kMostStalled = (1 << 20) + 31;

/// Owns the arrays of heads in one partition. Each array is 64-byte aligned and padded to a multiple of 16
/// heads, so that a full gang may load past the end. It is an ItemList (core/render/flight.h) of a HeadKind.
/// Movable, not copyable. Not thread safe.
class HeadList {
 public:
  HeadList() = default;
  /// `size` heads, not initialised.
  HeadList(int partition, int size, uint32_t kind = kGridHeads);

  int partition = 0;
  uint32_t kind() const { return kind_; }
  int size() const { return size_; }
  const HeadView& view() const { return view_; }
  /// Bytes of memory, padding included.
  int64_t bytes() const;

  uint64_t line(int i) const { return view_.line[i] | uint64_t(view_.info[i] & HEAD_LINE_HIGH) << 32; }
  bool backward(int i) const { return (view_.info[i] & HEAD_BACKWARD) != 0; }
  /// Makes head i a new one with nothing behind it; all but its line and its direction are 0.
  void clear(int i, uint64_t line, bool backward);
  /// The same at a place of a grid.
  void start(int i, uint64_t line, bool backward, const Index3& cell, const float (&fraction)[3]);

  /// Copies the heads `which`, in that order, into a list of another partition.
  HeadList gather(int partition, std::span<const int> which) const;
  /// Lists of at most `most` heads each, in order.
  std::vector<HeadList> split(int most) const;
  /// Appends size() * wireBytes(kind()) bytes: one field after the other.
  void write(Bytes& out) const;
  /// Bytes of one head on the wire; 0: there is no such kind.
  static int wireBytes(uint32_t kind);
  /// Reads `count` heads; the caller has checked that `in` holds count * wireBytes(kind) bytes, and then asks
  /// wrongIn().
  static HeadList read(int partition, std::span<const std::byte> in, int count, uint32_t kind = kGridHeads);

 private:
  struct Free {
    void operator()(uint32_t* p) const;
  };
  int size_ = 0;
  uint32_t kind_ = kGridHeads;
  std::unique_ptr<uint32_t[], Free> storage_;
  HeadView view_{};
};

/// Checks heads of a grid that came in a message; `extent` is that of the partition's block. Returns what is wrong with
/// the first bad head (a static text), or null if all are good.
const char* wrongIn(const HeadList& heads, const Extent& extent);
/// The same for what heads of any kind have: returns what is wrong with the counts of head i, or null.
const char* wrongCountsOf(const HeadList& heads, int i);

}  // namespace gxy
