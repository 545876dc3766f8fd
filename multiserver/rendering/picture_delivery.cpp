// SPDX-License-Identifier: Apache-2.0
#include "multiserver/rendering/picture_delivery.h"

#include <algorithm>
#include <cstring>

#include "core/comm/error.h"
#include "core/comm/parallel_for.h"
#include "core/comm/wire.h"
#include "core/image/image.h"
#include "multiserver/protocol/tile_codec.h"

namespace gxy {

namespace {

enum class Piece : uint8_t { Tile, Sums, Depth, Bytes, All };

void writeOverlay(Writer& w, const Overlay& overlay) {
  w.write(overlay.lines);
  w.write(uint64_t(overlay.bars.size()));
  for (const Overlay::Bar& bar : overlay.bars) w.write(bar.lo).write(bar.hi).write(bar.colors);
  w.write(uint64_t(overlay.texts.size()));
  for (const Overlay::Text& t : overlay.texts)
    w.write(t.at).write(t.anchor).write(int32_t(t.height)).write(t.text);
}

Overlay readOverlay(Reader& in) {
  Overlay overlay;
  overlay.lines = in.readVector<Overlay::Line>();
  for (auto n = in.read<uint64_t>(); n > 0; n--) {
    Overlay::Bar& bar = overlay.bars.emplace_back();
    bar.lo = in.read<glm::dvec2>();
    bar.hi = in.read<glm::dvec2>();
    bar.colors = in.readVector<glm::dvec3>();
  }
  for (auto n = in.read<uint64_t>(); n > 0; n--) {
    Overlay::Text& t = overlay.texts.emplace_back();
    t.at = in.read<glm::dvec2>();
    t.anchor = in.read<glm::dvec2>();
    t.height = in.read<int32_t>();
    t.text = in.readString();
  }
  return overlay;
}

}  // namespace

std::vector<Bytes> tilesOfPicture(const Picture& picture, protocol::PixelEncoding encoding, int quality,
                                  uint32_t side) {
  const auto width = uint32_t(picture.width), height = uint32_t(picture.height);
  const uint32_t across = (width + side - 1) / side, up = (height + side - 1) / side;
  std::vector<Bytes> tiles(size_t(across) * up);
  parallelFor(size_t(0), tiles.size(), [&](size_t i) {
    protocol::PixelHeader header;
    header.width = width;
    header.height = height;
    header.x = uint32_t(i % across) * side;
    header.y = uint32_t(i / across) * side;
    header.w = std::min(side, width - header.x);
    header.h = std::min(side, height - header.y);
    header.encoding = encoding;
    header.format = protocol::formatOf(encoding);
    std::vector<float> rgba;
    rgba.reserve(size_t(header.w) * header.h * 4);
    for (uint32_t y = header.y; y < header.y + header.h; y++) {
      const float* row = &picture.rgba[(size_t(y) * width + header.x) * 4];
      rgba.insert(rgba.end(), row, row + size_t(header.w) * 4);
    }
    tiles[i] = protocol::pixelRecord(
        header, protocol::encodeTile(eightBits(rgba), header.w, header.h, encoding, quality));
  });
  return tiles;
}

/// Runs on the owner of a frame and sends its picture to rank 0. There, the ticket leads to the receiver.
class PictureDelivery::Operation final : public PictureOperation {
 public:
  Operation(PictureDelivery& pictures, uint64_t ticket, PictureFormat wanted)
      : pictures_(pictures), ticket_(ticket), wanted_(std::move(wanted)) {}
  Operation(PictureDelivery& pictures, Reader& in) : pictures_(pictures), ticket_(in.read<uint64_t>()) {
    wanted_.as = in.read<PictureFormat::As>();
    if (wanted_.as > PictureFormat::As::File)
      in.fail("a picture as " + std::to_string(int(wanted_.as)) + ", expected a kind of PictureFormat");
    wanted_.encoding = in.read<protocol::PixelEncoding>();
    if (wanted_.encoding > protocol::PixelEncoding::Zlib)
      in.fail("encoding " + std::to_string(int(wanted_.encoding)) + ", expected one of the protocol's");
    wanted_.quality = in.read<int32_t>();
    wanted_.tile = in.read<uint32_t>();
    if (wanted_.tile == 0 || wanted_.tile > protocol::kMostTileSide)
      in.fail("tiles of " + std::to_string(wanted_.tile) + " pixels a side, expected 1 to " +
              std::to_string(protocol::kMostTileSide));
    wanted_.format = in.readString();
    wanted_.path = in.readString();
    wanted_.depthPath = in.readString();
    wanted_.overlay = readOverlay(in);
  }
  void write(Writer& w) const override {
    w.write(ticket_).write(wanted_.as).write(wanted_.encoding).write(int32_t(wanted_.quality));
    w.write(wanted_.tile);
    w.write(wanted_.format).write(wanted_.path).write(wanted_.depthPath);
    writeOverlay(w, wanted_.overlay);
  }
  void run(Picture picture) const override { pictures_.deliver(ticket_, wanted_, std::move(picture)); }

