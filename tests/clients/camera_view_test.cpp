// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/camera_view.h"

#include <gtest/gtest.h>
#include <vtkCamera.h>
#include <vtkNew.h>

#include <glm/geometric.hpp>
#include <random>

#include "core/scene/camera.h"

namespace gxy::test {
namespace {

void expectNear(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
  EXPECT_LE(glm::distance(a, b), tolerance)
      << a.x << " " << a.y << " " << a.z << " / " << b.x << " " << b.y << " " << b.z;
}

TEST(CameraView, ToVtkAndBackTheRaysAreTheSame) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-3, 3);
  const auto vec = [&] { return glm::dvec3(number(random), number(random), number(random)); };
  for (int i = 0; i < 200; i++) {
    Camera camera;
    camera.viewpoint = vec();
    camera.viewdirection = vec();
    camera.viewup = vec();
    camera.aov = i % 3 == 0 ? 0 : 10 + 10 * (i % 12);
    camera.height = 1 + i % 5;
    camera.dimensions = i % 2 ? glm::ivec2(300, 200) : glm::ivec2(160, 250);
    vtkNew<vtkCamera> view;
    show(camera, *view);
    const Camera back = cameraOf(*view, camera.dimensions, "");
    const CameraBasis expected = cameraBasis(camera), found = cameraBasis(back);
    EXPECT_EQ(found.orthographic, expected.orthographic);
    for (const glm::dvec2 at : {glm::dvec2(0, 0), glm::dvec2(37.5, 90.5)}) {
      const CameraRay a = cameraRay(expected, at.x, at.y), b = cameraRay(found, at.x, at.y);
      expectNear(a.origin, b.origin, 1e-9);
      expectNear(glm::normalize(a.direction), glm::normalize(b.direction), 1e-9);
    }
  }
}

TEST(CameraView, VtkSeesTheWindowsWorldHeight) {
  Camera camera;  // 4 away from the origin, looking along -z
  camera.aov = 60;
  camera.dimensions = {400, 200};
  vtkNew<vtkCamera> view;
  show(camera, *view);
  EXPECT_FALSE(view->GetUseHorizontalViewAngle());  // the smaller dimension is the height
  EXPECT_DOUBLE_EQ(view->GetViewAngle(), 60);
  camera.aov = 0;
  camera.height = 2;
  camera.dimensions = {200, 400};  // 2 units over the width, so 4 over the height
  show(camera, *view);
  EXPECT_TRUE(view->GetParallelProjection());
  EXPECT_DOUBLE_EQ(view->GetParallelScale(), 2);
}

TEST(CameraView, AnUpVectorAlongTheViewIsReplacedAsTheRendererDoes) {
  Camera camera;
  camera.viewup = camera.viewdirection;
  vtkNew<vtkCamera> view;
  show(camera, *view);
  const double* up = view->GetViewUp();
  EXPECT_NEAR(glm::dot(glm::dvec3(up[0], up[1], up[2]), glm::normalize(camera.viewdirection)), 0, 1e-12);
}

}  // namespace
}  // namespace gxy::test
