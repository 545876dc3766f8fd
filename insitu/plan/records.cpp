// SPDX-License-Identifier: Apache-2.0
#include "insitu/plan/records.h"

#include <cmath>
#include <cstring>

#include "core/comm/error.h"
#include "core/comm/wire.h"
#include "insitu/plan/description.h"

namespace gxy::insitu {

namespace {

// A destination on the wire: its rank, and how many of the pieces that follow are for it.
struct WireDestination {
  int32_t owner;
  uint32_t pieces;
};
struct WirePiece {
  int32_t mesh, block, partition, reserved;
  Extent points;
};

template <class Record>
Record readOne(std::span<const std::byte> message, const char* what) {
  Reader r(message, what);
  const auto record = r.read<Record>();
  r.expectEnd();
  return record;
}

bool isInside(const Extent& part, const Extent& whole) {
  for (size_t a = 0; a < 3; a++)
    if (part.points[a] < 1 || part.first[a] < whole.first[a] ||
        part.points[a] > whole.points[a] - (part.first[a] - whole.first[a]))
      return false;
  return true;
}

}  // namespace

Bytes written(const Hello& hello) {
  return Writer().write(hello.stream).write(hello.ticket).write(hello.rank).write(hello.checksum).take();
}

Hello readHello(std::span<const std::byte> message) {
  Reader r(message, "hello of a data connection");
  Hello hello;
  hello.stream = r.read<uint64_t>();
  hello.ticket = r.read<Ticket>();
  hello.rank = r.read<uint32_t>();
  const auto checksum = r.read<uint32_t>();
  if (checksum > uint32_t(Checksum::Crc32c))
    r.fail("checksum " + std::to_string(checksum) + ", expected 0 or 1");
  hello.checksum = Checksum(checksum);
  r.expectEnd();
  return hello;
}

Bytes written(uint64_t from, const std::vector<Destination>& destinations) {
  std::vector<WireDestination> heads;
  std::vector<WirePiece> pieces;
  for (const Destination& d : destinations) {
    heads.push_back({d.owner, uint32_t(d.pieces.size())});
    for (const Piece& p : d.pieces) pieces.push_back({p.mesh, p.block, p.partition, 0, p.points});
  }
  return Writer().write(from).write(heads).write(pieces).take();
}

uint64_t takeFrom(std::span<const std::byte>& message) {
  const auto from = Reader(message, "plan of a stream").read<uint64_t>();
  message = message.subspan(sizeof from);
  return from;
}

std::vector<Destination> readDestinations(std::span<const std::byte> message, int rank,
                                          const Description& mine) {
  Reader r(message, "plan of a stream");
  const auto heads = r.readVector<WireDestination>();
  const auto pieces = r.readVector<WirePiece>();
  r.expectEnd();
  std::vector<int64_t> left;  // points by mesh; of others than grids, the pieces
  for (size_t m = 0; m < mine.meshes.size(); m++) {
    left.push_back(mine.meshes[m].kind == Mesh::Kind::Grid ? 0 : 1);
    for (const Extent& block : mine.parts[m].blocks) left.back() += block.count();
  }
  const auto check = [&](const WirePiece& p) {
    if (p.mesh < 0 || size_t(p.mesh) >= mine.meshes.size()) r.fail("a piece of a mesh that there is not");
    const auto& blocks = mine.parts[size_t(p.mesh)].blocks;
    const bool isGrid = mine.meshes[size_t(p.mesh)].kind == Mesh::Kind::Grid;
    if (isGrid &&
        (p.block < 0 || size_t(p.block) >= blocks.size() || !isInside(p.points, blocks[size_t(p.block)])))
      r.fail("a piece outside the blocks of this rank");
    if (!isGrid && (p.block != 0 || p.partition != -1 || p.points != Extent{}))
      r.fail("a piece of particles or cells with points of a grid");
    left[size_t(p.mesh)] -= isGrid ? p.points.count() : 1;
    if (left[size_t(p.mesh)] < 0) r.fail("more points than this rank has");
  };
  std::vector<Destination> destinations;
  size_t next = 0;
  for (const WireDestination& head : heads) {
    if (head.pieces > pieces.size() - next) r.fail("fewer pieces than announced");
    Destination d{head.owner, {}};
    for (uint32_t i = 0; i < head.pieces; i++) {
      const WirePiece& p = pieces[next++];
      check(p);
      d.pieces.push_back({rank, p.block, head.owner, p.partition, p.points, p.mesh});
    }
    destinations.push_back(std::move(d));
  }
  if (next != pieces.size()) r.fail("more pieces than announced");
  return destinations;
}

std::vector<Item> itemsOf(std::span<const Piece> pieces, std::span<const Mesh> meshes) {
  std::vector<Item> items;
  for (const Piece& piece : pieces) {
    const Mesh& mesh = meshes[size_t(piece.mesh)];
    const bool isGrid = mesh.kind == Mesh::Kind::Grid;
    int before = -1;
    for (const Array& array : arraysOf(mesh)) {
      const int number = isGrid ? -1 : int(placeOf(size_t(piece.mesh), array.per));
      items.push_back({uint64_t(piece.points.count()), array.bytesPerPoint(), number, number != before});
      before = number;
    }
  }
  return items;
}

Bytes written(const Control& control) {
  return Writer().write(uint8_t(control.kind)).write(control.count).write(control.newest).take();
}

Control readControl(std::span<const std::byte> message) {
  Reader r(message, "control message");
  const auto kind = r.read<uint8_t>();
  if (kind > uint8_t(Control::Kind::Waits)) r.fail("kind " + std::to_string(int(kind)) + ", expected 0 to 6");
  Control control{Control::Kind(kind), r.read<uint64_t>(), 0};
  control.newest = r.read<uint64_t>();
  r.expectEnd();
  return control;
}

Bytes written(const Steering& steering) {
  Writer w;
  w.write(uint32_t(steering.size()));
  for (const auto& [name, value] : steering) w.write(name).write(value);
  return w.take();
}

Steering readSteering(std::span<const std::byte> message) {
  Reader r(message, "steered parameters");
  const auto count = r.read<uint32_t>();
  if (count > kMostSteerable) r.fail(std::to_string(count) + " parameters, expected at most 64");
  Steering steering;
  for (uint32_t i = 0; i < count; i++) {
    const std::string name = r.readString();
    const auto value = r.read<double>();
    if (!std::isfinite(value)) r.fail("a value that is not finite");
    steering[name] = value;
  }
  r.expectEnd();
  return steering;
}

Bytes written(const StepHeader& step) { return Writer().write(step).take(); }

StepHeader readStep(std::span<const std::byte> message) { return readOne<StepHeader>(message, "step"); }

std::array<std::byte, kPieceHeaderBytes> written(const PieceHeader& header) {
  static_assert(sizeof header == kPieceHeaderBytes);
  std::array<std::byte, kPieceHeaderBytes> bytes;
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}

PieceHeader takePieceHeader(std::span<const std::byte>& message) {
  if (message.size() < kPieceHeaderBytes)
    throw Error("piece of a step: " + std::to_string(message.size()) + " bytes, expected a header of " +
                std::to_string(kPieceHeaderBytes));
  PieceHeader header;
  std::memcpy(&header, message.data(), sizeof header);
  message = message.subspan(kPieceHeaderBytes);
  return header;
}

}  // namespace gxy::insitu