 private:
  PictureDelivery& pictures_;
  const uint64_t ticket_;
  PictureFormat wanted_;
};

PictureDelivery::PictureDelivery(ServerRank& serverRank) : serverRank_(serverRank) {
  serverRank_.renderer.onOperation(
      [this](Reader& in) { return std::make_shared<const Operation>(*this, in); });
  if (serverRank_.rank() == 0)
    serverRank_.transport.onMessage(Channel::Pictures,
                                    [this](int, Bytes message) { receive(std::move(message)); });
}

PictureDelivery::~PictureDelivery() {
  serverRank_.renderer.onOperation({});
  if (serverRank_.rank() == 0) serverRank_.transport.onMessage(Channel::Pictures, {});
}

FrameId PictureDelivery::start(FrameRequest request, const PictureFormat& wanted, PictureReceiver receiver) {
  const auto expected = std::make_shared<Expected>();
  expected->receiver = std::move(receiver);
  uint64_t ticket;
  {
    const std::lock_guard lock(mutex_);
    ticket = nextTicket_++;
    expected_[ticket] = expected;
  }
  request.operation = std::make_shared<const Operation>(*this, ticket, wanted);
  request.sums = wanted.as == PictureFormat::As::Sums;
  request.depth = wanted.as == PictureFormat::As::Depth || !wanted.depthPath.empty();
  try {
    return serverRank_.renderer.render(
        request, [this, ticket](FrameId, const Renderer::Ending& ending) { onFinished(ticket, ending); });
  } catch (const Error&) {
    const std::lock_guard lock(mutex_);
    expected_.erase(ticket);
    throw;
  }
}

// On the owner, as a task.
void PictureDelivery::deliver(uint64_t ticket, const PictureFormat& wanted, Picture picture) {
  uint64_t pieces = 0;
  std::string error;
  try {
    pieces = sendPieces(ticket, wanted, std::move(picture));
  } catch (const std::exception& e) {
    error = "rank " + std::to_string(serverRank_.rank()) + ": " + e.what();
  }
  Writer w;
  serverRank_.transport.send(0, Channel::Pictures,
                             w.write(ticket).write(Piece::All).write(pieces).write(error).take());
}

uint64_t PictureDelivery::sendPieces(uint64_t ticket, const PictureFormat& wanted, Picture picture) {
  const auto send = [&](Piece piece, std::span<const std::byte> content) {
    Writer w;
    w.write(ticket).write(piece).write(int32_t(picture.width)).write(int32_t(picture.height)).write(content);
    serverRank_.transport.send(0, Channel::Pictures, w.take());
  };
  if (wanted.as == PictureFormat::As::Tiles) {
    const std::vector<Bytes> tiles = tilesOfPicture(picture, wanted.encoding, wanted.quality, wanted.tile);
    for (const Bytes& tile : tiles) send(Piece::Tile, tile);
    return tiles.size();
  }
  if (wanted.as == PictureFormat::As::Sums) {
    send(Piece::Sums, std::as_bytes(std::span(picture.sums)));
    return 1;
  }
  if (wanted.as == PictureFormat::As::Depth) {
    send(Piece::Depth, std::as_bytes(std::span(picture.depth)));
    return 1;
  }
  if (!wanted.depthPath.empty())
    serverRank_.folders.write(wanted.depthPath, encodeDepth(picture.width, picture.height, picture.depth));
  Image image{picture.width, picture.height, std::move(picture.rgba)};
  draw(wanted.overlay, image);
  const Bytes content = encodeImage(wanted.format, image);
  if (wanted.as == PictureFormat::As::Bytes) {
    send(Piece::Bytes, content);
    return 1;
  }
  serverRank_.folders.write(wanted.path, content);
  return 0;
}

PictureDelivery::ExpectedPtr PictureDelivery::find(uint64_t ticket) const {
  const std::lock_guard lock(mutex_);
  const auto at = expected_.find(ticket);
  return at == expected_.end() ? nullptr : at->second;
}

void PictureDelivery::receive(Bytes message) {
  Reader in(message, "picture");
  const auto ticket = in.read<uint64_t>();
  const auto piece = in.read<Piece>();
  const ExpectedPtr expected = find(ticket);
  if (!expected) return;
  if (piece == Piece::All) {
    std::unique_lock lock(mutex_);
    expected->announced = in.read<uint64_t>();
    expected->error = in.readString();
    expected->told = true;
    return conclude(ticket, lock);
  }
  if (piece == Piece::Tile) return receivePiece(ticket, *expected, message);
  serverRank_.transport.post([this, ticket, expected, message = std::move(message)] {  // a whole picture
    receivePiece(ticket, *expected, message);
  });
}

void PictureDelivery::receivePiece(uint64_t ticket, Expected& expected, const Bytes& message) {
  Reader in(message, "picture");
  in.read<uint64_t>();
  const auto piece = in.read<Piece>();
  const int width = in.read<int32_t>(), height = in.read<int32_t>();
  const auto size = in.read<uint64_t>();
  const std::span<const std::byte> content = in.rest();
  if (content.size() != size)
    in.fail(std::to_string(content.size()) + " bytes follow, expected " + std::to_string(size));
  const PictureReceiver& receiver = expected.receiver;
  if (piece == Piece::Tile && receiver.tile) receiver.tile({content.begin(), content.end()});
  if (piece == Piece::Bytes && receiver.bytes) receiver.bytes({content.begin(), content.end()});
  if (piece == Piece::Depth && receiver.depth) {
    std::vector<double> depth(content.size() / sizeof(double));
    std::memcpy(depth.data(), content.data(), depth.size() * sizeof(double));
    receiver.depth(depth);
  }
  if (piece == Piece::Sums && receiver.sums) {
    Picture picture{width, height, {}, {}, LargeVector<int64_t>(size / sizeof(int64_t))};
    std::memcpy(picture.sums.data(), content.data(), picture.sums.size() * sizeof(int64_t));
    receiver.sums(std::move(picture));
  }
  std::unique_lock lock(mutex_);
  expected.pieces++;
  conclude(ticket, lock);
}

void PictureDelivery::onFinished(uint64_t ticket, const Renderer::Ending& ending) {
  std::unique_lock lock(mutex_);
  const auto at = expected_.find(ticket);
  if (at == expected_.end()) return;
  const ExpectedPtr expected = at->second;
  if (ending.hasPicture()) {
    expected->finished = true;
    return conclude(ticket, lock);
  }
  expected_.erase(at);
  lock.unlock();
  expected->receiver.done(ending.superseded, ending.superseded ? std::string() : ending.error);
}

void PictureDelivery::conclude(uint64_t ticket, std::unique_lock<std::mutex>& lock) {
  const auto at = expected_.find(ticket);
  if (at == expected_.end()) return;
  const ExpectedPtr expected = at->second;
  if (!expected->finished || !expected->told ||
      (expected->error.empty() && expected->pieces < expected->announced))
    return;
  expected_.erase(at);
  lock.unlock();
  serverRank_.transport.post([expected] { expected->receiver.done(false, expected->error); });
}

}  // namespace gxy
