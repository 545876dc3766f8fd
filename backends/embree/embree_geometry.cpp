// SPDX-License-Identifier: Apache-2.0
#include "gxy/embree/embree_geometry.h"

#include <algorithm>

#include "geometry_ispc.h"
#include "gxy/comm/thread_order.h"
#include "gxy/rays/primitive_bounds.h"

namespace gxy {

namespace {

using single::OperatorView;

void boundPrimitive(const RTCBoundsFunctionArguments* args) {
  const auto& op = *static_cast<const OperatorView*>(args->geometryUserPtr);
  const ThreadOrder order(&op);
  order.begin();
  const PrimitiveBounds box = primitiveBounds(cornersOfKind(op.kind), op.points, op.indices, args->primID);
  RTCBounds& b = *args->bounds_o;
  b.lower_x = box.lo[0], b.lower_y = box.lo[1], b.lower_z = box.lo[2];
  b.upper_x = box.hi[0], b.upper_y = box.hi[1], b.upper_z = box.hi[2];
  order.end();
}

}  // namespace

GeometryHierarchy buildGeometry(const embree::Device& device, std::span<const OperatorView> operators) {
  const int64_t before = device.bytes();
  embree::Scene scene(rtcNewScene(device.get()));
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  for (size_t i = 0; i < operators.size(); i++) {
    if (operators[i].primitives == 0) continue;
    RTCGeometry g = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_USER);
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
  device.expectDone("building the geometry");
  return {std::move(scene), size_t(std::max<int64_t>(device.bytes() - before, 0))};
}

}  // namespace gxy
