// SPDX-License-Identifier: Apache-2.0
// Messages that no Renderer sends are refused with an Error, and harm no other frame.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <optional>

#include "core/comm/random.h"
#include "core/comm/wire.h"
#include "tests/comm/tap.h"
#include "tests/support/frames.h"

namespace gxy::test {
namespace {

TestScene scene() {
  TestScene s = emptyScene("hostile", {14, 12});
  addSmoothVolume(s);
  addIsosurfaces(s, 0.5);
  addMesh(s, 0.7);
  addLights(s);
  return s;
}

Renderer::Options options() {
  Renderer::Options options;
  options.packetRays = 16;
  options.ranksPerPart = 1;
  return options;
}

// Renderers of a scene over taps.
// Their pictures have a part on each rank.
struct TappedRanks {
  TappedRanks(InProcessWorld& world, const std::vector<RankScene>& scenes, const Tap::Look& look) {
    for (size_t r = 0; r < scenes.size(); r++) {
      taps.push_back(std::make_unique<Tap>(world.rank(int(r)), look));
      renderers.push_back(std::make_unique<Renderer>(*taps.back(), options()));
      renderers.back()->addScene(1, scenes[r].compiled, scenes[r].device);
      renderers.back()->onPicture([](FrameId, const FrameRequest&, const Picture&) {});
    }
  }
  std::vector<std::unique_ptr<Tap>> taps;
  std::vector<std::unique_ptr<Renderer>> renderers;
};

// Everything that is sent while a frame runs, by channel: what mutations start from.
std::map<Channel, std::vector<Bytes>> recorded(const TestScene& s, const Cut& cut) {
  std::map<Channel, std::vector<Bytes>> messages;
  InProcessWorld world(cut.ranks, 1);
  const TappedRanks ranks(world, compiledOn(cut, s), [&](int, Channel channel, const Bytes& message) {
    messages[channel].push_back(message);
  });
  ranks.renderers[0]->render(requestOf(s), {});
  world.run();
  return messages;
}

Bytes mutated(Bytes message, Random& random) {
  static constexpr uint32_t nasty[] = {0,          1,          0x7fffffff, 0x80000000, 0xffffffff,
                                       0x7fc00000, 0x7f800000, 0xff800000, 0x7f7fffff};
  for (uint64_t n = 1 + random.below(3); n > 0 && !message.empty(); n--) {
    const uint64_t kind = random.below(4);
    if (kind == 0) {
      message.resize(random.below(message.size()));
    } else if (kind == 1) {
      message.insert(message.end(), 1 + random.below(40), std::byte(random.next()));
    } else if (kind == 2) {
      message[random.below(message.size())] ^= std::byte(1u << random.below(8));
    } else if (message.size() >= 4) {
      std::memcpy(&message[random.below(message.size() / 4) * 4], &nasty[random.below(std::size(nasty))], 4);
    }
  }
  return message;
}

// What is wrong may look right and be accepted; it must not crash, hang, or spoil a frame that comes later.
TEST(Malformed, MessagesAreRefusedAndHarmNothing) {
  const TestScene s = scene();
  const Cut cut = lattice(s.domain, {2, 1, 2}, 3);
  const auto messages = recorded(s, cut);
  const auto compiled = compiledOn(cut, s);
  const Picture expected = render(s, 3, compiled);
  const FrameRequest request = requestOf(s);
  size_t refused = 0;
  for (uint64_t seed = 1; seed <= 60; seed++) {
    Random random(seed);
    FrameRun run;
    run.seed = seed;
    run.options = options();
    Frames frames(3, run);
    frames.add(1, compiled);
    frames.start(request);
    for (int i = 0; i < 40; i++) {
      for (const auto& [channel, list] : messages) {
        Bytes message = mutated(list[random.below(list.size())], random);
        if (channel == Channel::Frame &&
            message.size() >= 9) {  // not the running frame's: it would end early
          const FrameId other = 1000 + random.below(50);
          std::memcpy(&message[1], &other, sizeof other);
        }
        frames.world().rank(int(random.below(3))).send(int(random.below(3)), channel, std::move(message));
      }
      for (int k = 0; k < 30; k++) frames.world().step();
    }
    // rays that were made up may have spoilt the count of this frame: it need not end
    for (int k = 0; k < 5000 && frames.world().step(); k++) {
    }
    refused += frames.errors().size();
  }
  EXPECT_GT(refused, 2000u);
  EXPECT_EQ(difference(expected, render(s, 3, compiled)), "");
}

Bytes raysMessage(const Bytes& valid, size_t offset, uint32_t value) {
  Bytes out = valid;
  std::memcpy(&out[offset], &value, 4);
  return out;
}

TEST(Malformed, RaysThatWouldIndexOutsideAreRefused) {
  const TestScene s = scene();
  const Cut cut = lattice(s.domain, {2, 1, 1}, 2);
  const auto compiled = compiledOn(cut, s);
  Bytes primaries, secondaries;
  const auto messages = recorded(s, cut);
  for (const Bytes& m : messages.at(Channel::Rays)) {
    uint32_t primary;
    std::memcpy(&primary, &m[20], 4);
    (primary ? primaries : secondaries) = m;
  }
  ASSERT_FALSE(primaries.empty());
  ASSERT_FALSE(secondaries.empty());
  const auto countOf = [](const Bytes& m) {
    int32_t n;
    std::memcpy(&n, &m[16], 4);
    return size_t(n);
  };
  const size_t header = 24, column = 4 * countOf(secondaries);
  const uint32_t nan = 0x7fc00000;
  struct Case {
    Bytes message;
    const char* expected;
  };
  // fields of a secondary in the order of ray_fields.h: pixel info start ox oy oz dx ...
  const std::vector<Case> cases{
      {raysMessage(primaries, header, 14 * 12), "outside the picture"},
      {raysMessage(secondaries, header, 0xffffffff), "outside the picture"},
      {raysMessage(primaries, header + 4 * countOf(primaries), 5), "a sample"},
      {raysMessage(secondaries, header + column, 0), "another kind"},
      {raysMessage(secondaries, header + 3 * column, nan), "outside the visible domain"},
      {raysMessage(secondaries, header + 6 * column, nan), "unit length"},
      {raysMessage(secondaries, 8, 77), "partition 77"},
      {raysMessage(secondaries, 12, 2), "header"},
      {raysMessage(secondaries, 16, 0x7fffffff), "header"},
  };
  for (const Case& c : cases) {
    Frames frames(2, {});
    frames.add(1, compiled);
    frames.start(requestOf(s));
    int32_t partition;
    std::memcpy(&partition, &c.message[8], 4);
    const int owner = partition < 2 ? cut.partitioning.owner(partition) : 1;
    frames.world().rank(0).send(owner, Channel::Rays, c.message);
    for (int k = 0; k < 5000 && frames.world().step(); k++) {
    }
    ASSERT_EQ(frames.errors().size(), 1u) << c.expected;
    EXPECT_NE(frames.errors()[0].find(c.expected), std::string::npos) << frames.errors()[0];
  }
}

// Their sum stays a number.
TEST(Malformed, CreditsThatNoRaysHaveTakenAreRefused) {
  const TestScene s = scene();
  const Cut cut = lattice(s.domain, {2, 1, 1}, 2);
  for (int64_t credits : {std::numeric_limits<int64_t>::min(), std::numeric_limits<int64_t>::max()}) {
    Frames frames(2, {});
    frames.add(1, compiledOn(cut, s));
    frames.world().rank(1).send(0, Channel::Credits,
                                Writer().write(uint32_t(0)).write(uint64_t(0)).write(credits).take());
    frames.run();
    ASSERT_EQ(frames.errors().size(), 1u);
    EXPECT_NE(frames.errors()[0].find("credits come back"), std::string::npos) << frames.errors()[0];
    EXPECT_EQ(frames.renderer(0).kept().credits, 0);
    const FrameId id = frames.start(requestOf(s));
    frames.run();
    EXPECT_EQ(frames.outcome(id).pictures, 1);
  }
}

// Such as a scene that cannot be told in the fields of a ray would make.
TEST(Malformed, MessagesOfItsOwnEndAFrame) {
  const TestScene s = scene();
  const Cut cut = lattice(s.domain, {2, 1, 1}, 2);
  const auto compiled = compiledOn(cut, s);
  constexpr auto kContributions = std::byte(0), kParts = std::byte(1);
  struct Case {
    Channel channel;
    std::optional<std::byte> kind;  ///< the first byte of the messages that are meant
    size_t
        offset;  ///< of what is spoilt: the partition of rays, a contribution's pixel, the number of a part
    const char* expected;
  };
  for (const Case& c :
       {Case{Channel::Rays, {}, 8, "partition 77 is not one that this rank shows"},
        Case{Channel::Contributions, kContributions, 25, "a pixel lies outside this rank's part"},
        Case{Channel::Contributions, kParts, 9, "part 77 of a picture of 2 came, expected each"}}) {
    int sent = 0;
    InProcessWorld::Options worldOptions;
    std::vector<std::string> errors, endings;
    worldOptions.onError = [&](int, const std::string& error) { errors.push_back(error); };
    InProcessWorld world(cut.ranks, 1, std::move(worldOptions));
    const TappedRanks ranks(world, compiled, [&](int, Channel channel, Bytes& message) {
      const uint32_t wrong = c.kind == kContributions ? 0xffffffff : 77;
      if (channel == c.channel && message[0] == c.kind.value_or(message[0]) && sent++ == 0)
        std::memcpy(&message[c.offset], &wrong, sizeof wrong);
    });
    ranks.renderers[0]->render(
        requestOf(s), [&](FrameId, const Renderer::Ending& ending) { endings.push_back(ending.error); });
    world.run();
    ASSERT_EQ(endings.size(), 1u) << c.expected;
    EXPECT_NE(endings[0].find(c.expected), std::string::npos) << endings[0];
    EXPECT_EQ(errors.size(), 1u);
    for (const auto& renderer : ranks.renderers) {
      const Renderer::ResourceCounts kept = renderer->kept();
      EXPECT_EQ(kept.frames + kept.parkedMessages + kept.callbacks + kept.completionSets + kept.pictures, 0u);
      EXPECT_EQ(kept.credits, 0);
    }
  }
}

}  // namespace
}  // namespace gxy::test
