// SPDX-License-Identifier: Apache-2.0
// Cameras that are turned about what they look at.
#include "core/scene/orbit.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "core/comm/error.h"
#include "core/scene/camera.h"

namespace gxy {
namespace {

Camera cameraAt(const glm::dvec3& viewpoint, const glm::dvec3& center) {
  Camera camera;
  camera.viewpoint = viewpoint;
  camera.viewdirection = center - viewpoint;
  return camera;
}

void expectNear(const glm::dvec3& a, const glm::dvec3& b) {
  EXPECT_LT(glm::length(a - b), 1e-12) << a.x << ' ' << a.y << ' ' << a.z;
}

TEST(Orbit, NoAnglesAreNoChangeToTheBit) {
  Camera camera = cameraAt({0.3, 0.7, 4.1}, {0.1, 0, 0});
  camera.viewup = {0.1, 3, 0.2};
  EXPECT_EQ(orbited(camera, 0, 0, {5, 6, 7}), camera);
}

TEST(Orbit, PhiTurnsToTheRightAndThetaRaises) {
  const Camera front = cameraAt({1, 2, 7}, {1, 2, 3});
  expectNear(orbited(front, 90, 0, {1, 2, 3}).viewpoint, {5, 2, 3});
  expectNear(orbited(front, 90, 0, {1, 2, 3}).viewdirection, {-4, 0, 0});
  expectNear(orbited(front, 0, 90, {1, 2, 3}).viewpoint, {1, 6, 3});
  expectNear(orbited(front, 180, 30, {1, 2, 3}).viewpoint,
             glm::dvec3(1, 2, 3) + 4.0 * glm::dvec3(0, 0.5, -std::sqrt(0.75)));
}

TEST(Orbit, ThePolesHaveAnUpOfTheirOwn) {
  const Camera front = cameraAt({0, 0, 4}, {0, 0, 0});
  for (const double phi : {0.0, 30.0, 200.0}) {
    const CameraBasis top = cameraBasis(orbited(front, phi, 90, {0, 0, 0}));
    const CameraBasis near = cameraBasis(orbited(front, phi, 89.999, {0, 0, 0}));
    EXPECT_GT(glm::dot(glm::normalize(top.dv), glm::normalize(near.dv)), 0.9999) << phi;
  }
}

TEST(Orbit, TheHorizonStaysLevelForACameraThatLooksDown) {
  const Camera down = cameraAt({0, 3, 4}, {0, 0, 0});
  for (const double phi : {45.0, 120.0, 300.0})
    EXPECT_NEAR(cameraBasis(orbited(down, phi, 10, {0, 0, 0})).du.y, 0, 1e-12) << "du is horizontal";
  expectNear(orbited(down, 90, 0, {0, 0, 0}).viewpoint, {4, 3, 0});
}

TEST(Orbit, AnUpParallelToTheViewIsReplacedFirst) {
  Camera camera = cameraAt({0, 4, 0}, {0, 0, 0});
  const Camera turned = orbited(camera, 90, 0, {0, 0, 0});
  EXPECT_NEAR(glm::length(turned.viewpoint), 4, 1e-12);
  EXPECT_THROW(orbited(cameraAt({0, 0, 0}, {0, 0, 0}), 90, 0, {0, 0, 0}), Error);
}

}  // namespace
}  // namespace gxy
