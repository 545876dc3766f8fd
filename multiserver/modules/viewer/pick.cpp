// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/viewer/pick.h"

#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <glm/geometric.hpp>

#include "core/comm/error.h"
#include "core/scene/camera.h"
#include "multiserver/modules/viewer/surface_at.h"

namespace gxy::viewer {

using nlohmann::json;

namespace {

constexpr double kMiss = 1e30;  // the depth of a pixel where no surface is

json jsonOf(const glm::dvec3& v) { return {v.x, v.y, v.z}; }
glm::dvec3 vectorOf(const json& j) {
  return {j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>()};
}

json jsonOf(const SurfaceAt& at) {
  return {{"distance", at.distance},
          {"operator", at.vis},
          {"id", at.id},
          {"value", at.value},
          {"normal", jsonOf(at.normal)}};
}

SurfaceAt surfaceOf(const json& j) {
  const json& value = j.at("value");  // NaN arrives as null
  return {j.at("distance"), j.at("operator"), j.at("id"),
          value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>(),
          vectorOf(j.at("normal"))};
}

/// A camera of one pixel that looks along a ray.
Camera alongRay(const Camera& camera, const CameraRay& ray) {
  Camera one = camera;
  one.viewpoint = ray.origin;
  one.viewdirection = ray.direction;
  one.dimensions = {1, 1};
  return one;
}

/// Renders the one pixel; how far its first surface is.
double depthOf(Services& services, Request& request, const SceneCache::Pinned& shown, const Camera& one) {
  struct Answer {
    std::mutex mutex;
    std::condition_variable changed;
    bool done = false;
    std::string error;
    double depth = kMiss;
    Tenants::RenderSlot slot;
  };
  const auto answer = std::make_shared<Answer>();
  const std::string tenant = request.session().tenant();
  ServerRank& serverRank = services.serverRank;
  answer->slot = serverRank.tenants.begin(tenant, serverRank.costOf(tenant, one.dimensions));
  FrameRequest frame;
  frame.scene = shown.scene->id;
  frame.camera = one;
  frame.samples = 1;
  frame.priority = {serverRank.tenants.number(tenant), true};
  frame.account = tenant;
  PictureFormat wanted;
  wanted.as = PictureFormat::As::Depth;
  PictureReceiver receiver;
  receiver.depth = [answer](const std::vector<double>& depth) {
    const std::lock_guard lock(answer->mutex);
    answer->depth = depth.at(0);
  };
  receiver.done = [answer, tenant, &services](bool, const std::string& error) {
    answer->slot = {};
    services.retries.onEnd(tenant);
    const std::lock_guard lock(answer->mutex);
    answer->error = error;
    answer->done = true;
    answer->changed.notify_all();
  };
  const FrameId id = services.pictures.start(frame, wanted, std::move(receiver));
  const std::shared_ptr<void> end(nullptr, [&](void*) { serverRank.renderer.supersede(id); });
  std::unique_lock lock(answer->mutex);
  while (!answer->changed.wait_for(lock, std::chrono::milliseconds(20), [&] { return answer->done; })) {
    lock.unlock();
    request.check();
    lock.lock();
  }
  if (!answer->error.empty()) throw Error(answer->error);
  return answer->depth;
}

std::string textOf(const json& hit) {
  char text[200];
  const json &p = hit["point"], &value = hit["value"];
  std::snprintf(text, sizeof text, "%.6g %.6g %.6g", p[0].get<double>(), p[1].get<double>(),
                p[2].get<double>());
  std::string said = "operator " + std::to_string(hit["operator"].get<int>() + 1) + ", " +
                     hit["type"].get<std::string>() + " " + hit["dataset"].get<std::string>() + ", at " +
                     text;
  if (value.is_null()) return said;
  std::snprintf(text, sizeof text, ": %.6g", value.get<double>());
  return said + text;
}

}  // namespace

void registerPick(Registration& registration, Services& services) {
  registration.work(
      "viewer.surface_at",
      [&services](const Work::Call& call) -> json {
        const auto scene = services.scenes.compiled(call.parameters.at("scene").get<SceneId>());
        const auto at = surfaceAt(*scene, vectorOf(call.parameters.at("point")));
        return at ? jsonOf(*at) : json();
      },
      Work::Runs::Long);
}

json pick(Services& services, Request& request, Window& window, glm::ivec2 pixel) {
  const Window::View view = window.view(askerOf(request));
  const glm::ivec2 size = view.camera.dimensions;
  if (pixel.x < 0 || pixel.y < 0 || pixel.x >= size.x || pixel.y >= size.y)
    throw Error("pick: pixel " + std::to_string(pixel.x) + " " + std::to_string(pixel.y) +
                ": expected one of 0 0 to " + std::to_string(size.x - 1) + " " + std::to_string(size.y - 1));
  CameraRay ray = cameraRay(cameraBasis(view.camera), pixel.x + 0.5, pixel.y + 0.5);
  ray.direction = glm::normalize(ray.direction);
  const double depth = depthOf(services, request, view.pinned, alongRay(view.camera, ray));
  if (depth >= kMiss) return {{"hit", false}, {"text", "there is no surface"}};
  const glm::dvec3 point = ray.origin + depth * ray.direction;
  std::optional<SurfaceAt> nearest;
  for (const json& found : services.serverRank.callAll(
           "viewer.surface_at", {{"scene", view.pinned.scene->id}, {"point", jsonOf(point)}}))
    if (!found.is_null())
      if (const SurfaceAt at = surfaceOf(found); !nearest || at < *nearest) nearest = at;
  if (!nearest) throw Error("pick: no rank has a surface where the ray ends");
  constexpr const char* kTypes[] = {"Volume", "Particles", "PathLines", "Triangles"};
  const Vis& vis = view.visualization.operators.at(size_t(nearest->vis));
  const bool away = glm::dot(nearest->normal, ray.direction) > 0;
  json hit{{"hit", true},
           {"point", jsonOf(point)},
           {"operator", nearest->vis},
           {"type", kTypes[size_t(vis.type)]},
           {"dataset", vis.dataset},
           {"value", std::isnan(nearest->value) ? json() : json(nearest->value)},
           {"normal", jsonOf(away ? -nearest->normal : nearest->normal)}};
  hit["text"] = textOf(hit);
  return hit;
}

}  // namespace gxy::viewer
