// SPDX-License-Identifier: Apache-2.0
// Messages of data connections, and a Receiver and a Conductor that get whatever they say.
#include <cstdint>
#include <span>

#include "core/comm/error.h"
#include "insitu/plan/blocks.h"
#include "insitu/plan/conductor.h"
#include "insitu/plan/description.h"
#include "insitu/plan/receiver.h"
#include "insitu/plan/records.h"

using namespace gxy;
using namespace gxy::insitu;

namespace {

void describe(std::span<const std::byte> bytes) {
  const Description d = readDescription(bytes);
  datasetsOf(d.meshes);
  for (size_t mesh = 0; mesh < d.meshes.size(); ++mesh) {
    if (d.meshes[mesh].kind != Mesh::Kind::Grid) continue;
    std::vector<Block> blocks;
    for (const Extent& e : d.parts[mesh].blocks) blocks.push_back({0, int(blocks.size()), e});
    checkCover(BlockSearch(blocks), d.meshes[mesh].grid.points);
  }
}

// What a rank of a simulation says that has a block of a grid, and particles.
Description gridAndParticles() {
  Description d;
  d.meshes.resize(2), d.parts.resize(2);
  d.meshes[0].name = "grid", d.meshes[0].fields = {{"pressure"}};
  d.meshes[0].grid.points = {4, 4, 4};
  d.parts[0].blocks = {{{0, 0, 0}, {4, 4, 4}}};
  d.meshes[1].name = "atoms", d.meshes[1].kind = Mesh::Kind::Points;
  return d;
}

// The bytes are events: a kind, a rank, and numbers.
void converse(std::span<const std::byte> bytes) {
  Conductor conductor(2, {0, 1});
  // Rank 0 sends two arrays of a grid, rank 1 two of particles.
  Receiver receiver({{{1, 12}, {2, 4}}, {{0, 4, 1, true}, {0, 2, 1}}});
  bool collecting = false;
  for (; bytes.size() >= 4; bytes = bytes.subspan(4)) {
    const auto at = [&](size_t i) { return uint64_t(bytes[i]); };
    const int rank = int(at(1) & 1);
    switch (at(0) % 12) {
      case 0:
        if (!collecting) conductor.begin(), receiver.open(), collecting = true;
        break;
      case 1:
        conductor.receive(rank, Control{Control::Kind(at(2) % 7), at(3), at(2)});
        break;
      case 2:
        conductor.receive(rank, StepHeader{at(2), int64_t(at(3)), 0});
        break;
      case 3:
        conductor.complete(rank, at(2));
        break;
      case 4:
        receiver.accept(rank, {at(2), at(3) % 16, at(1) / 64, uint32_t(at(3) / 16)}, at(1) / 2 % 32);
        break;
      case 5:
        if (collecting && conductor.isComplete() && receiver.take(conductor.last())) {
          conductor.published();
          receiver.close(conductor.last());
          collecting = false;
        }
        break;
      case 6:
        conductor.abandon(), receiver.close(at(2)), collecting = false;
        break;
      case 7:
        receiver.refuse(at(2));
        break;
      case 8:
        if (!collecting) conductor.look();
        break;
      case 9:
        conductor.again();
        break;
      case 10:
        if (!collecting) conductor.begin(at(2)), receiver.open(), collecting = true;
        break;
      default:
        conductor.missing();
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const std::span<const std::byte> bytes = std::as_bytes(std::span(data + 1, size - 1));
  try {
    switch (data[0] % 8) {
      case 0:
        describe(bytes);
        break;
      case 1:
        readDestinations(bytes, 0, gridAndParticles());
        break;
      case 2:
        readControl(bytes);
        break;
      case 3:
        readStep(bytes);
        break;
      case 4:
        readHello(bytes);
        break;
      case 5:
        readSteering(bytes);
        break;
      case 6:
        readMeshes(bytes);
        break;
      case 7:
        converse(bytes);
        break;
    }
  } catch (const Error&) {
    // refused
  }
  return 0;
}
