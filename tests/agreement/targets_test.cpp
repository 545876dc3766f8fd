// SPDX-License-Identifier: Apache-2.0
// ISPC targets against each other: whole pictures, bit for bit.
#include <gtest/gtest.h>

#include <cstring>
#include <iostream>

#include "tests/agreement/backend.h"
#include "tests/agreement/draw.h"

std::unique_ptr<gxy::Backend> makeBackend_sse4();
std::unique_ptr<gxy::Backend> makeBackend_avx2();
std::unique_ptr<gxy::Backend> makeBackend_avx512skx();

namespace gxy::agreement {
namespace {

struct Target {
  const char* name;
  const char* gang;  ///< as device() tells it
  bool supported;
  std::unique_ptr<Backend> (*make)();
};

/// Pixels, channels and depths that differ in any bit.
int differences(const Picture& a, const Picture& b) {
  int count = 0;
  for (size_t i = 0; i < a.rgba.size(); i++) count += std::memcmp(&a.rgba[i], &b.rgba[i], sizeof(float)) != 0;
  for (size_t i = 0; i < a.depth.size(); i++)
    count += std::memcmp(&a.depth[i], &b.depth[i], sizeof(double)) != 0;
  return count;
}

std::vector<TestScene> scenes() {
  std::vector<TestScene> all{everything(56)};
  TestScene& spiky = all.emplace_back(sceneFrom("spiky", {2.1, 1.4, 3.3}, 64, 64));
  spiky.add(rendered({{-1, 0}, {-0.3, 0.1}, {-0.3, 0.8}, {-0.2, 0}, {0.21, 0.5}, {0.22, 0}}, -1, 1), wavy());
  TestScene& ramps = all.emplace_back(sceneFrom("ramps", {2.1, 1.4, 3.3}, 64, 64));  // more than 16 intervals
  std::vector<OpacityPoint> sawtooth;
  for (int i = 0; i < 24; i++) sawtooth.push_back({-0.9 + 0.075 * i, i % 2 ? 0.2 : 0.02});
  ramps.add(rendered(sawtooth, -1, 1), wavy());
  TestScene& iso = all.emplace_back(sceneFrom("iso", {0.5, 1, 4}, 96, 96));
  Vis vis = surfaces(VisType::Volume);
  vis.isovalues = {0.3, 0.5};
  vis.opacity = 0.5;
  iso.add(vis, makeVolume(cube(41), marschnerLobb));
  TestScene& solid = all.emplace_back(solids("solids", 96));
  solid.visualization.lighting = lit({kSun, kNearLamp}, true);
  solid.visualization.lighting.aoCount = 3;
  return all;
}

TEST(Targets, PicturesHaveIdenticalBits) {
  const Target targets[] = {{"sse4-i32x4", " 4 rays", true, makeBackend_sse4},
                            {"avx2-i32x8", " 8 rays", __builtin_cpu_supports("avx2") != 0, makeBackend_avx2},
                            {"avx512skx-x16", " 16 rays",
                             __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
                                 __builtin_cpu_supports("avx512dq"),
                             makeBackend_avx512skx}};
  std::vector<std::unique_ptr<Backend>> backends;
  for (const Target& t : targets) {
    if (!t.supported) {
      std::cout << "not on this machine: " << t.name << '\n';
      continue;
    }
    backends.push_back(t.make());
    EXPECT_NE(backends.back()->device().find(t.gang), std::string::npos)
        << t.name << " is " << backends.back()->device();
  }
  for (const TestScene& scene : scenes()) {
    const Picture dispatched = draw(embree(), scene);
    for (const auto& backend : backends)
      EXPECT_EQ(differences(dispatched, draw(*backend, scene)), 0) << scene.name << ": " << backend->device();
  }
}

TEST(Targets, ThePacketsThatRaysTravelInDoNotShow) {
  for (const TestScene& scene : scenes()) {
    const Picture whole = draw(embree(), scene);
    for (int packet : {16, 100})
      EXPECT_EQ(differences(whole, draw(embree(), scene, 0, packet)), 0) << scene.name << packet;
  }
}

}  // namespace
}  // namespace gxy::agreement
