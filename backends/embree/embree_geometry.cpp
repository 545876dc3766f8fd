// SPDX-License-Identifier: Apache-2.0
#include "gxy/embree/embree_geometry.h"

#include <string>

#include "geometry_ispc.h"
#include "gxy/comm/error.h"
#include "gxy/comm/thread_order.h"
#include "gxy/rays/primitive_bounds.h"

namespace gxy {

namespace {

using single::OperatorView;

void boundPrimitive(const RTCBoundsFunctionArguments* args) {
  const auto& op = *static_cast<const OperatorView*>(args->geometryUserPtr);
  const ThreadOrder order(&op);
  order.begin();
  const int corners = op.kind == KIND_PARTICLES ? 1 : op.kind == KIND_PATHLINES ? 2 : 3;
  const PrimitiveBounds box = primitiveBounds(corners, op.points, op.indices, args->primID);
  RTCBounds& b = *args->bounds_o;
  b.lower_x = box.lo[0], b.lower_y = box.lo[1], b.lower_z = box.lo[2];
  b.upper_x = box.hi[0], b.upper_y = box.hi[1], b.upper_z = box.hi[2];
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
    rtcSetGeometryBoundsFunction(g, boundPrimitive, nullptr);
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
