// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/canvas.h"

#include <algorithm>
#include <cstring>

#include "multiserver/protocol/tile_codec.h"
#include "tools/gxyviewer/upsample.h"

namespace gxy {

using protocol::PixelHeader;
using protocol::PixelKind;

void Canvas::resize(glm::ivec2 size) {
  if (size == size_) return;
  std::vector<uint8_t> stretched(size_t(size.x) * size_t(size.y) * 4);
  if (!shown_.empty())
    for (int y = 0; y < size.y; y++)
      for (int x = 0; x < size.x; x++) {
        const size_t fromX = size_t(x) * size_t(size_.x) / size_t(size.x);
        const size_t fromY = size_t(y) * size_t(size_.y) / size_t(size.y);
        std::memcpy(&stretched[(size_t(y) * size_t(size.x) + size_t(x)) * 4],
                    &shown_[(fromY * size_t(size_.x) + fromX) * 4], 4);
      }
  size_ = size;
  shown_ = std::move(stretched);
  gathered_.assign(shown_.size(), 0);
  shownFrame_ = 0;  // A frame of the new size starts with a hidden pass again.
}

bool Canvas::take(const PixelHeader& header, std::span<const std::byte> data) {
  const auto fits = [&](int whole, uint32_t level) {
    return (uint32_t(whole) + header.scale - 1) / header.scale == level;
  };
  if (header.frame < newestFrame_ || !fits(size_.x, header.width) || !fits(size_.y, header.height))
    return false;
  newestFrame_ = header.frame;
  const bool coarse = header.scale > 1, shown = shownFrame_ == header.frame;
  if (coarse) coarse_.resize(size_t(header.width) * header.height * 4);
  if (header.kind == PixelKind::Tile) {
    draw(header, data, coarse ? coarse_ : shown ? shown_ : gathered_);
    return shown && !coarse;
  }
  if (header.kind != PixelKind::EndOfPass || (shown && !coarse)) return false;
  if (coarse)
    upsample(coarse_, {header.width, header.height}, shown_, size_);
  else
    shown_.swap(gathered_);
  shownFrame_ = header.frame;
  return true;
}

void Canvas::draw(const PixelHeader& header, std::span<const std::byte> data, std::vector<uint8_t>& rgba) {
  const protocol::TilePixels tile = protocol::decodeTile(header, data);
  const size_t channels = tile.format == protocol::PixelFormat::Rgba8 ? 4 : 3;
  for (size_t row = 0; row < header.h; row++) {
    const uint8_t* from = &tile.bytes[row * header.w * channels];
    uint8_t* to = &rgba[((header.y + row) * header.width + header.x) * 4];
    for (size_t x = 0; x < header.w; x++, from += channels, to += 4) {
      std::memcpy(to, from, 3);
      to[3] = channels == 4 ? from[3] : uint8_t(255);
    }
  }
}

}  // namespace gxy
