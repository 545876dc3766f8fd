// SPDX-License-Identifier: Apache-2.0
#include "core/comm/error.h"
#include "core/scene/camera.h"
#include "core/scene/paraview_camera.h"
#include "core/scene/schema.h"

namespace gxy {
namespace {

void readCenter(const Found& found, Camera& camera) {
  const glm::dvec3 center = found.vec3();
  if (found.object.find("viewdirection")) return found.warn("not used, as `viewdirection` is given");
  camera.viewdirection = center - camera.viewpoint;
}

Camera readCameraFile(const Found& found) {
  ReadContext& context = found.context;
  const std::string& name = found.text();
  try {
    auto known = context.cameras.find(name);
    if (known == context.cameras.end())
      known = context.cameras.emplace(name, parseParaViewCamera(context.contentOf(name), name)).first;
    return known->second;
  } catch (const Error& e) {
    context.fail(found.value.at, "camera file: " + std::string(e.what()));
  }
}

}  // namespace

const Schema<Camera>& cameraSchema() {
  static const Schema<Camera> schema{
      "camera",
      {
          vectorKey("viewpoint", &Camera::viewpoint, "Where the eye is, world."),
          vectorKey("viewdirection", &Camera::viewdirection, "Where it looks; any length but 0.")
              .byDefault("`[0.0, 0.0, -1.0]`; required with `viewpoint`, unless there is `viewcenter`"),
          customKey<Camera>("viewcenter", "[x, y, z]", "Instead of `viewdirection`: a point to look at.",
                            readCenter)
              .byDefault("-"),
          vectorKey("viewup", &Camera::viewup, "What is up in the picture; any length."),
          numberKey("aov", &Camera::aov, {0, 180, false, true},
                    "Full angle of view over the smaller image dimension, degrees; 0: orthographic."),
          numberKey("height", &Camera::height, kPositive,
                    "Orthographic only: extent of the window over the smaller image dimension, world units."),
          customKey<Camera>(
              "dimensions", "[width, height], integers 1 to 65536",
              "Image size in pixels, at most 2^31 in all.",
              [](const Found& found, Camera& camera) { camera.dimensions = found.imageSize(); },
              [](const Camera& c) {
                return OrderedJson{c.dimensions.x, c.dimensions.y};
              }),
          customKey<Camera>(
              "fit", "true or false",
              "The viewpoint (orthographic: `height`, too) is chosen so that the data fill the picture, seen "
              "along "
              "`viewdirection`; `viewpoint` is not used.",
              [](const Found& found, Camera& camera) { camera.fit = found.boolean(); },
              [](const Camera& c) { return c.fit ? OrderedJson(true) : OrderedJson(); })
              .byDefault("`false`"),
          textKey("annotation", &Camera::annotation,
                  "Becomes part of the picture's name, as PREFIX_00000_annotation.png."),
      }};
  return schema;
}

Camera readCamera(const Found& found) {
  Camera camera;
  if (found.value.string()) {
    camera = readCameraFile(found);
  } else {
    readObject(found.context, found.value, cameraSchema(), camera);
    const bool aimed = found.value.find("viewdirection") || found.value.find("viewcenter");
    if (found.value.find("viewpoint") && !aimed) {
      found.context.fail(found.value.at,
                         "a camera without direction; expected `viewdirection` or `viewcenter`");
    }
  }
  try {
    validate(camera);
  } catch (const Error& e) {
    found.context.fail(found.value.at, e.what());
  }
  return camera;
}

}  // namespace gxy
