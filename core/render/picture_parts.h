// SPDX-License-Identifier: Apache-2.0
// PictureParts: which rank adds up which pixels of a picture.
#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <string>

#include "core/comm/transport.h"
#include "core/render/framebuffer.h"

namespace gxy {

/// Deals the pixels of a frame's picture out to ranks. A *part* is a number of whole rows, and its rank has their
/// framebuffer. There is a part for each `ranksPerPart` ranks, so that no rank gets more messages of contributions
/// where there are more ranks to send them. The rank of part 0 *owns* the picture. Finished parts come to it along a
/// binary tree (core/comm/tree.h, of parts instead of ranks, rooted at part 0), so that a rank gets two messages of
/// them. Where ranks are few the picture is one part, and nothing is sent.
class PictureParts {
 public:
  /// `size` is at least 1 in both directions. Frames that follow each other have different owners.
  PictureParts(uint64_t frame, glm::ivec2 size, int ranks, int ranksPerPart);

  glm::ivec2 size() const { return size_; }
  int count() const { return count_; }
  /// The rank of a part. No rank has two.
  int rank(int part) const { return (owner_ + part * stride_) % ranks_; }
  /// The part of a rank, if it has one.
  std::optional<int> ofRank(int rank) const;
  Rows rows(int part) const;
  /// The number of the pixel after those of a part.
  size_t end(int part) const { return size_t(rows(part).end) * size_t(size_.x); }

 private:
  glm::ivec2 size_;
  int ranks_, owner_;
  int rowsEach_;  ///< rows of each part but the last, which may have fewer
  int count_;
  int stride_;  ///< between the ranks of parts, which are spread over all ranks, and so over nodes
};

/// The bytes of a finished part, or those that say why there is none.
Bytes bytesOfPart(int part, const Picture& rows);
Bytes bytesOfPart(int part, const std::string& error);

/// Puts the picture together. Each message has the bytes of one part, or of several after each other. Throws Error
/// if one says why there is no part, if parts are missing, and for malformed messages.
Picture joined(const PictureParts& parts, bool sums, bool depth,
               std::span<const std::span<const std::byte>> messages);

}  // namespace gxy
