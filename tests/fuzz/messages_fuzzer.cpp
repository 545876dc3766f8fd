// SPDX-License-Identifier: Apache-2.0
// What ranks say to each other, while a frame is under way on two of them: whatever the bytes, a message is
// taken or refused with an Error, and nothing crashes. An input is messages one after the other: the channel and
// the rank that gets it (one byte each), the length (two bytes), and the bytes.
#include <cstdint>
#include <cstring>
#include <map>
#include <span>

#include "core/comm/collective.h"
#include "core/comm/error.h"
#include "core/comm/work.h"
#include "core/data/mesh_blocks.h"
#include "core/data/replicate.h"
#include "tests/support/frames.h"

namespace {

using namespace gxy;

constexpr int kRanks = 2, kSteps = 3000;

struct Scene {
  test::TestScene scene = test::emptyScene("fuzzed", {3, 2});
  test::Cut cut = test::lattice(scene.domain, {2, 1, 1}, kRanks);
  std::vector<test::RankScene> compiled;
  Scene() {
    test::addSmoothVolume(scene);
    test::addMesh(scene, 0.6);
    test::addLights(scene);
    compiled = test::compiledOn(cut, scene);
  }
};

/// Two ranks with a frame that has begun.
class Ranks {
 public:
  explicit Ranks(const Scene& s) : frames_(kRanks, run()) {
    for (int r = 0; r < kRanks; r++) {
      Transport& transport = frames_.world().rank(r);
      collectives_.push_back(std::make_unique<Collective>(transport));
      works_.push_back(std::make_unique<Work>(transport));
      works_.back()->add("echo", [](const Work::Call& call) { return call.parameters; });
      works_.back()->add("member", [](const Work::Call& call) { return call.parameters.at("member"); });
    }
    frames_.add(1, s.compiled);
    frames_.start(test::requestOf(s.scene));
    works_[0]->broadcast("echo", {{"member", 1}}, {});
    step(40);
  }
  void send(int to, Channel channel, Bytes message) {
    frames_.world().rank(1 - to).send(to, channel, std::move(message));
  }
  /// What was said may have spoilt the count of a frame: it need not end.
  void step(int most) {
    while (most-- > 0 && frames_.world().step()) {
    }
  }

 private:
  static test::FrameRun run() {
    test::FrameRun run;
    run.options.packetRays = 16;
    run.options.ranksPerPart = 1;  // the picture's parts travel, too
    return run;
  }

  test::Frames frames_;
  std::vector<std::unique_ptr<Collective>> collectives_;
  std::vector<std::unique_ptr<Work>> works_;
};

// Frames are kept small: large ones are no mistake of a message, but take their memory and time.
void shrink(Bytes& frameMessage) {
  int32_t size[2];
  if (frameMessage.size() < sizeof size) return;
  std::byte* last = frameMessage.data() + frameMessage.size() - sizeof size;
  std::memcpy(size, last, sizeof size);
  for (int32_t& n : size)
    if (n > 64) n %= 64;
  std::memcpy(last, size, sizeof size);
}

void unpack(const Scene& s, GeometryKind kind, const Bytes& message) {
  try {
    ReceivedBlocks received(kind, s.cut.partitioning, 0);
    received.take(std::span(&message, 1));
    received.merged();
  } catch (const Error&) {
  }
}

void unpackCells(const Scene& s, const Bytes& message) {
  std::map<int, MeshBlock> blocks;
  const std::span<const Bytes> received(&message, 1);
  try {
    MeshBlockCounts counts;
    blocks = unpackMesh(s.cut.partitioning, 0, received, counts);
    packSettledValues(blocks, counts, s.cut.partitioning, kRanks);
  } catch (const Error&) {
  }
  try {
    takeSettledValues(blocks, s.cut.partitioning, received);
  } catch (const Error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Scene scene;
  static constexpr Channel channels[] = {Channel::Work,   Channel::Completion,    Channel::Collective,
                                         Channel::Rays,   Channel::Contributions, Channel::Frame,
                                         Channel::Credits};
  Ranks ranks(scene);
  auto rest = std::as_bytes(std::span(data, size));
  while (rest.size() >= 4) {
    const auto channel = size_t(rest[0]) % (std::size(channels) + 1);
    const int to = int(rest[1]) % kRanks;
    uint16_t length;
    std::memcpy(&length, &rest[2], sizeof length);
    rest = rest.subspan(4);
    const auto body = rest.first(std::min<size_t>(length, rest.size()));
    rest = rest.subspan(body.size());
    Bytes message(body.begin(), body.end());
    if (channel == std::size(channels)) {
      for (GeometryKind kind : {GeometryKind::Particles, GeometryKind::PathLines, GeometryKind::Triangles})
        unpack(scene, kind, message);
      unpackCells(scene, message);
      continue;
    }
    if (channels[channel] == Channel::Frame) shrink(message);
    ranks.send(to, channels[channel], std::move(message));
    ranks.step(30);
  }
  ranks.step(kSteps);
  return 0;
}
