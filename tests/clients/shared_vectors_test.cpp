// SPDX-License-Identifier: Apache-2.0
// Motions of VTK's trackball and choices of the pace, as tests/vectors/ has them for the browser's page too: gui/src/view/*.test.ts
// reproduce the same numbers. Where a file has other numbers, this test leaves its own in the folder in which it runs.
#include <gtest/gtest.h>
#include <vtkCamera.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <random>

#include "core/scene/camera.h"
#include "tools/gxyviewer/camera_view.h"
#include "tools/gxyviewer/pace.h"

namespace gxy::test {
namespace {

using nlohmann::json;

constexpr double kTolerance = 1e-12;

json jsonOf(const glm::dvec3& v) { return {v.x, v.y, v.z}; }
json jsonOf(const Camera& c) {
  return {{"viewpoint", jsonOf(c.viewpoint)},
          {"viewdirection", jsonOf(c.viewdirection)},
          {"viewup", jsonOf(glm::normalize(cameraBasis(c).dv))},
          {"aov", c.aov},
          {"height", c.height}};
}

/// VTK's trackball in a window that nothing is rendered in.
class Trackball {
 public:
  explicit Trackball(const Camera& camera) : camera_(camera) {
    window_->SetOffScreenRendering(true);
    window_->SetSize(camera.dimensions.x, camera.dimensions.y);
    window_->AddRenderer(renderer_);
    interactor_->SetRenderWindow(window_);
    interactor_->EnableRenderOff();
    interactor_->SetInteractorStyle(style_);
    style_->SetCurrentRenderer(renderer_);
    show(camera, *renderer_->GetActiveCamera());
  }
  Camera after(const std::string& motion, glm::ivec2 from, glm::ivec2 to) {
    interactor_->SetEventInformation(from.x, from.y);
    interactor_->SetEventInformation(to.x, to.y);
    if (motion == "rotate") style_->Rotate();
    if (motion == "roll") style_->Spin();
    if (motion == "pan") style_->Pan();
    if (motion == "zoom") style_->Dolly();
    return cameraOf(*renderer_->GetActiveCamera(), camera_.dimensions, "");
  }

 private:
  const Camera camera_;
  vtkNew<vtkRenderer> renderer_;
  vtkNew<vtkRenderWindow> window_;
  vtkNew<vtkRenderWindowInteractor> interactor_;
  vtkNew<vtkInteractorStyleTrackballCamera> style_;
};

json trackballVectors() {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> component(-3, 3);
  // Braces fix the order in which the numbers are drawn; the arguments of a call have none.
  const auto vec = [&] { return glm::dvec3{component(random), component(random), component(random)}; };
  json cases = json::array();
  for (int i = 0; i < 40; i++) {
    Camera camera;
    camera.viewpoint = vec();
    camera.viewdirection = vec();
    camera.viewup = vec();
    camera.aov = i % 3 == 0 ? 0 : 20 + 10 * (i % 9);
    camera.height = 1 + i % 5;
    camera.dimensions = i % 2 ? glm::ivec2(400, 300) : glm::ivec2(260, 310);
    // Between two events a mouse moves a little.
    const auto number = [&](int least, int most) {
      return std::uniform_int_distribution(least, most)(random);
    };
    const glm::ivec2 from{number(60, 200), number(60, 200)};
    const glm::ivec2 to = from + glm::ivec2{number(-60, 60), number(-60, 60)};
    const std::string motion = std::array{"rotate", "roll", "pan", "zoom"}[size_t(i % 4)];
    cases.push_back({{"camera", jsonOf(camera)},
                     {"size", {camera.dimensions.x, camera.dimensions.y}},
                     {"motion", motion},
                     {"from", {from.x, from.y}},
                     {"to", {to.x, to.y}},
                     {"after", jsonOf(Trackball(camera).after(motion, from, to))}});
  }
  return cases;
}

json paceVectors() {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> exponent(-3, 0);
  json runs = json::array();
  for (int run = 0; run < 8; run++) {
    Pace pace;
    json frames = json::array();
    for (int i = 0; i < 25; i++) {
      const Detail detail = pace.choose();
      Pace::Pass pass{detail,
                      std::pow(10, exponent(random)) / detail.scale,
                      uint64_t(1e6 * std::pow(10, exponent(random))),
                      {}};
      if (i % 3) pass.bytesPerSecond = 1e8 * std::pow(10, exponent(random));
      const double resized = i % 10 == 9 ? 0.5 + 0.25 * run : 1;
      frames.push_back({{"scale", detail.scale},
                        {"quality", detail.quality},
                        {"rendering", pass.rendering},
                        {"bytes", pass.bytes},
                        {"bytesPerSecond", pass.bytesPerSecond ? json(*pass.bytesPerSecond) : json()},
                        {"resized", resized}});
      pace.take(pass);
      if (resized != 1) pace.resized(resized);
    }
    runs.push_back(std::move(frames));
  }
  return runs;
}

void expectSame(const json& found, const json& expected, const std::string& at) {
  ASSERT_EQ(found.is_structured(), expected.is_structured()) << at;
  if (found.is_number()) {
    const double a = found, b = expected;
    EXPECT_LE(std::abs(a - b), kTolerance * (1 + std::abs(b))) << at;
  } else if (!found.is_structured()) {
    EXPECT_EQ(found, expected) << at;
  } else {
    ASSERT_EQ(found.size(), expected.size()) << at;
    for (const auto& [key, value] : found.items()) {
      const json& other = found.is_array() ? expected.at(std::stoul(key)) : expected.at(key);
      expectSame(value, other, at + "/" + key);
    }
  }
}

void expectFile(const std::string& name, const json& made) {
  std::ofstream(name) << made.dump(1) << '\n';
  const std::filesystem::path path = std::filesystem::path(GALAXY_VECTORS) / name;
  ASSERT_TRUE(std::filesystem::exists(path)) << path;
  expectSame(made, json::parse(std::ifstream(path)), name);
}

TEST(SharedVectors, TheFilesHaveTheMotionsOfVtksTrackball) {
  expectFile("trackball.json", trackballVectors());
}
TEST(SharedVectors, TheFilesHaveTheChoicesOfThePace) { expectFile("pace.json", paceVectors()); }

}  // namespace
}  // namespace gxy::test
