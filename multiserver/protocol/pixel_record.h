// SPDX-License-Identifier: Apache-2.0
// Records of the pixel channel (docs/protocol.md, section 6).
#pragma once
#include <cstdint>
#include <span>

#include "core/comm/transport.h"

namespace gxy::protocol {

enum class PixelKind : uint32_t { Tile = 1, EndOfPass = 2, EndOfFrame = 3 };
enum class PixelEncoding : uint16_t { Raw = 0, Zstd = 1, Jpeg = 2, Zlib = 3 };
enum class PixelFormat : uint16_t { Rgba8 = 0, Rgb8 = 1 };

inline constexpr uint32_t kTileSide = 256;       // of tiles, unless a client asks for others
inline constexpr uint32_t kMostTileSide = 1024;  // of all that may come

/// The first 64 bytes of a record, as they are on the wire.
struct PixelHeader {
  PixelKind kind = PixelKind::Tile;
  uint32_t window = 0;
  uint64_t frame = 0;
  uint32_t width = 0, height = 0;  ///< size of the level's whole picture
  uint32_t scale = 1, pass = 0;
  uint32_t x = 0, y = 0, w = 0, h = 0;  ///< position and size of the tile
  PixelEncoding encoding = PixelEncoding::Raw;
  PixelFormat format = PixelFormat::Rgba8;
  uint32_t reserved = 0;
  uint64_t size = 0;  ///< bytes of data after the header
};
static_assert(sizeof(PixelHeader) == 64);

/// Makes a record from header and data. It sets `size`.
Bytes pixelRecord(PixelHeader header, std::span<const std::byte> data);

/// Returns the header of a record. Throws Error for a record that does not conform to section 6.
PixelHeader pixelHeader(std::span<const std::byte> record);
inline std::span<const std::byte> pixelData(std::span<const std::byte> record) {
  return record.subspan(sizeof(PixelHeader));
}

}  // namespace gxy::protocol
