// SPDX-License-Identifier: Apache-2.0
// A program outside Galaxy's tree, with the installed headers and libraries only: two ranks in one process, with half
// of the space each, render a ball that the border cuts. Files come and go by the plugins of the installed Galaxy.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "backends/embree/embree_backend.h"
#include "core/comm/in_process.h"
#include "core/image/image.h"
#include "core/io/geometry_file.h"
#include "core/io/write_geometry.h"
#include "core/render/renderer.h"

namespace {

constexpr int kRanks = 2, kPixels = 64;
constexpr double kRadius = 0.5, kWindow = 2;
const glm::dvec3 kColor(0.75, 0.5, 0.25);

std::shared_ptr<const gxy::Geometry> ball(int rank) {
  gxy::Geometry geometry;
  geometry.kind = gxy::GeometryKind::Particles;
  geometry.box.extend(glm::dvec3(0));
  geometry.primitives = 1;
  geometry.blocks[rank] = {.points = {glm::dvec3(0)}, .ids = {0}};  // partition `rank`; the ball touches both
  return std::make_shared<gxy::Geometry>(geometry);
}

gxy::Visualization unlit() {
  gxy::Visualization visualization;
  visualization.lighting.Ka = 1;
  visualization.lighting.Kd = 0;
  visualization.operators.resize(1);
  visualization.operators[0].type = gxy::VisType::Particles;
  visualization.operators[0].radius0 = kRadius;
  return visualization;
}

gxy::Picture render() {
  const auto halves = std::make_shared<gxy::Partitioning>(
      gxy::Partitioning::lattice({{{-1, 0, 1}, {-1, 1}, {-1, 1}}}, kRanks));
  const auto backend = gxy::makeEmbreeBackend();
  gxy::Picture picture;
  gxy::InProcessWorld world(kRanks, 1);
  std::vector<std::unique_ptr<gxy::Renderer>> renderers;
  for (int rank = 0; rank < kRanks; rank++) {
    const auto scene = gxy::compileScene(unlit(), {{.geometry = ball(rank), .color = kColor}}, halves, {});
    scene->visible.assign(kRanks, 1);
    auto& renderer =
        *renderers.emplace_back(std::make_unique<gxy::Renderer>(world.rank(rank), gxy::Renderer::Options{}));
    renderer.addScene(1, scene, backend->makeScene(scene, rank));
    renderer.onPicture([&](gxy::FrameId, const gxy::FrameRequest&, gxy::Picture p) { picture = p; });
  }
  gxy::FrameRequest request{.scene = 1};
  request.camera.aov = 0;  // orthographic
  request.camera.height = kWindow;
  request.camera.dimensions = {kPixels, kPixels};
  renderers[0]->render(request, [](gxy::FrameId, const gxy::Renderer::Ending&) {});
  world.run();
  return picture;
}

bool filesComeBack() {
  const gxy::Image image{1, 2, {0.25f, 0.5f, 1, 1, 0, 0, 0, 0.5f}};
  gxy::writeImage("consumer.exr", image);
  if (gxy::readImage("consumer.exr").rgba != image.rgba) return false;
  gxy::writeGeometry("consumer.vtp", ball(0)->blocks.at(0), gxy::GeometryKind::Particles);
  return gxy::summariseGeometry("consumer.vtp").points == 1;
}

}  // namespace

int main() {
  if (!filesComeBack()) {
    std::printf("a picture or points are not what was written\n");
    return 1;
  }
  const gxy::Picture picture = render();
  int covered = 0;
  for (size_t i = 0; i + 3 < picture.rgba.size(); i += 4) {
    const float* pixel = &picture.rgba[i];
    if (pixel[0] == 0 && pixel[1] == 0 && pixel[2] == 0) continue;
    for (int c = 0; c < 3; c++)
      if (std::abs(pixel[c] - kColor[c]) > 1e-4) {
        std::printf("channel %d is %g, expected %g\n", c, pixel[c], kColor[c]);
        return 1;
      }
    covered++;
  }
  const double radius = kRadius / kWindow * kPixels, expected = std::numbers::pi * radius * radius;
  std::printf("the ball covers %d pixels; a disc of its size has %.1f\n", covered, expected);
  const bool right = std::abs(covered - expected) < radius;  // pixel centres count a disc this closely
  return right ? 0 : 1;
}
