// SPDX-License-Identifier: Apache-2.0
// The protocol of frames: always reported, never early, nothing left behind, under any schedule.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/comm/error.h"
#include "core/comm/random.h"
#include "core/render/tiles.h"
#include "tests/support/backends.h"
#include "tests/support/frames.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

// Schedules of the seeded world in one run; raise it for long runs: --schedules=100000
int schedules() {
  for (const std::string& arg : testing::internal::GetArgvs())
    if (arg.rfind("--schedules=", 0) == 0) return std::stoi(arg.substr(12));
  return seeds(2000);
}

struct Prepared {
  TestScene scene;
  Cut cut;
  std::vector<RankScene> compiled;
  Picture expected;
  Prepared(TestScene s, Cut c)
      : scene(std::move(s)),
        cut(std::move(c)),
        compiled(compiledOn(cut, scene)),
        expected(wholeOnEmbree(scene)) {}
  FrameRequest request(SceneId id) const {
    FrameRequest r;
    r.scene = id;
    r.camera = scene.camera;
    r.depth = true;
    return r;
  }
};

TestScene litBalls(glm::ivec2 size) {
  TestScene s = emptyScene("balls", size);
  addParticles(s, 1);
  addMesh(s, 1);
  addLights(s);
  return s;
}

TestScene tinyVolume(glm::ivec2 size) {
  TestScene s = emptyScene("volume", size);
  addSmoothVolume(s);
  addTubes(s, 0.5);
  return s;
}

void expectNothingKept(Frames& frames) {
  for (int r = 0; r < frames.world().size(); r++) {
    const Renderer::ResourceCounts kept = frames.renderer(r).kept();
    EXPECT_EQ(kept.frames, 0u);
    EXPECT_EQ(kept.parkedMessages, 0u);
    EXPECT_EQ(kept.callbacks, 0u);
    EXPECT_EQ(kept.windows, 0u);
    EXPECT_EQ(kept.pictures, 0u);
    EXPECT_EQ(kept.completionSets, 0u);
    EXPECT_EQ(kept.credits, 0);
  }
}

TEST(Frames, TinyOnesAreRightUnderManySchedules) {
  const Prepared balls(litBalls({3, 2}), kdCut(sceneDomain(), 5, 3, 4));
  const Prepared volume(tinyVolume({4, 3}), kdCut(sceneDomain(), 5, 3, 4));
  for (int seed = 1; seed <= schedules(); seed++) {
    FrameRun run;
    run.seed = uint64_t(seed);
    run.options.packetRays = 16;
    run.options.raysInFlight = seed % 3 ? 1 : 1 << 20;
    run.options.ranksPerPart = 1 + seed % 4;  // pictures of 2 and 3 parts, of 2, and of 1
    Frames frames(3, run);
    frames.add(1, balls.compiled);
    frames.add(2, volume.compiled);
    const FrameId a = frames.start(balls.request(1)), b = frames.start(volume.request(2));
    frames.run();
    ASSERT_TRUE(frames.errors().empty()) << frames.errors()[0];
    for (const auto& [id, prepared] : {std::pair(a, &balls), std::pair(b, &volume)}) {
      ASSERT_EQ(frames.outcome(id).finished, 1) << "schedule " << seed;
      ASSERT_EQ(difference(prepared->expected, frames.outcome(id).picture), "") << "schedule " << seed;
    }
    expectNothingKept(frames);
    if (HasFailure()) FAIL() << "schedule " << seed;
  }
}

// Every frame of a window ends; those that are superseded say so and show nothing; the last one is right.
TEST(Frames, ANewerFrameOfAWindowSupersedesTheOlder) {
  const Prepared balls(litBalls({20, 16}), lattice(sceneDomain(), {2, 2, 1}, 4));
  int superseded = 0;
  for (uint64_t seed = 1; seed <= uint64_t(affordable(seeds(150))); seed++) {
    Random random(seed);
    FrameRun run;
    run.seed = seed;
    run.options.packetRays = 16;
    run.options.raysInFlight = 500;
    run.options.ranksPerPart = 1 + int(seed % 4);
    Frames frames(4, run);
    frames.add(1, balls.compiled);
    std::vector<FrameId> ids;
    for (int i = 0; i < 6; i++) {
      FrameRequest request = balls.request(1);
      request.window = 1 + uint64_t(i % 2);
      ids.push_back(frames.start(request));
      for (uint64_t steps = random.below(400); steps > 0 && frames.world().step(); steps--) {
      }
    }
    frames.run();
    ASSERT_TRUE(frames.errors().empty()) << frames.errors()[0];
    for (size_t i = 0; i < ids.size(); i++) {
      const Frames::Outcome& o = frames.outcome(ids[i]);
      ASSERT_EQ(o.finished, 1) << "frame " << i << ", schedule " << seed;
      ASSERT_EQ(o.pictures + o.superseded, 1) << "frame " << i << ", schedule " << seed;
      ASSERT_EQ(o.pictures ? difference(balls.expected, o.picture) : "", "")
          << "frame " << i << ", schedule " << seed;
      superseded += o.superseded;
    }
    ASSERT_EQ(frames.outcome(ids[4]).pictures + frames.outcome(ids[5]).pictures, 2) << "schedule " << seed;
    expectNothingKept(frames);
    if (HasFailure()) FAIL() << "schedule " << seed;
  }
  EXPECT_GT(superseded, affordable(seeds(150)) * 2 / 3);
}

