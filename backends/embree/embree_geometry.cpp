// SPDX-License-Identifier: Apache-2.0
#include "gxy/embree/embree_geometry.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "geometry_ispc.h"
#include "gxy/comm/error.h"
#include "gxy/comm/thread_order.h"

namespace gxy {

namespace {

using single::OperatorView;

// Wide enough that no candidate is lost to rounding in Embree's traversal, whose boxes are float.
constexpr float kBoundsSlack = 2e-6f;

void primitiveBounds(const RTCBoundsFunctionArguments* args) {
  const auto& op = *static_cast<const OperatorView*>(args->geometryUserPtr);
  const ThreadOrder order(&op);
  order.begin();
  const int corners = op.kind == KIND_PARTICLES ? 1 : op.kind == KIND_PATHLINES ? 2 : 3;
  float lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (int c = 0; c < corners; c++) {
    const size_t i = corners == 1 ? args->primID : op.indices[size_t(corners) * args->primID + c];
    const float* p = op.points + 4 * i;
    const float r = std::max(p[3], 0.f);
    for (int k = 0; k < 3; k++) {
      lo[k] = std::min(lo[k], p[k] - r);
      hi[k] = std::max(hi[k], p[k] + r);
    }
  }
  float largest = 0;
  for (int k = 0; k < 3; k++) largest = std::max({largest, std::abs(lo[k]), std::abs(hi[k])});
  const float slack = largest * kBoundsSlack;
  RTCBounds& b = *args->bounds_o;
  b.lower_x = lo[0] - slack, b.lower_y = lo[1] - slack, b.lower_z = lo[2] - slack;
  b.upper_x = hi[0] + slack, b.upper_y = hi[1] + slack, b.upper_z = hi[2] + slack;
  order.end();
}

bool countBytes(void* sum, ssize_t bytes, bool) {
  ThreadOrder(sum).begin();
  *static_cast<std::atomic<int64_t>*>(sum) += bytes;
  return true;
}

}  // namespace

DevicePtr makeDevice() {
  RTCDevice device = rtcNewDevice(nullptr);
  if (!device)
    throw Error("Embree: no device (error " + std::to_string(int(rtcGetDeviceError(nullptr))) + ")");
  const auto bytes = std::make_shared<std::atomic<int64_t>>(0);
  ThreadOrder(bytes.get()).handOver();
  rtcSetDeviceMemoryMonitorFunction(device, countBytes, bytes.get());
  return DevicePtr(device, ReleaseDevice{bytes});
}

int64_t bytesOf(const DevicePtr& device) { return *std::get_deleter<ReleaseDevice>(device)->bytes; }

ScenePtr buildGeometry(RTCDevice device, std::span<const OperatorView> operators) {
  bool any = false;
  for (const OperatorView& op : operators) any = any || op.primitives > 0;
  if (!any) return nullptr;
  ScenePtr scene(rtcNewScene(device));
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  for (size_t i = 0; i < operators.size(); i++) {
    if (operators[i].primitives == 0) continue;
    RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    ThreadOrder(&operators[i]).handOver();  // Embree's builder asks for bounds on threads of its own
    rtcSetGeometryUserPrimitiveCount(g, operators[i].primitives);
    rtcSetGeometryUserData(g, const_cast<OperatorView*>(&operators[i]));
    rtcSetGeometryBoundsFunction(g, primitiveBounds, nullptr);
    rtcSetGeometryIntersectFunction(g, reinterpret_cast<RTCIntersectFunctionN>(ispc::intersectCallback()));
    rtcSetGeometryOccludedFunction(g, reinterpret_cast<RTCOccludedFunctionN>(ispc::occludeCallback()));
    rtcCommitGeometry(g);
    rtcAttachGeometryByID(scene.get(), g, unsigned(i));
    rtcReleaseGeometry(g);
  }
  rtcCommitScene(scene.get());
  for (const OperatorView& op : operators) ThreadOrder(&op).takeBack();
  const RTCError error = rtcGetDeviceError(device);
  if (error != RTC_ERROR_NONE)
    throw Error("Embree: building the geometry failed (error " + std::to_string(int(error)) +
                (error == RTC_ERROR_OUT_OF_MEMORY ? ", out of memory)" : ")"));
  return scene;
}

}  // namespace gxy
