// SPDX-License-Identifier: Apache-2.0
// Assembles a window's picture from its tiles (docs/protocol.md, section 6).
#pragma once
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "multiserver/protocol/pixel_record.h"

namespace gxy {

/// Shows a whole picture at any time. The first pass of a frame is collected in a hidden buffer and shown
/// when it is complete. After that, tiles of full resolution are shown one by one. A coarse level is shown as
/// a whole, interpolated linearly between the centres of its pixels. Not thread safe.
class Canvas {
 public:
  explicit Canvas(glm::ivec2 size) { resize(size); }

  /// Changes the size. The shown picture is stretched until pixels of the new size arrive. Pixels of other
  /// sizes are ignored.
  void resize(glm::ivec2 size);

  /// Takes a tile or the end of a pass. Frames older than the newest are ignored. Returns whether the shown
  /// picture has changed. Throws Error if the data do not fit the header.
  bool take(const protocol::PixelHeader& header, std::span<const std::byte> data);

  glm::ivec2 size() const { return size_; }
  /// The shown picture: RGBA, not premultiplied, rows bottom to top. It is transparent before the first frame.
  std::span<const uint8_t> rgba() const { return shown_; }
  /// The number of the shown frame; 0: none yet.
  uint64_t frame() const { return shownFrame_; }

 private:
  static void draw(const protocol::PixelHeader& header, std::span<const std::byte> data,
                   std::vector<uint8_t>& rgba);

  glm::ivec2 size_{0};
  std::vector<uint8_t> shown_, gathered_;
  std::vector<uint8_t> coarse_;  ///< pixels of the coarse level that is arriving
  uint64_t shownFrame_ = 0, newestFrame_ = 0;
};

}  // namespace gxy
