// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/camera_view.h"

#include <vtkCamera.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "core/scene/camera.h"

namespace gxy {

namespace {

// Returns Camera::height per parallel scale. The scale is half the window's height; Camera::height spans the
// smaller dimension.
double heightPerScale(glm::ivec2 dimensions) {
  return 2.0 * std::min(dimensions.x, dimensions.y) / dimensions.y;
}

glm::dvec3 vec(const double* v) { return {v[0], v[1], v[2]}; }

}  // namespace

void show(const Camera& camera, vtkCamera& view) {
  const glm::dvec3 center = camera.viewpoint + camera.viewdirection;
  const glm::dvec3 up = glm::normalize(cameraBasis(camera).dv);  // valid even if viewup is not
  view.SetPosition(camera.viewpoint.x, camera.viewpoint.y, camera.viewpoint.z);
  view.SetFocalPoint(center.x, center.y, center.z);
  view.SetViewUp(up.x, up.y, up.z);
  view.SetParallelProjection(camera.aov == 0);
  view.SetUseHorizontalViewAngle(camera.dimensions.x < camera.dimensions.y);
  if (camera.aov > 0)
    view.SetViewAngle(camera.aov);
  else
    view.SetParallelScale(camera.height / heightPerScale(camera.dimensions));
}

Camera cameraOf(vtkCamera& view, glm::ivec2 dimensions, const std::string& annotation) {
  Camera camera;
  camera.viewpoint = vec(view.GetPosition());
  camera.viewdirection = vec(view.GetFocalPoint()) - camera.viewpoint;
  camera.viewup = vec(view.GetViewUp());
  camera.aov = view.GetParallelProjection() ? 0 : view.GetViewAngle();
  if (view.GetParallelProjection()) camera.height = view.GetParallelScale() * heightPerScale(dimensions);
  camera.dimensions = dimensions;
  camera.annotation = annotation;
  return camera;
}

}  // namespace gxy
