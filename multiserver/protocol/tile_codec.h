// SPDX-License-Identifier: Apache-2.0
// Compresses and decompresses the pixels of a tile. Rows are bottom to top, without padding.
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

/// Returns the data of a tile of w x h RGBA pixels. All encodings but Jpeg are lossless. Jpeg blends the
/// pixels over black and drops alpha; its `quality` is 1 to 100. Thread safe.
Bytes encodeTile(std::span<const uint8_t> rgba, uint32_t w, uint32_t h, PixelEncoding encoding, int quality);

/// Returns the pixels of a tile from its record's data. Throws Error if the data do not fit the header.
TilePixels decodeTile(const PixelHeader& header, std::span<const std::byte> data);

/// Returns the pixel format of an encoding.
inline PixelFormat formatOf(PixelEncoding encoding) {
  return encoding == PixelEncoding::Jpeg ? PixelFormat::Rgb8 : PixelFormat::Rgba8;
}

}  // namespace gxy::protocol
