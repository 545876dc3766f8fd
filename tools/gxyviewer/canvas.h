// SPDX-License-Identifier: Apache-2.0
// The picture that a window's tiles have made so far. docs/protocol.md section 6.
#pragma once
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "multiserver/protocol/pixel_record.h"

namespace gxy {

/// Shows one whole picture at any time: a frame's first pass is gathered out of sight and shown when it is complete; from then
/// on tiles of full resolution take their places one by one. A coarse level is shown as a whole, interpolated linearly between
/// the middles of its pixels. Not thread safe.
class Canvas {
 public:
  explicit Canvas(glm::ivec2 size) { resize(size); }

  /// What is shown is stretched until pixels of the new size arrive; those of another size are not taken.
  void resize(glm::ivec2 size);

  /// Takes a tile or the end of a pass; older frames than the newest are ignored. True if what is shown has changed.
  /// Throws Error for data that are not what their header says.
  bool take(const protocol::PixelHeader& header, std::span<const std::byte> data);

  glm::ivec2 size() const { return size_; }
  /// RGBA, not premultiplied, rows bottom to top. Transparent before the first frame.
  std::span<const uint8_t> rgba() const { return shown_; }
  /// The frame that is shown; 0: none yet.
  uint64_t frame() const { return shownFrame_; }

 private:
  static void draw(const protocol::PixelHeader& header, std::span<const std::byte> data,
                   std::vector<uint8_t>& rgba);

  glm::ivec2 size_{0};
  std::vector<uint8_t> shown_, gathered_;
  std::vector<uint8_t> coarse_;  ///< of the level that comes
  uint64_t shownFrame_ = 0, newestFrame_ = 0;
};

}  // namespace gxy
