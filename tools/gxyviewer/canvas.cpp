// SPDX-License-Identifier: Apache-2.0
#include "canvas.h"

#include <algorithm>
#include <cstring>

#include "gxy/protocol/tile_codec.h"

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
  shownFrame_ = 0;  // a frame of the new size begins anew
}

bool Canvas::take(const PixelHeader& header, std::span<const std::byte> data) {
  const auto fits = [&](int whole, uint32_t level) {
    return (uint32_t(whole) + header.scale - 1) / header.scale == level;
  };
  if (header.frame < newestFrame_ || !fits(size_.x, header.width) || !fits(size_.y, header.height))
    return false;
  newestFrame_ = header.frame;
  if (header.kind == PixelKind::Tile) {
    draw(header, data, shownFrame_ == header.frame ? shown_ : gathered_);
    return shownFrame_ == header.frame;
  }
  if (header.kind != PixelKind::EndOfPass || shownFrame_ == header.frame) return false;
  shown_.swap(gathered_);
  shownFrame_ = header.frame;
  return true;
}

void Canvas::draw(const PixelHeader& header, std::span<const std::byte> data, std::vector<uint8_t>& rgba) {
  const protocol::TilePixels tile = protocol::decodeTile(header, data);
  const size_t channels = tile.format == protocol::PixelFormat::Rgba8 ? 4 : 3;
  const size_t width = size_t(size_.x), height = size_t(size_.y), scale = header.scale;
  const size_t left = header.x * scale, right = std::min(width, (size_t(header.x) + header.w) * scale);
  for (size_t row = 0; row < header.h; row++) {
    const size_t bottom = (header.y + row) * scale, top = std::min(height, bottom + scale);
    uint8_t* const first = &rgba[(bottom * width + left) * 4];
    const uint8_t* const source = &tile.bytes[row * header.w * channels];
    for (size_t x = 0; x < right - left; x++) {
      const uint8_t* const pixel = source + x / scale * channels;
      const uint8_t value[4] = {pixel[0], pixel[1], pixel[2], channels == 4 ? pixel[3] : uint8_t(255)};
      std::memcpy(first + x * 4, value, 4);
    }
    for (size_t y = bottom + 1; y < top; y++)
      std::memcpy(&rgba[(y * width + left) * 4], first, (right - left) * 4);
  }
}

}  // namespace gxy
