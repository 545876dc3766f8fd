// SPDX-License-Identifier: Apache-2.0
// A frame takes few messages of each rank, however many ranks there are.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "tests/comm/tap.h"
#include "tests/support/frames.h"

namespace gxy::test {
namespace {

TestScene mixed() {
  TestScene s = emptyScene("mixed", {64, 64});
  addSmoothVolume(s);
  addParticles(s, 0.5);
  addLights(s);
  return s;
}

/// The most messages for pixels that one rank has got for a frame: contributions while it is under way, and parts
/// of its picture after that.
struct Most {
  int contributions = 0, parts = 0;
};

// Each rank has one partition. The pictures of frames that follow each other must be those of one rank.
Most mostOf(std::array<int, 3> lattices, int ranksPerPart) {
  static const TestScene scene = mixed();
  static const Picture expected = wholeOnEmbree(scene);
  const int ranks = lattices[0] * lattices[1] * lattices[2];
  const auto compiled = compiledOn(lattice(sceneDomain(), lattices, ranks), scene);
  Renderer::Options options;
  options.ranksPerPart = ranksPerPart;
  options.processorTime = [] { return std::chrono::nanoseconds(0); };  // packets are as large as can be
  InProcessWorld world(ranks, 1);
  std::vector<std::unique_ptr<Tap>> taps;
  std::vector<std::unique_ptr<Renderer>> renderers;
  std::vector<std::array<int, 2>> received;
  int pictures = 0;
  for (int r = 0; r < ranks; r++) {
    taps.push_back(
        std::make_unique<Tap>(world.rank(r), [&](int destination, Channel channel, const Bytes& m) {
          if (channel == Channel::Contributions) received[size_t(destination)].at(size_t(m.at(0)))++;
        }));
    renderers.push_back(std::make_unique<Renderer>(*taps.back(), options));
    renderers.back()->addScene(1, compiled[size_t(r)].compiled, compiled[size_t(r)].device);
    renderers.back()->onPicture([&](FrameId, const FrameRequest&, const Picture& picture) {
      pictures++;
      EXPECT_EQ(difference(expected, picture), "");
    });
  }
  constexpr int kFrames = 2;
  Most most;
  for (int i = 0; i < kFrames; i++) {
    received.assign(size_t(ranks), {});
    renderers[0]->render(requestOf(scene), {});
    world.run();
    for (const auto& [contributions, parts] : received) {
      most.contributions = std::max(most.contributions, contributions);
      most.parts = std::max(most.parts, parts);
    }
  }
  EXPECT_EQ(pictures, kFrames);
  return most;
}

TEST(FewMessages, OfContributionsNoMoreOnSixtyFourRanksThanOnSixteen) {
  const int perPart = Renderer::Options().ranksPerPart;
  const Most sixteen = mostOf({4, 2, 2}, perPart), sixtyFour = mostOf({4, 4, 4}, perPart),
             inOnePart = mostOf({4, 4, 4}, 64);
  EXPECT_GT(sixteen.contributions, 0);
  EXPECT_EQ(sixteen.parts, 0);
  EXPECT_LE(sixtyFour.contributions, sixteen.contributions);
  EXPECT_LE(sixtyFour.parts, 2) << "of the ranks of two parts at most";
  EXPECT_GT(inOnePart.contributions, sixteen.contributions) << "what parts are for";
}

TEST(FewMessages, OfPartsTwoForARankHoweverManyPartsThereAre) {
  const Most most = mostOf({4, 4, 4}, 1);
  EXPECT_EQ(most.parts, 2);
}

}  // namespace
}  // namespace gxy::test