TEST(Frames, OfSeveralScenesShareTheRanks) {
  const Cut cut = lattice(sceneDomain(), {2, 2, 2}, 8);
  const Prepared balls(litBalls({20, 16}), cut), volume(tinyVolume({17, 21}), cut);
  for (bool threaded : {false, true}) {
    FrameRun run;
    run.threaded = threaded;
    run.options.packetRays = 64;
    run.options.raysInFlight = 300;
    run.options.ranksPerPart = 1;
    Frames frames(8, run);
    frames.add(1, balls.compiled);
    frames.add(2, volume.compiled);
    std::vector<FrameId> ids;
    for (int i = 0; i < 20; i++)
      ids.push_back(frames.start((i % 2 ? volume : balls).request(1 + SceneId(i % 2))));
    frames.run();
    ASSERT_TRUE(frames.errors().empty()) << frames.errors()[0];
    for (size_t i = 0; i < ids.size(); i++) {
      ASSERT_EQ(frames.outcome(ids[i]).finished, 1);
      EXPECT_EQ(difference((i % 2 ? volume : balls).expected, frames.outcome(ids[i]).picture), "") << i;
    }
    expectNothingKept(frames);
  }
}

// Tenants, their streams and those who watch in any mix, with fewer credits than a tile costs each: all frames are right, none
// waits for ever.
TEST(Frames, OfTenantsWithLittleAllEnd) {
  const Prepared balls(litBalls({40, 36}), lattice(sceneDomain(), {2, 2, 1}, 3));
  for (uint64_t seed = 1; seed <= uint64_t(affordable(seeds(60))); seed++) {
    FrameRun run;
    run.seed = seed;
    run.options.packetRays = 16;
    run.options.raysInFlight = 2000;
    run.options.runners = 1 + int(seed % 3);
    Frames frames(3, run);
    frames.add(1, balls.compiled);
    std::vector<FrameId> ids;
    for (int i = 0; i < 6; i++) {
      FrameRequest request = balls.request(1);
      request.priority = {uint32_t(i % 3), i % 2 == 0, uint64_t(i / 3)};
      ids.push_back(frames.start(request));
    }
    frames.renderer(0).supersede(ids[3]);
    frames.run();
    ASSERT_TRUE(frames.errors().empty()) << frames.errors()[0];
    for (size_t i = 0; i < ids.size(); i++) {
      ASSERT_EQ(frames.outcome(ids[i]).finished, 1) << seed;
      ASSERT_EQ(frames.outcome(ids[i]).superseded, i == 3);
      if (i != 3) {
        ASSERT_EQ(difference(balls.expected, frames.outcome(ids[i]).picture), "") << seed;
      }
    }
    expectNothingKept(frames);
    if (HasFailure()) FAIL() << "schedule " << seed;
  }
}

// Neither the list of tiles nor what ends a frame grows with its samples.
TEST(Frames, OfManySamplesEndAtOnceWhenTheyAreSuperseded) {
  Prepared balls(litBalls({64, 64}), lattice(sceneDomain(), {2, 1, 1}, 2));
  FrameRun run;
  run.options.raysInFlight = 1;  // one tile at a time
  Frames frames(2, run);
  frames.add(1, balls.compiled);
  FrameRequest request = balls.request(1);
  request.samples = 1 << 16;
  const FrameId id = frames.start(request);
  frames.renderer(0).supersede(id);
  int events = 0;
  while (events < 10000 && frames.world().step()) events++;
  EXPECT_LT(events, 1000);
  EXPECT_EQ(frames.outcome(id).superseded, 1);
  EXPECT_EQ(frames.errors(), std::vector<std::string>{});
  expectNothingKept(frames);
}

