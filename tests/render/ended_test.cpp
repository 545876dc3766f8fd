// SPDX-License-Identifier: Apache-2.0
// Scenes that are given up while they are made.
#include "tests/support/ended.h"
#include "tests/support/backends.h"
#include "tests/support/frames.h"

namespace gxy::test {
namespace {

// Everything, and geometry that takes many calls.
TestScene muchOfEverything() {
  TestScene scene = everything();
  WholeGeometry balls;
  constexpr uint64_t kBalls = 40'000;
  for (uint64_t i = 0; i < kBalls; i++) {
    const Box& d = scene.domain;
    const glm::dvec3 f{double(i) / kBalls, double(i * 7919 % kBalls) / kBalls,
                       double(i * 104729 % kBalls) / kBalls};
    balls.block.points.push_back(d.lo + f * (d.hi - d.lo));
    balls.block.ids.push_back(i);
  }
  Vis vis;
  vis.type = VisType::Particles;
  vis.dataset = "balls";
  vis.radius0 = vis.radius1 = 1e-3;
  scene.visualization.operators.push_back(vis);
  scene.data.push_back(std::make_shared<const WholeGeometry>(std::move(balls)));
  return scene;
}

TEST(EndedScenes, StopWhereverTheirProgressEndsThem) {
  const TestScene scene = muchOfEverything();
  const std::shared_ptr<const CompiledScene> before = compiledOn(whole(scene.domain), scene)[0].compiled;
  std::vector<OperatorData> data;
  for (const CompiledOperator& op : before->operators) data.push_back(op.data);
  std::shared_ptr<CompiledScene> compiled;
  const int compiling = timesEnded([&](const Advance& advance) {
    compiled = compileScene(scene.visualization, data, before->partitioning, scene.settings, {}, advance);
  });
  EXPECT_GE(compiling, 5) << "calls, in powers of 2";
  EXPECT_EQ(compiled->bytes(), before->bytes());
  std::unique_ptr<DeviceScene> device;
  const int building =
      timesEnded([&](const Advance& advance) { device = testedBackend().makeScene(compiled, 0, advance); });
  EXPECT_GE(building, 5);
  EXPECT_EQ(device->bytes(), testedBackend().makeScene(before, 0)->bytes());
}

}  // namespace
}  // namespace gxy::test
