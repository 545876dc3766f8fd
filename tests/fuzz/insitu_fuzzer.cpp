// SPDX-License-Identifier: Apache-2.0
// Messages of data connections, cells, and a Receiver and a Conductor that get whatever they say.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "core/comm/error.h"
#include "core/data/cells.h"
#include "insitu/plan/blocks.h"
#include "insitu/plan/cells.h"
#include "insitu/plan/conductor.h"
#include "insitu/plan/description.h"
#include "insitu/plan/encodings.h"
#include "insitu/plan/receiver.h"
#include "insitu/plan/records.h"
#include "tests/insitu/planned.h"

using namespace gxy;
using namespace gxy::insitu;

namespace {

void describe(std::span<const std::byte> bytes) {
  const Description d = readDescription(bytes);
  datasetsOf(d.meshes);
  itemsOf({}, d.meshes);
  std::vector<Mesh> meshes = d.meshes;
  mergeMeshes(meshes, d.meshes, 1);
  for (size_t mesh = 0; mesh < d.meshes.size(); ++mesh) {
    if (d.meshes[mesh].kind != Mesh::Kind::Grid) continue;
    std::vector<Block> blocks;
    for (const Extent& e : d.parts[mesh].blocks) blocks.push_back({0, int(blocks.size()), e});
    checkCover(BlockSearch(blocks), d.meshes[mesh].grid.points);
  }
}

// What a rank of a simulation says that has a block of a grid, particles and cells.
Description allKinds() {
  Description d;
  d.meshes.resize(3), d.parts.resize(3);
  d.meshes[0].name = "grid", d.meshes[0].fields = {{"pressure"}, {"heat", ScalarType::Float64}};
  d.meshes[0].grid.points = {4, 4, 4};
  d.parts[0].blocks = {{{0, 0, 0}, {4, 4, 4}}};
  d.meshes[1].name = "atoms", d.meshes[1].kind = Mesh::Kind::Points;
  d.meshes[2].name = "surface", d.meshes[2].kind = Mesh::Kind::Cells;
  return d;
}

// The bytes are the number of points, that of cells, their types, their ends, and the points of corners. Cells that are taken become
// primitives whose points are there.
void show(std::span<const std::byte> bytes) {
  if (bytes.size() < 2) return;
  const auto take = [&](size_t n) {
    std::vector<uint32_t> numbers;
    for (size_t i = 0; i < std::min(n, bytes.size()); i++)
      numbers.push_back(bytes[i] == std::byte(255) ? kNoPlace : uint32_t(bytes[i]));
    bytes = bytes.subspan(numbers.size());
    return numbers;
  };
  const std::vector<uint32_t> sizes = take(2);
  const std::vector<uint32_t> kinds = take(std::min<size_t>(sizes[1] % 32, bytes.size() / 2));
  const std::vector<uint8_t> types(kinds.begin(), kinds.end());
  const std::vector<uint32_t> ends = take(types.size());
  const std::vector<uint32_t> connectivity = take(bytes.size());
  GeometryBlock block;
  for (uint32_t i = 0; i < sizes[0] % 64; i++)
    block.points.push_back({i == 3 ? NAN : double(i % 5), double(i % 7), double(i % 3)});
  const Cells cells{block.points.size(), types, ends, connectivity};
  const Mesh::Shape shape =
      check(cells, Mesh::Shape::Unknown, "fuzz", [&](size_t point) { return block.points[point]; });
  for (size_t c = 0; c < cells.count(); c++)
    if (shape == Mesh::Shape::Lines)
      appendLine(cells.corners(c), block);
    else if (cells.corners(c).size() > 2)
      appendTriangles(DrawnCellType(types[c]), cells.corners(c), block);
  const GeometryKind kind = shape == Mesh::Shape::Lines ? GeometryKind::PathLines : GeometryKind::Triangles;
  block.ids.resize(insitu::primitivesOf(cells));
  validate(block, kind);
  dropUnusable(block, kind);
}

void readPlan(std::span<const std::byte> bytes) {
  takeFrom(bytes);
  readDestinations(bytes, 0, allKinds());
}

// The bytes are events: a kind, a rank, and numbers.
void converse(std::span<const std::byte> bytes) {
  Conductor conductor = test::planned(2, {0, 1});
  // Rank 0 sends two arrays of a grid, rank 1 two of particles, and three of cells.
  Receiver receiver(
      {{{1, 12}, {2, 4}}, {{0, 4, 1, true}, {0, 2, 1}, {0, 4, 2, true}, {0, 1, 3, true}, {0, 4, 4, true}}});
  bool collecting = false;
  for (; bytes.size() >= 4; bytes = bytes.subspan(4)) {
    const auto at = [&](size_t i) { return uint64_t(bytes[i]); };
    const int rank = int(at(1) & 1);
    switch (at(0) % 14) {
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
      case 11:
        conductor.describe(rank, at(2));
        break;
      case 12:
        if (conductor.needsPlan() && conductor.canPlan()) conductor.plan(conductor.described(), {rank});
        break;
      default:
        conductor.missing(), conductor.isHeldUp();
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const std::span<const std::byte> bytes = std::as_bytes(std::span(data + 1, size - 1));
  try {
    switch (data[0] % 10) {
      case 0:
        describe(bytes);
        break;
      case 1:
        readPlan(bytes);
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
      case 8:
        show(bytes);
        break;
      case 9:
        readEncodings(bytes, allKinds().meshes);
        break;
    }
  } catch (const Error&) {
    // refused
  }
  return 0;
}
