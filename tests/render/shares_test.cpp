// SPDX-License-Identifier: Apache-2.0
// How long a frame waits for those of others, counted in their packets, in worlds whose schedule a seed decides and whose clock
// counts rays.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/comm/random.h"
#include "tests/support/frames.h"
#include "tests/support/observed_backend.h"

namespace gxy::test {
namespace {

using Time = std::chrono::nanoseconds;

constexpr glm::ivec2 kHeavySize{64, 60}, kLightSize{48, 40};
constexpr int kPacket = 64;
constexpr Time kRay = std::chrono::microseconds(10);

/// What a rank has done for whom.
struct Done {
  Time heavy{0}, light{0};
  int64_t heavyPackets = 0;
  bool waits = false;         ///< the light frame is known, and nothing of it has been done
  int64_t packetsBefore = 0;  ///< of the heavy ones, when it became known
  int64_t mostWaitedFor = 0;  ///< packets, by any light frame
  Time heavyBefore{0};        ///< when the last piece of work of a light frame began
  Time clock{0};
};

struct Case {
  int ranks;
  uint32_t heavyTenant, lightTenant;
  int heavyWindows;
  int64_t raysInFlight = 1 << 15;
};

struct Result {
  std::vector<Done> ranks;
  Time heavy{0}, light{0};          ///< on all ranks while there were light frames
  Time mostHeavy{0}, mostLight{0};  ///< during one light frame, on rank 0
  int64_t longest = 0;
  int frames = 0;
};

// Windows that shoot 65 rays a hit, all the time, beside one that shows its frames one after the other.
Result beside(const Case& c) {
  TestScene heavy = emptyScene("heavy", kHeavySize), light = emptyScene("light", kLightSize);
  addParticles(heavy, 1);
  heavy.visualization.lighting.aoCount = 64;
  heavy.visualization.lighting.aoRadius = 0.5;
  heavy.visualization.lighting.shadows = true;
  addParticles(light, 1);
  Result result;
  result.ranks.resize(size_t(c.ranks));
  Time clock{0};  // one: nothing runs at once in a seeded world
  std::vector<Observer> observers{size_t(c.ranks)};
  std::vector<std::unique_ptr<ObservedBackend>> backends;
  for (size_t r = 0; r < size_t(c.ranks); r++) {
    Done& done = result.ranks[r];
    observers[r].known = [&done](glm::ivec2 size) {
      if (size != kLightSize) return;
      done.waits = true;
      done.packetsBefore = done.heavyPackets;
    };
    observers[r].begins = [&done, &clock](glm::ivec2 size, int rays) {
      const Time time = rays * kRay + Time(1000);
      clock += time;
      if (size == kHeavySize) {
        done.heavy += time;
        done.heavyPackets += rays > 0;
        return;
      }
      done.light += time;
      done.heavyBefore = done.heavy;
      if (std::exchange(done.waits, false))
        done.mostWaitedFor = std::max(done.mostWaitedFor, done.heavyPackets - done.packetsBefore);
    };
    backends.push_back(std::make_unique<ObservedBackend>(observers[r]));
  }
  FrameRun run;
  run.seed = 5;
  run.options.packetRays = kPacket;
  run.options.raysInFlight = c.raysInFlight;
  run.options.runners = 1;
  run.options.urgentWork = std::chrono::hours(1);
  run.options.processorTime = [&clock] { return clock; };
  Frames frames(c.ranks, run);
  const Cut cut = lattice(sceneDomain(), {c.ranks, 1, 1}, c.ranks);
  const auto backendOf = [&](int rank) -> const Backend& { return *backends[size_t(rank)]; };
  frames.add(1, compiledOn(cut, heavy, backendOf));
  frames.add(2, compiledOn(cut, light, backendOf));

  FrameRequest request;
  request.scene = 1;
  request.camera = heavy.camera;
  request.samples = 64;
  std::vector<FrameId> windows;
  for (int i = 0; i < c.heavyWindows; i++) {
    request.priority = {c.heavyTenant, true, uint64_t(i)};
    windows.push_back(frames.start(request));
  }
  request.scene = 2;
  request.camera = light.camera;
  request.samples = 1;
  request.priority = {c.lightTenant, true, 1000};
  const auto steps = [&](uint64_t n) {
    while (n-- > 0 && frames.world().step()) {
    }
  };
  steps(20000);
  Random random(3);
  for (int i = 0; i < 6; i++) {
    Time heavyBefore{0}, lightBefore{0};
    for (const Done& done : result.ranks) heavyBefore += done.heavy, lightBefore += done.light;
    const FrameId id = frames.start(request);
    while (frames.outcome(id).finished == 0 && frames.world().step()) {
    }
    EXPECT_EQ(frames.outcome(id).pictures, 1);
    Time heavyAfter{0}, lightAfter{0};
    for (const Done& done : result.ranks) heavyAfter += done.heavyBefore, lightAfter += done.light;
    result.heavy += heavyAfter - heavyBefore;
    result.light += lightAfter - lightBefore;
    result.mostHeavy = std::max(result.mostHeavy, heavyAfter - heavyBefore);
    result.mostLight = std::max(result.mostLight, lightAfter - lightBefore);
    result.frames++;
    steps(random.below(3000));
  }
  for (const FrameId id : windows) {
    EXPECT_EQ(frames.outcome(id).finished, 0) << "there was always something heavy to do";
    frames.renderer(0).supersede(id);
  }
  frames.run();
  EXPECT_EQ(frames.errors(), std::vector<std::string>{});
  for (int r = 0; r < c.ranks; r++) EXPECT_EQ(frames.renderer(r).kept().credits, 0);
  return result;
}

constexpr Time kHeavyPacket = kPacket * kRay + Time(1000);

TEST(Shares, AnothersThirtyWindowsMakeAFrameWaitForTwoPacketsAndTakeAsMuchTimeAsIt) {
  const Result r = beside({1, 1, 2, 30});
  EXPECT_LE(r.ranks[0].mostWaitedFor, 2);
  EXPECT_GT(r.mostLight, 20 * kHeavyPacket);
  EXPECT_LE(r.mostHeavy, r.mostLight + 2 * kHeavyPacket);
  EXPECT_GE(r.heavy, 2 * r.light / 3) << "which is 0.4 of all, and the light frames never pause";
}

TEST(Shares, WindowsOfATenantShareAsTenantsDo) {
  const Result one = beside({1, 1, 1, 1});
  EXPECT_LE(one.ranks[0].mostWaitedFor, 2);
  EXPECT_LE(one.mostHeavy, one.mostLight + 2 * kHeavyPacket);
  const Result three = beside({1, 1, 1, 3});
  EXPECT_LE(three.ranks[0].mostWaitedFor, 2);
  EXPECT_LE(three.mostHeavy, 3 * (three.mostLight + 2 * kHeavyPacket));
}

TEST(Shares, OnSeveralRanksThereIsRoomForAFrameAtOnce) {
  const Result r = beside({3, 1, 2, 10});
  for (const Done& done : r.ranks) EXPECT_LE(done.mostWaitedFor, 2);
}

}  // namespace
}  // namespace gxy::test
