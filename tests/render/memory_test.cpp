// SPDX-License-Identifier: Apache-2.0
// What a Renderer enters into the ledger, by arithmetic.
#include <gtest/gtest.h>

#include "core/render/tiles.h"
#include "tests/support/frames.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

std::map<std::string, int64_t> byPurpose(const std::vector<Ledger::Line>& lines) {
  std::map<std::string, int64_t> bytes;
  for (const Ledger::Line& line : lines) bytes[line.purpose] += line.bytes;
  return bytes;
}

TestScene everything(glm::ivec2 size) {
  TestScene s = emptyScene("memory", size);
  addSmoothVolume(s);
  addParticles(s, 0.5);
  addLights(s);
  return s;
}

TEST(RendererMemory, OfFramesIsBackAtZeroOnceTheyAreOver) {
  const TestScene scene = everything({20, 18});
  const Cut cut = lattice(sceneDomain(), {2, 2, 1}, 4);
  const auto compiled = compiledOn(cut, scene);
  for (const int64_t raysInFlight : {int64_t(1), int64_t(1) << 20})
    for (uint64_t seed = 1; seed <= uint64_t(seeds(10)); seed++) {
      Ledger ledger;  // of all ranks
      FrameRun run;
      run.seed = seed;
      run.options.raysInFlight = raysInFlight;
      run.options.ledger = &ledger;
      run.options.ranksPerPart = 1 + int(seed % 4);
      Frames frames(cut.ranks, run);
      frames.add(1, compiled);
      for (int i = 0; i < 4; i++) frames.start(requestOf(scene));
      frames.run();
      ASSERT_TRUE(frames.errors().empty()) << frames.errors()[0];
      EXPECT_EQ(ledger.snapshot(), std::vector<Ledger::Line>{}) << "schedule " << seed;
      const auto peaks = byPurpose(ledger.peaks());
      for (const char* purpose : {"rays", "framebuffer", "picture", "tiles"})
        EXPECT_GT(peaks.count(purpose), 0u) << purpose << " never used memory, schedule " << seed;
    }
}

TEST(RendererMemory, OfFramebuffersAndPicturesIsTheirSizeInPixels) {
  const TestScene scene = everything({50, 30});
  const Cut cut = whole(sceneDomain());
  Ledger ledger;
  FrameRun run;
  run.options.ledger = &ledger;
  Frames frames(cut.ranks, run);
  frames.add(1, compiledOn(cut, scene));
  frames.start(requestOf(scene));
  frames.run();
  const auto peaks = byPurpose(ledger.peaks());
  EXPECT_EQ(peaks.at("framebuffer"), 50 * 30 * (32 + 8));
  EXPECT_EQ(peaks.at("picture"), 50 * 30 * (16 + 8));
  EXPECT_EQ(peaks.at("tiles"), 2 * int64_t(sizeof(SpawnTile)));
}

// A tile's primaries and the secondaries that its credits reserve: with a budget of one, no more is ever held.
TEST(RendererMemory, OfRaysIsBoundedByTheBudget) {
  TestScene scene = emptyScene("memory", {128, 128});
  addParticles(scene, 1);
  addLights(scene);
  const Cut cut = lattice(sceneDomain(), {2, 1, 1}, 2);
  const auto compiled = compiledOn(cut, scene);
  const int side = tileSide(1, 1);
  const int64_t tile = RayList(side * side).bytes();
  for (uint64_t seed = 1; seed <= 5; seed++) {
    Ledger ledger;
    FrameRun run;
    run.seed = seed;
    run.options.raysInFlight = 1;
    run.options.ledger = &ledger;
    Frames frames(cut.ranks, run);
    frames.add(1, compiled);
    frames.start(requestOf(scene));
    frames.run();
    const int64_t peak = byPurpose(ledger.peaks()).at("rays");
    EXPECT_GE(peak, tile / 2) << "schedule " << seed;
    EXPECT_LE(peak, cut.ranks * 4 * (1 + 3) * tile) << "schedule " << seed;
  }
}

}  // namespace
}  // namespace gxy::test
