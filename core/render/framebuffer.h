// SPDX-License-Identifier: Apache-2.0
// Where the contributions of a frame add up.
#pragma once
#include <functional>
#include <glm/vec2.hpp>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "core/rays/ray_list.h"
#include "core/scene/background.h"
#include "core/space/large_vector.h"

namespace gxy {

/// A picture: RGBA in float, premultiplied, rows bottom to top; with depth, the distance of each pixel's first surface
/// from the eye in world units, 1e30 for a miss.
struct Picture {
  int width = 0, height = 0;
  LargeVector<float> rgba;
  std::vector<double> depth{};
  LargeVector<int64_t>
      sums{};       ///< where asked for, instead of `rgba`: 4 per pixel, unit 1 / CONTRIBUTION_ONE
  int samples = 1;  ///< that are in the sums, of each pixel

  size_t bytes() const {
    return rgba.size() * sizeof(float) + depth.size() * sizeof(double) + sums.size() * sizeof(int64_t);
  }
};

/// The picture of a size that sums make: their mean over samples, in front of `background` (premultiplied by its alpha here), clamped
/// to [0, inf): a frame that is not complete may lack what a subtraction takes from. On the threads of the calling thread's
/// task arena.
LargeVector<float> pixelsOf(std::span<const int64_t> sums, int samples, const Background& background,
                            glm::ivec2 size);

/// Integer accumulators of all pixels: sums do not depend on the order of arrival. Thread safe. 32 bytes a pixel, 8 more
/// with depth, from the first contribution to release(); sums to which nothing is added are neither written nor read.
class Framebuffer {
 public:
  /// Is told how many bytes the sums take when the first contribution comes. What it returns is kept as long as they are.
  using Hold = std::function<std::shared_ptr<void>(int64_t bytes)>;

  Framebuffer(int width, int height, int samples, bool depth, Hold hold = {});

  /// Contributions to pixels outside the picture are refused: false, and nothing was added. Throws std::bad_alloc.
  bool add(std::span<const Contribution> contributions);
  bool addDepths(std::span<const DepthContribution> depths);

  /// What has arrived so far, as pixelsOf its sums would be; `together`: on the threads of the calling thread's task arena.
  Picture picture(const Background& background, bool together = false) const;
  /// The sums themselves, which are then no longer here.
  Picture takeSums();

  /// Gives the memory back. Nothing is added any more.
  void release();

  /// Pixels in whole blocks that nothing was added to.
  size_t pixelsLeft() const;

  /// That a framebuffer takes from its first contribution on.
  static int64_t bytesOf(int width, int height, bool depth) {
    return int64_t(width) * height * int64_t(4 * sizeof(int64_t) + (depth ? sizeof(double) : 0));
  }

 private:
  void take();  ///< the memory, with the lock held

  const int width_, height_, samples_;
  const bool hasDepth_;
  const Hold hold_;
  mutable std::mutex mutex_;
  std::shared_ptr<void> held_;
  LargeVector<int64_t> sums_;   ///< 4 per pixel, unit 2^-26; empty before the first contribution
  std::vector<uint8_t> begun_;  ///< of each block of pixels: whether its sums are there; else they are 0
  std::vector<double> depth_;   ///< as sums_
};

}  // namespace gxy
