// SPDX-License-Identifier: Apache-2.0
// The only file that includes Embree (3.13 is tested), and the owners of its handles. Another major version
// needs a change here and of GALAXY_EMBREE in CMakeLists.txt. Those who include this call the builder
// themselves; versions 3 and 4 share its calls.
#pragma once
#include <embree3/rtcore.h>

#include <cstdint>
#include <memory>
#include <string>

#include "core/comm/error.h"

namespace gxy::embree {

struct Release {
  void operator()(RTCDevice d) const { rtcReleaseDevice(d); }
  void operator()(RTCBVH b) const { rtcReleaseBVH(b); }
};
/// A handle that is released when it goes out of scope.
template <class Handle>
using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Release>;
using Bvh = Owned<RTCBVH>;

inline std::string version() {
  return std::to_string(RTC_VERSION_MAJOR) + "." + std::to_string(RTC_VERSION_MINOR) + "." +
         std::to_string(RTC_VERSION_PATCH);
}

/// A device of Embree. Builders of a device must not outlive it.
class Device {
 public:
  /// Throws Error if Embree does not start.
  Device() : handle_(rtcNewDevice(nullptr)) {
    if (!handle_)
      throw Error("Embree: no device (error " + std::to_string(int(rtcGetDeviceError(nullptr))) + ")");
  }

  RTCDevice get() const { return handle_.get(); }

  /// Throws Error if a call on this thread has failed; `what` says what was done ("building the geometry").
  void expectDone(const std::string& what) const {
    const RTCError error = rtcGetDeviceError(handle_.get());
    if (error != RTC_ERROR_NONE)
      throw Error("Embree: " + what + " failed (error " + std::to_string(int(error)) +
                  (error == RTC_ERROR_OUT_OF_MEMORY ? ", out of memory)" : ")"));
  }

 private:
  Owned<RTCDevice> handle_;
};

}  // namespace gxy::embree
