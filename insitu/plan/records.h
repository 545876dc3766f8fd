// SPDX-License-Identifier: Apache-2.0
// The messages of data connections between a simulation and a server (docs/protocol.md, section 10).
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/comm/transport.h"
#include "insitu/plan/redistribution.h"

namespace gxy::insitu {

/// What proves that a connection belongs to a stream.
using Ticket = std::array<uint8_t, 32>;

/// What stands in the header of each piece of a connection.
enum class Checksum : uint32_t {
  None,    ///< nothing
  Crc32c,  ///< the CRC-32C of its samples (core/comm/crc32c.h)
};

/// The first message of a data connection.
struct Hello {
  uint64_t stream = 0;
  Ticket ticket{};
  uint32_t rank = 0;  ///< of the simulation
  Checksum checksum = Checksum::None;
};
Bytes written(const Hello& hello);
/// Throws Error for a checksum that there is not.
Hello readHello(std::span<const std::byte> message);

/// Where the points of one rank of the simulation go from publish `from` on. Rank 0 of the server answers descriptions with it.
Bytes written(uint64_t from, const std::vector<Destination>& destinations);
/// Removes `from` from the front of such a message.
uint64_t takeFrom(std::span<const std::byte>& message);
/// Reads the rest of it. Throws Error unless each piece is inside the block of `mine` that it names, and there are no more points than in the blocks, and
/// the particles or cells of a mesh go to one place only.
std::vector<Destination> readDestinations(std::span<const std::byte> message, int rank,
                                          const Description& mine);

/// One array of a piece, which is sent in one go.
struct Item {
  uint64_t points = 0;  ///< of a grid
  uint64_t bytesPerPoint = 0;
  int number = -1;     ///< of other meshes: which of the step's Counts says how many entries it has
  bool first = false;  ///< it is the first with this number, so its header says how many there are
};
/// Returns the items of pieces in the order in which they are sent: all arrays of the first piece (arraysOf), then those of the next.
std::vector<Item> itemsOf(std::span<const Piece> pieces, std::span<const Mesh> meshes);

/// A bye that begins so says that the simulation itself has closed the stream, so that no rank of it needs to come again.
inline constexpr const char* kClosedBy = "closed by rank ";

/// Messages about appointments between rank 0 of the server and a rank of the simulation. Counts are those of publishes.
struct Control {
  enum class Kind : uint8_t {
    AskNewest,  ///< from the server: how many publishes have there been?
    Newest,     ///< to the server: `newest`
    Appoint,    ///< from the server: take publish `count`
    Missed,     ///< to the server: publish `count` could not be taken; there have been `newest`
    Cancel,     ///< from the server: forget the appointment `count`
    Published,  ///< from the server: the step of publish `count` is published
    Waits,  ///< to the server: the rank waits until publish `count` is appointed; 0: it will wait for its publishes
  };
  Kind kind = Kind::AskNewest;
  uint64_t count = 0, newest = 0;
  bool operator==(const Control&) const = default;
};
Bytes written(const Control& control);
Control readControl(std::span<const std::byte> message);

/// The parameters that somebody has steered, by name. Rank 0 of the server tells them before an appointment.
using Steering = std::map<std::string, double>;
inline constexpr size_t kMostSteerable = 64;
Bytes written(const Steering& steering);
/// Throws Error for more than kMostSteerable, and for values that are not finite.
Steering readSteering(std::span<const std::byte> message);

/// What rank 0 of the server is told of a step that a rank of the simulation has taken.
struct StepHeader {
  uint64_t count = 0;
  int64_t step = 0;
  double time = 0;
  bool operator==(const StepHeader&) const = default;
};
Bytes written(const StepHeader& step);
StepHeader readStep(std::span<const std::byte> message);

/// What stands before the samples of a chunk. An item (itemsOf) is sent in chunks, from its begin to its end. An item without
/// entries, which only particles and cells have, is one chunk without samples.
struct PieceHeader {
  uint64_t count = 0;   ///< the publish that it belongs to
  uint64_t offset = 0;  ///< in bytes, from the begin of the item
  uint64_t points = 0;  ///< of the item; or cells or corners, if it has values of them
  uint32_t item = 0;
  uint32_t checksum = 0;  ///< of the samples of the chunk, as the hello says; else it means nothing
  bool operator==(const PieceHeader&) const = default;
};
inline constexpr size_t kPieceHeaderBytes = 32;
std::array<std::byte, kPieceHeaderBytes> written(const PieceHeader& header);
/// Removes the header from the front of a message.
PieceHeader takePieceHeader(std::span<const std::byte>& message);

}  // namespace gxy::insitu
