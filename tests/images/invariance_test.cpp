// SPDX-License-Identifier: Apache-2.0
// One scene gives one picture, bit for bit, however it is cut, spread, scheduled and packed (architecture.md, promise 1).
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/backends.h"
#include "tests/support/frames.h"

namespace gxy::test {
namespace {

class Invariance : public testing::TestWithParam<TestScene> {};

std::string nameOf(const testing::TestParamInfo<TestScene>& info) {
  std::string name;
  bool capital = true;
  for (char c : info.param.name) {
    if (c != ' ') name += capital ? char(std::toupper(c)) : c;
    capital = c == ' ';
  }
  return name;
}

std::vector<TestScene> allScenes() {
  std::vector<TestScene> scenes = scenesOfEachKind();
  scenes.push_back(everything());
  for (TestScene& scene : scenes) scene.camera.dimensions = affordable(scene.camera.dimensions);
  return scenes;
}

/// How rays travel is the same on every backend, so the reference, which is fast, has most of the cuts and schedules. On another
/// one the commit and the scene decide which two cuts they are.
bool isTaken(size_t cut, size_t cuts, const std::string& scene) {
  if (onReference() || allIsAsked()) return true;
  const size_t half = cuts / 2, first = (seedOfTheCommit() + scene.size()) % half;
  return cut == 2 * first || cut == 2 * ((first + 2) % half);
}

TEST_P(Invariance, PictureHasSomethingInIt) {
  const Picture p = wholeOnTested(GetParam());
  size_t seen = 0;
  for (size_t i = 0; i < p.rgba.size(); i += 4) seen += p.rgba[i] != 0.1f;
  EXPECT_GT(seen, p.rgba.size() / 4 / 20);
}

TEST_P(Invariance, OfPartitions) {
  const TestScene& scene = GetParam();
  const Picture expected = wholeOnTested(scene);
  const std::vector<Cut> cuts = manyCuts(scene.domain, 11);
  for (size_t i = 0; i < cuts.size(); i++) {
    if (!isTaken(i, cuts.size(), scene.name)) continue;
    EXPECT_EQ(difference(expected, render(scene, cuts[i]), Sameness::Bits), "") << cuts[i].name;
  }
}

TEST_P(Invariance, OfPacketsAndBudget) {
  const TestScene& scene = GetParam();
  const Picture expected = wholeOnTested(scene);
  const Cut cut = kdCut(scene.domain, 6, 3, 5);
  const auto compiled = compiledOn(cut, scene);
  for (const Renderer::Options& options : {Renderer::Options{16, 1 << 20}, {64, 1}, {1024, 1}, {100, 5000}}) {
    FrameRun run;
    run.options = options;
    EXPECT_EQ(difference(expected, render(scene, cut.ranks, compiled, run), Sameness::Bits), "")
        << "packets of " << options.packetRays << ", " << options.raysInFlight << " in flight";
  }
}

TEST_P(Invariance, OfThreads) {
  const TestScene& scene = GetParam();
  const Picture expected = wholeOnTested(scene);
  const Cut cut = lattice(scene.domain, {2, 2, 1}, 2);
  const auto compiled = compiledOn(cut, scene);
  for (int workers : {1, 2}) {
    FrameRun run;
    run.threaded = true;
    run.workers = workers;
    run.options.packetRays = 64;
    EXPECT_EQ(difference(expected, render(scene, cut.ranks, compiled, run), Sameness::Bits), "")
        << workers << " threads";
  }
}

TEST_P(Invariance, OfSchedules) {
  TestScene scene = GetParam();
  const uint64_t schedules = !onReference() ? 3 : scene.name == "everything" ? 60 : 10;
  scene.camera.dimensions = affordable({12, 10});
  const Picture expected = wholeOnTested(scene);
  for (const Cut& cut : {kdCut(scene.domain, 7, 4, 3), lattice(scene.domain, {2, 2, 2}, 8)}) {
    const auto compiled = compiledOn(cut, scene);
    for (uint64_t seed = 1; seed <= schedules; seed++) {
      FrameRun run;
      run.seed = seed;
      run.options.packetRays = 16;
      run.options.raysInFlight = seed % 2 ? 1 : 1 << 20;
      ASSERT_EQ(difference(expected, render(scene, cut.ranks, compiled, run), Sameness::Bits), "")
          << cut.name << ", schedule " << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Invariance, testing::ValuesIn(allScenes()), nameOf);

}  // namespace

void PrintTo(const TestScene& scene, std::ostream* out) { *out << scene.name; }

}  // namespace gxy::test