TEST(Frames, ThatSeeNothingAreReportedAndAreBackground) {
  Prepared balls(litBalls({9, 7}), lattice(sceneDomain(), {2, 1, 1}, 3));
  balls.scene.camera.viewdirection = -balls.scene.camera.viewdirection;
  const Picture p = render(balls.scene, 3, balls.compiled);
  for (size_t i = 0; i < p.rgba.size(); i += 4) ASSERT_EQ(p.rgba[i + 2], 0.2f);
}

// Three ranks, and three parts of a picture.
TEST(Frames, OfSeveralPartsHaveTheSumsThatOneFramebufferHas) {
  const Prepared volume(tinyVolume({17, 20}), kdCut(sceneDomain(), 5, 3, 4));
  FrameRequest request = volume.request(1);
  request.sums = true;
  const auto pictureOf = [&](int ranksPerPart) {
    FrameRun run;
    run.options.ranksPerPart = ranksPerPart;
    Frames frames(3, run);
    frames.add(1, volume.compiled);
    const FrameId id = frames.start(request);
    frames.run();
    EXPECT_EQ(frames.errors(), std::vector<std::string>{});
    return frames.outcome(id).picture;
  };
  const Picture together = pictureOf(3), inParts = pictureOf(1);
  EXPECT_EQ(inParts.sums, together.sums);
  EXPECT_EQ(inParts.depth, together.depth);
  EXPECT_EQ(inParts.samples, together.samples);
  EXPECT_TRUE(inParts.rgba.empty());
  EXPECT_NE(together.sums, LargeVector<int64_t>(4 * 17 * 20, 0));
}

TEST(Frames, OfOnePixel) {
  const TestScene scene = litBalls({1, 1});
  const Picture expected = wholeOnEmbree(scene);
  EXPECT_NE(expected.rgba[0], 0.1f);
  EXPECT_EQ(difference(expected, render(scene, kdCut(scene.domain, 9, 8, 2))), "");
}

// Partitions in a ring around an axis, each on a rank of its own; rays of one tile at a time.
TEST(Frames, OfARingOnEightRanksFinishWithABudgetOfOne) {
  const Box d = sceneDomain();
  const double x[] = {-0.9, -0.2, 0.4, 1.1}, y[] = {-0.75, -0.2, 0.3, 0.8};
  const int ring[][2] = {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};
  std::vector<Box> boxes;
  std::vector<int32_t> owners;
  for (int i = 0; i < 8; i++) {
    const auto [a, b] = ring[i];
    boxes.push_back({{x[a], y[b], d.lo.z}, {x[a + 1], y[b + 1], d.hi.z}});
    owners.push_back(i);
  }
  boxes.push_back({{x[1], y[1], d.lo.z}, {x[2], y[2], d.hi.z}});
  owners.push_back(0);
  TestScene scene = litBalls({40, 36});
  addOcclusion(scene);
  const Prepared p(scene, {"ring", 8, Partitioning::fromBoxes(boxes, owners)});
  FrameRun run;
  run.options = {16, 1};
  for (uint64_t seed = 1; seed <= uint64_t(affordable(10)); seed++) {
    run.seed = seed;
    EXPECT_EQ(difference(p.expected, render(p.scene, 8, p.compiled, run)), "");
  }
}

// Opaque surfaces: no primary makes more secondaries than it reserved.
TEST(Frames, KeepToTheBudgetOfRaysInFlight) {
  const Prepared balls(litBalls({70, 64}), lattice(sceneDomain(), {2, 2, 1}, 4));
  const int64_t perPrimary = 1 + 3;
  for (int64_t budget : {int64_t(1), int64_t(4096), int64_t(12288)}) {
    const int side = tileSide(budget, perPrimary);
    const int64_t tile = side * side * perPrimary;
    FrameRun run;
    run.options = {64, budget};
    Frames frames(4, run);
    frames.add(1, balls.compiled);
    frames.start(balls.request(1));
    frames.start(balls.request(1));
    frames.run();
    int64_t most = 0;
    for (int r = 0; r < 4; r++) most = std::max(most, frames.renderer(r).counters().mostRaysInFlight);
    EXPECT_GT(most, 0);
    EXPECT_LE(most, std::max(budget, tile));
  }
}

