// SPDX-License-Identifier: Apache-2.0
// Through MPI, one scene gives one picture, bit for bit, on any number of ranks; and on any backends (support/backends.h), with
// --mixed on Embree on every second rank.
#include <gtest/gtest.h>

#include <algorithm>
#include <condition_variable>

#include "core/comm/collective.h"
#include "core/comm/mpi_transport.h"
#include "tests/support/backends.h"
#include "tests/support/frames.h"

namespace gxy::test {
namespace {

struct Prepared {
  TestScene scene;
  Picture expected;
  RankScene mine;
};

bool isMixed() {
  const std::vector<std::string> args = testing::internal::GetArgvs();
  return std::count(args.begin(), args.end(), "--mixed") > 0;
}

// Every kind, on another backend than Embree one of them and everything, cut into more pieces than there are ranks.
std::vector<Prepared> prepared(int rank, int ranks) {
  std::vector<TestScene> scenes = scenesOfEachKind();
  if (&testedBackend() != &embree())
    std::erase_if(scenes, [](const TestScene& s) { return s.name != "smooth volume"; });
  scenes.push_back(everything());
  const Backend& mine = isMixed() && rank % 2 == 0 ? embree() : testedBackend();
  std::vector<Prepared> all;
  for (TestScene& scene : scenes) {
    scene.camera.dimensions = {24, 20};
    const auto compiled = compiledOn(kdCut(scene.domain, ranks + 3, ranks, 5), scene,
                                     [&](int r) -> const Backend& { return r == rank ? mine : embree(); });
    Picture expected = wholeOnEmbree(scene);
    all.push_back({std::move(scene), std::move(expected), compiled[size_t(rank)]});
  }
  return all;
}

/// All scenes at once; what is wrong with the pictures that this rank is handed.
std::string wrongIn(const std::vector<Prepared>& scenes, Transport& transport, Collective& collective,
                    int packetRays, int& pictures) {
  std::mutex mutex;
  std::condition_variable changed;
  size_t finished = 0;
  std::string wrong;
  Renderer renderer(transport, {packetRays, 1 << 20});
  for (size_t i = 0; i < scenes.size(); i++)
    renderer.addScene(SceneId(i), scenes[i].mine.compiled, scenes[i].mine.device);
  renderer.onPicture([&](FrameId, const FrameRequest& request, const Picture& picture) {
    const Prepared& s = scenes[request.scene];
    const std::string different = difference(s.expected, picture);
    const std::lock_guard lock(mutex);
    pictures++;
    if (!different.empty()) wrong += s.scene.name + ": " + different + "\n";
  });
  collective.barrier(1);
  if (transport.rank() == 0) {
    for (size_t i = 0; i < scenes.size(); i++) {
      FrameRequest request = requestOf(scenes[i].scene);
      request.scene = SceneId(i);
      renderer.render(request, [&](FrameId, const Renderer::Ending& ending) {
        const std::lock_guard lock(mutex);
        finished++;
        wrong += ending.error;
        changed.notify_all();
      });
    }
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return finished == scenes.size(); });
  }
  collective.barrier(1);
  return wrong;
}

TEST(PicturesOverMpi, AreTheSameBitsOnAnyNumberOfRanksThreadsAndPackets) {
  struct Way {
    int threads, packetRays;
  };
  constexpr Way kWays[] = {{1, 16}, {2, 1024}};
  std::vector<Prepared> scenes;
  int pictures = 0, owned = 0;
  for (const Way& way : kWays) {
    MpiTransport::Options options;
    options.threads = way.threads;
    MpiTransport transport(options);
    Collective collective(transport);
    if (scenes.empty()) scenes = prepared(transport.rank(), transport.size());
    EXPECT_EQ(wrongIn(scenes, transport, collective, way.packetRays, pictures), "")
        << transport.size() << " ranks, " << way.threads << " threads, packets of " << way.packetRays;
    owned = int(scenes.size()) / transport.size();
  }
  EXPECT_GE(pictures, 2 * owned);  // each picture is handed to one rank
}

}  // namespace
}  // namespace gxy::test
