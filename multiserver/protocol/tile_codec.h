// SPDX-License-Identifier: Apache-2.0
// Pixels of a tile, compressed and back. Rows bottom to top, without padding.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "multiserver/protocol/pixel_record.h"

namespace gxy::protocol {

/// 8 bits a channel.
struct TilePixels {
  PixelFormat format = PixelFormat::Rgba8;
  std::vector<uint8_t> bytes;
};

/// Data of a tile of w x h RGBA pixels. Jpeg alone is not lossless: it drops alpha after putting the pixels over black,
/// `quality` 1 to 100. Thread safe.
Bytes encodeTile(std::span<const uint8_t> rgba, uint32_t w, uint32_t h, PixelEncoding encoding, int quality);

/// The pixels of a tile from its record's data. Throws Error when they are not what the header says.
TilePixels decodeTile(const PixelHeader& header, std::span<const std::byte> data);

/// The format that an encoding has.
inline PixelFormat formatOf(PixelEncoding encoding) {
  return encoding == PixelEncoding::Jpeg ? PixelFormat::Rgb8 : PixelFormat::Rgba8;
}

}  // namespace gxy::protocol
