// SPDX-License-Identifier: Apache-2.0
// A list of rays as a structure of arrays, and its wire form.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/comm/transport.h"
#include "core/rays/ray_fields.h"

namespace gxy {

using uint32 = std::uint32_t;
using int32 = std::int32_t;

/// Pointers to the arrays of a ray list. ISPC sees the same structure.
struct RayView {
#define GXY_FIELD(type, name, primary, secondary) type* name;
  GXY_RAY_FIELDS(GXY_FIELD)
#undef GXY_FIELD
};

/// Rays that a backend keeps in its device's memory. Only the backend knows what is in it.
class DeviceRays {
 public:
  virtual ~DeviceRays() = default;
};

/// Owns the arrays of up to `capacity` rays, not initialised. Each array is 64-byte aligned and padded to a
/// multiple of 16 rays, so that a full gang may load past the end. Alternatively it names rays that a device
/// keeps: these have no arrays here, and can only be used through size(), bytes() and split(), and be given
/// back to the backend that they came from. Movable, not copyable. Not thread safe.
class RayList {
 public:
  RayList() = default;
  explicit RayList(int capacity);
  /// Rays that a device keeps, at `places` in its storage.
  RayList(std::shared_ptr<const DeviceRays> kept, std::vector<uint32_t> places);

  int size() const { return size_; }
  int capacity() const { return capacity_; }
  void resize(int n) { size_ = n; }
  const RayView& view() const { return view_; }
  /// The device's storage of the rays; null if they are here.
  const DeviceRays* kept() const { return kept_.get(); }
  std::span<const uint32_t> places() const { return places_; }
  /// Bytes of host memory: the arrays of `capacity` rays, padded, or the places of rays that a device keeps.
  int64_t bytes() const;

  /// False for primaries that came over the wire: their origins and directions must be regenerated from the
  /// camera.
  bool complete() const { return complete_; }
  void setComplete() { complete_ = true; }

  /// Copies the rays `which`, in that order. It copies the fields that travel, with origins and directions,
  /// but no fields that belong to one partition.
  RayList gather(std::span<const int> which) const;

  /// Lists of at most `size` rays each, in order.
  std::vector<RayList> split(int size) const;

  /// Bytes per ray on the wire, of primaries and of secondaries.
  static int wireBytes(bool primary);
  /// Appends the wire form of rays `which` (all primaries, or all secondaries) to `out`.
  void write(std::span<const int> which, bool primary, Bytes& out) const;
  /// Reads `count` rays; the caller has checked that `in` holds count * wireBytes(primary) bytes.
  static RayList read(std::span<const std::byte> in, int count, bool primary);

 private:
  struct Free {
    void operator()(uint32_t* p) const;
  };
  int size_ = 0, capacity_ = 0;
  bool complete_ = true;
  std::unique_ptr<uint32_t[], Free> storage_;
  RayView view_{};
  std::shared_ptr<const DeviceRays> kept_;
  std::vector<uint32_t> places_;
};

/// The contribution of one ray to one pixel, in units of 2^-26 (CONTRIBUTION_ONE).
struct Contribution {
  uint32_t pixel;
  int32_t r, g, b, a;
};

/// The distance, in world units, from the eye to the first hit of a pixel's ray.
struct DepthContribution {
  uint32_t pixel;
  double depth;
};

}  // namespace gxy
