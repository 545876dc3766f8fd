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
  std::vector<Block> blocks;
  for (const Extent& e : d.blocks) blocks.push_back({0, int(blocks.size()), e});
  checkCover(BlockSearch(blocks), d.mesh.grid.points);
}

// The bytes are events: a kind, a rank, and numbers.
void converse(std::span<const std::byte> bytes) {
  Conductor conductor(2, {0, 1});
  Receiver receiver({{{8, 12}, {4, 4}}, {{}, {}}});
  bool collecting = false;
  for (; bytes.size() >= 4; bytes = bytes.subspan(4)) {
    const auto at = [&](size_t i) { return uint64_t(bytes[i]); };
    const int rank = int(at(1) & 1);
    switch (at(0) % 8) {
      case 0:
        if (!collecting) conductor.begin(), receiver.open(), collecting = true;
        break;
      case 1:
        conductor.receive(rank, Control{Control::Kind(at(2) % 6), at(3), at(2)});
        break;
      case 2:
        conductor.receive(rank, StepHeader{at(2), int64_t(at(3)), 0});
        break;
      case 3:
        conductor.complete(rank, at(2));
        break;
      case 4:
        receiver.accept(rank, {at(2), at(3) % 16, uint32_t(at(3) / 16), 0}, at(1) / 2);
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
    const Extent block{{0, 0, 0}, {4, 4, 4}};
    if (data[0] % 6 == 0) describe(bytes);
    if (data[0] % 6 == 1) readDestinations(bytes, 0, std::span(&block, 1));
    if (data[0] % 6 == 2) readControl(bytes);
    if (data[0] % 6 == 3) readStep(bytes);
    if (data[0] % 6 == 4) readHello(bytes);
    if (data[0] % 6 == 5) converse(bytes);
  } catch (const Error&) {
    // refused
  }
  return 0;
}