TEST(Frames, AreReportedEvenIfThePictureCannotBeHandedOut) {
  const Prepared balls(litBalls({5, 4}), lattice(sceneDomain(), {2, 1, 1}, 2));
  Frames frames(2, {});
  frames.add(1, balls.compiled);
  for (int r = 0; r < 2; r++)
    frames.renderer(r).onPicture(
        [](FrameId, const FrameRequest&, Picture) { throw Error("the disk is full"); });
  const FrameId id = frames.start(balls.request(1));
  frames.run();
  EXPECT_EQ(frames.outcome(id).finished, 1);
  EXPECT_EQ(frames.outcome(id).error, "rank 1: the disk is full");
  ASSERT_EQ(frames.errors().size(), 1u);
  EXPECT_NE(frames.errors()[0].find("the disk is full"), std::string::npos);
}

// What a rank has done with the picture of a frame.
struct OperationRun {
  int rank;
  std::string text;
  Picture picture;
};

class RecordedOperation final : public PictureOperation {
 public:
  RecordedOperation(int rank, std::string text, std::vector<OperationRun>& done)
      : rank_(rank), text_(std::move(text)), done_(done) {}
  void write(Writer& w) const override { w.write(text_); }
  void run(Picture picture) const override {
    if (text_ == "the disk is full") throw Error(text_);
    done_.push_back({rank_, text_, std::move(picture)});
  }

 private:
  const int rank_;
  const std::string text_;
  std::vector<OperationRun>& done_;
};

TEST(Frames, RunTheirOperationWhereTheirPictureIs) {
  const Prepared balls(litBalls({40, 36}), lattice(sceneDomain(), {2, 2, 1}, 3));
  for (uint64_t seed = 1; seed <= uint64_t(affordable(seeds(20))); seed++) {
    FrameRun run;
    run.seed = seed;
    run.options.packetRays = 64;
    run.options.ranksPerPart = 1 + int(seed % 3);
    Frames frames(3, run);
    frames.add(1, balls.compiled);
    std::vector<OperationRun> done;
    for (int r = 0; r < 3; r++)
      frames.renderer(r).onOperation([r, &done](Reader& in) {
        return std::make_shared<const RecordedOperation>(r, in.readString(), done);
      });
    std::vector<FrameId> ids;
    for (int i = 0; i < 6; i++) {
      FrameRequest request = balls.request(1);
      if (i != 2)
        request.operation = std::make_shared<const RecordedOperation>(0, "for " + std::to_string(i), done);
      ids.push_back(frames.start(request));
    }
    frames.renderer(0).supersede(ids[4]);
    frames.run();
    ASSERT_EQ(frames.errors(), std::vector<std::string>{}) << seed;
    for (size_t i = 0; i < ids.size(); i++) {
      ASSERT_EQ(frames.outcome(ids[i]).finished, 1) << seed;
      ASSERT_EQ(frames.outcome(ids[i]).pictures, i == 2) << "one has none";
      const auto isOfThis = [&](const OperationRun& d) { return d.text == "for " + std::to_string(i); };
      ASSERT_EQ(std::count_if(done.begin(), done.end(), isOfThis), i != 2 && i != 4) << seed;
      const auto at = std::find_if(done.begin(), done.end(), isOfThis);
      if (at == done.end()) continue;
      ASSERT_EQ(at->rank, int(ids[i] % 3)) << "the owner";
      ASSERT_EQ(difference(balls.expected, at->picture), "") << seed;
    }
    expectNothingKept(frames);
  }
}

TEST(Frames, EndWithWhatTheirOperationThrows) {
  const Prepared balls(litBalls({5, 4}), lattice(sceneDomain(), {2, 1, 1}, 2));
  std::vector<OperationRun> done;
  Frames frames(2, {});
  frames.add(1, balls.compiled);
  FrameRequest request = balls.request(1);
  request.operation = std::make_shared<const RecordedOperation>(0, "the disk is full", done);
  const auto errorOf = [&](const FrameRequest& asked) {
    const FrameId id = frames.start(asked);
    frames.run();
    EXPECT_EQ(frames.outcome(id).finished, 1);
    EXPECT_EQ(frames.outcome(id).pictures, 0);
    return frames.outcome(id).error;
  };
  EXPECT_NE(errorOf(request).find("rank 1: its picture comes with an operation"), std::string::npos)
      << "no reader";
  for (int r = 0; r < 2; r++)
    frames.renderer(r).onOperation([r, &done](Reader& in) {
      return std::make_shared<const RecordedOperation>(r, in.readString(), done);
    });
  EXPECT_EQ(errorOf(request), "rank 0: the disk is full") << "frame 2 is rank 0's";
  EXPECT_EQ(errorOf(request), "rank 1: the disk is full");
  expectNothingKept(frames);
}

}  // namespace
}  // namespace gxy::test
