// SPDX-License-Identifier: Apache-2.0
// The one place where C++ meets Embree (3.13; another major version is a change in this file and embree.isph).
#pragma once
#include <embree3/rtcore.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>

#include "gxy/kernels/single_views.h"

namespace gxy {

struct ReleaseScene {
  void operator()(RTCScene s) const { rtcReleaseScene(s); }
};
struct ReleaseDevice {
  std::shared_ptr<std::atomic<int64_t>> bytes;  ///< that Embree has allocated for the device and its scenes
  void operator()(RTCDevice d) const { rtcReleaseDevice(d); }
};
using ScenePtr = std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene>;
using DevicePtr = std::shared_ptr<std::remove_pointer_t<RTCDevice>>;

/// Throws Error if Embree does not start.
DevicePtr makeDevice();

/// Memory of Embree's own for a device and all of its scenes.
int64_t bytesOf(const DevicePtr& device);

/// A bounding volume hierarchy over all geometry operators of a partition, whose ids are the operators' indices; null if
/// none has primitives. `operators` must outlive it and not move.
ScenePtr buildGeometry(RTCDevice device, std::span<const single::OperatorView> operators);

}  // namespace gxy
