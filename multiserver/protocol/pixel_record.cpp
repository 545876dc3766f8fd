// SPDX-License-Identifier: Apache-2.0
#include "multiserver/protocol/pixel_record.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "core/comm/error.h"

namespace gxy::protocol {

Bytes pixelRecord(PixelHeader header, std::span<const std::byte> data) {
  header.size = data.size();
  Bytes record(sizeof header + data.size());
  std::memcpy(record.data(), &header, sizeof header);
  std::copy(data.begin(), data.end(), record.begin() + sizeof header);
  return record;
}

PixelHeader pixelHeader(std::span<const std::byte> record) {
  PixelHeader h;
  if (record.size() < sizeof h)
    throw Error("pixel record of " + std::to_string(record.size()) + " bytes, expected 64 or more");
  std::memcpy(&h, record.data(), sizeof h);
  const bool tile = h.kind == PixelKind::Tile;
  const bool fits = tile ? h.w >= 1 && h.h >= 1 && h.w <= kMostTileSide && h.h <= kMostTileSide &&
                               h.x <= h.width && h.y <= h.height && h.w <= h.width - h.x &&
                               h.h <= h.height - h.y
                         : (h.x | h.y | h.w | h.h) == 0;
  if (h.kind < PixelKind::Tile || h.kind > PixelKind::EndOfFrame || h.encoding > PixelEncoding::Zlib ||
      h.format > PixelFormat::Rgb8 || h.scale == 0 || h.size != record.size() - sizeof h || !fits)
    throw Error("pixel record of window " + std::to_string(h.window) + ", frame " + std::to_string(h.frame) +
                ": its header is not one that a server sends");
  return h;
}

}  // namespace gxy::protocol
