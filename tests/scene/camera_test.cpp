// SPDX-License-Identifier: Apache-2.0
#include "core/scene/camera.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <random>

#include "tests/scene/scene_test_support.h"

namespace gxy {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

double angle(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

void expectNear(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
  EXPECT_LE(glm::length(a - b), tolerance)
      << a.x << " " << a.y << " " << a.z << " / " << b.x << " " << b.y << " " << b.z;
}

TEST(Camera, CentreOfTheImageLooksAlongTheView) {
  Camera camera;
  camera.viewpoint = {1, 2, 3};
  camera.viewdirection = {3, -1, 2};
  camera.dimensions = {640, 360};
  const CameraRay ray = cameraRay(cameraBasis(camera), 320, 180);
  expectNear(ray.origin, {1, 2, 3}, 0);
  EXPECT_LT(angle(ray.direction, camera.viewdirection), 1e-15);
}

TEST(Camera, AngleOfViewSpansTheSmallerDimension) {
  for (const glm::ivec2 size : {glm::ivec2{640, 360}, glm::ivec2{360, 640}, glm::ivec2{400, 400}}) {
    for (const double aov : {1e-3, 30.0, 90.0, 179.0}) {
      Camera camera;
      camera.dimensions = size;
      camera.aov = aov;
      const CameraBasis basis = cameraBasis(camera);
      const double cx = size.x / 2.0, cy = size.y / 2.0;
      const bool wide = size.x >= size.y;
      const CameraRay a = wide ? cameraRay(basis, cx, 0) : cameraRay(basis, 0, cy);
      const CameraRay b = wide ? cameraRay(basis, cx, size.y) : cameraRay(basis, size.x, cy);
      EXPECT_NEAR(angle(a.direction, b.direction), aov * kDegree, 1e-13 * (1 + aov));
    }
  }
}

TEST(Camera, RowZeroIsTheBottomAndColumnZeroTheLeft) {
  Camera camera;  // at z = 4, looking down -z, y up
  const CameraBasis basis = cameraBasis(camera);
  const CameraRay ray = cameraRay(basis, 0.5, 0.5);
  EXPECT_LT(ray.direction.x, 0);
  EXPECT_LT(ray.direction.y, 0);
  EXPECT_DOUBLE_EQ(basis.du.y, 0);
  EXPECT_GT(basis.du.x, 0);
  EXPECT_GT(basis.dv.y, 0);
}

TEST(Camera, OrthographicWindowIsHeightUnitsOverTheSmallerDimension) {
  Camera camera;
  camera.aov = 0;
  camera.dimensions = {300, 100};
  const CameraBasis basis = cameraBasis(camera);
  EXPECT_TRUE(basis.orthographic);
  expectNear(cameraRay(basis, 0, 0).origin, {-3, -1, 4}, 1e-14);
  expectNear(cameraRay(basis, 300, 100).origin, {3, 1, 4}, 1e-14);
  expectNear(cameraRay(basis, 17, 93).direction, {0, 0, -1}, 0);
  camera.height = 10;
  expectNear(cameraRay(cameraBasis(camera), 0, 0).origin, {-15, -5, 4}, 1e-13);
}

TEST(Camera, BasisIsOrthonormalForRandomCameras) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> component(-1, 1);
  std::uniform_real_distribution<double> exponent(-150, 150);
  for (int i = 0; i < 1000; ++i) {
    Camera camera;
    const auto vector = [&] {
      return glm::dvec3(component(random), component(random), component(random)) *
             std::pow(10, exponent(random));
    };
    camera.viewdirection = vector();
    camera.viewup = vector();
    const CameraBasis b = cameraBasis(camera);
    const glm::dvec3 right = b.du / glm::length(b.du), up = b.dv / glm::length(b.dv);
    EXPECT_NEAR(glm::length(b.view), 1, 1e-15);
    EXPECT_NEAR(glm::dot(right, up), 0, 1e-12);
    EXPECT_NEAR(glm::dot(right, b.view), 0, 1e-12);
    EXPECT_NEAR(glm::dot(up, b.view), 0, 1e-12);
    expectNear(glm::cross(right, up), -b.view, 1e-12);
    EXPECT_NEAR(glm::length(b.du), glm::length(b.dv), 1e-15);
  }
}

TEST(Camera, ViewupParallelToTheViewFallsBackToTheFarthestAxis) {
  Camera camera;
  camera.viewdirection = {0, -3, 0};
  for (const glm::dvec3 up :
       {glm::dvec3{0, 1, 0}, glm::dvec3{0, -1e200, 0}, glm::dvec3{0}, glm::dvec3{1e-9, 1, 0}}) {
    camera.viewup = up;
    const CameraBasis b = cameraBasis(camera);
    expectNear(b.dv / glm::length(b.dv), {1, 0, 0}, 1e-15);
  }
}

TEST(Camera, RaysDependOnTheDirectionOfTheViewOnly) {
  Camera camera;
  camera.viewdirection = {1, 2, -2};
  const CameraBasis a = cameraBasis(camera);
  camera.viewdirection = {std::ldexp(1, 900), std::ldexp(2, 900), std::ldexp(-2, 900)};
  const CameraBasis b = cameraBasis(camera);
  EXPECT_EQ(a.corner, b.corner);
  EXPECT_EQ(a.du, b.du);
  EXPECT_EQ(a.dv, b.dv);
}

TEST(Camera, ImpossibleCamerasAreErrorsThatNameTheParameter) {
  const auto messageWith = [](auto change) {
    Camera camera;
    change(camera);
    return errorOf([&] { cameraBasis(camera); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  const auto names = [](const std::string& message, const char* key) {
    EXPECT_NE(message.find(key), std::string::npos) << message;
  };
  names(messageWith([](Camera& c) { c.viewdirection = {0, 0, 0}; }), "viewdirection");
  names(messageWith([=](Camera& c) { c.viewdirection.x = infinity; }), "viewdirection");
  names(messageWith([=](Camera& c) { c.viewpoint.y = nan; }), "viewpoint");
  names(messageWith([=](Camera& c) { c.viewup.z = nan; }), "viewup");
  for (const double aov : {-1.0, 180.0, 360.0, nan, infinity}) {
    names(messageWith([=](Camera& c) { c.aov = aov; }), "aov");
  }
  for (const double height : {0.0, -2.0, nan, infinity}) {
    names(messageWith([=](Camera& c) { c.height = height; }), "height");
  }
  for (const glm::ivec2 size :
       {glm::ivec2{0, 1}, glm::ivec2{1, -1}, glm::ivec2{65537, 1}, glm::ivec2{65536, 32769}}) {
    names(messageWith([=](Camera& c) { c.dimensions = size; }), "dimensions");
  }
  Camera largest;
  largest.dimensions = {65536, 32768};
  EXPECT_NO_THROW(cameraBasis(largest));
}

}  // namespace
}  // namespace gxy
