// SPDX-License-Identifier: Apache-2.0
// Very many tiny frames through MPI, each equal to the expected bits.
#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>

#include "core/comm/collective.h"
#include "core/comm/mpi_transport.h"
#include "tests/support/frames.h"

namespace gxy::test {
namespace {

// Raise it for long runs: --frames=10000
int framesWanted() {
  for (const std::string& arg : testing::internal::GetArgvs())
    if (arg.rfind("--frames=", 0) == 0) return std::stoi(arg.substr(9));
  return 1000;
}

TEST(FramesOverMpi, AreAllReportedAndRight) {
  constexpr uint64_t kKey = 1;
  constexpr int kMostInFlight = 24;
  const int wanted = framesWanted();
  TestScene scenes[2] = {emptyScene("balls", {5, 4}), emptyScene("volume", {4, 6})};
  addParticles(scenes[0], 1);
  addLights(scenes[0]);
  addSmoothVolume(scenes[1]);
  addMesh(scenes[1], 0.5);

  MpiTransport::Options transportOptions;
  transportOptions.threads = 1;
  MpiTransport transport(transportOptions);
  Collective collective(transport);
  std::mutex mutex;
  std::condition_variable changed;
  int finished = 0;
  std::atomic<int> wrong = 0;
  std::string firstWrong;
  {
    Renderer::Options options;
    options.packetRays = 16;
    options.raysInFlight = 200;
    options.ranksPerPart = 1;
    Renderer renderer(transport, options);
    Picture expected[2];
    for (int i = 0; i < 2; i++) {
      expected[i] = wholeOnEmbree(scenes[i]);
      const auto compiled = compiledOn(kdCut(scenes[i].domain, 7, transport.size(), 3), scenes[i]);
      const RankScene& mine = compiled[size_t(transport.rank())];
      renderer.addScene(SceneId(i), mine.compiled, mine.device);
    }
    renderer.onPicture([&](FrameId, const FrameRequest& request, Picture picture) {
      const std::string difference = test::difference(expected[request.scene], picture);
      if (difference.empty()) return;
      std::lock_guard lock(mutex);
      if (wrong++ == 0) firstWrong = difference;
    });
    collective.barrier(kKey);
    if (transport.rank() == 0) {
      for (int i = 0; i < wanted; i++) {
        {
          std::unique_lock lock(mutex);
          changed.wait(lock, [&] { return i - finished < kMostInFlight; });
        }
        FrameRequest request;
        request.scene = SceneId(i % 2);
        request.camera = scenes[i % 2].camera;
        request.depth = true;
        renderer.render(request, [&](FrameId, const Renderer::Ending&) {
          std::lock_guard lock(mutex);
          finished++;
          changed.notify_all();
        });
      }
      std::unique_lock lock(mutex);
      changed.wait(lock, [&] { return finished == wanted; });
    }
    collective.barrier(kKey);
    if (transport.rank() == 0) {
      const Renderer::ResourceCounts kept = renderer.kept();
      EXPECT_EQ(kept.frames, 0u);
      EXPECT_EQ(kept.parkedMessages, 0u);
      EXPECT_EQ(kept.callbacks, 0u);
      EXPECT_EQ(kept.pictures, 0u);
    }
  }
  EXPECT_EQ(wrong, 0) << firstWrong;
}

}  // namespace
}  // namespace gxy::test
