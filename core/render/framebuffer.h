// SPDX-License-Identifier: Apache-2.0
// Framebuffer: adds up the contributions of a frame's rays.
#pragma once
#include <functional>
#include <glm/vec2.hpp>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "core/rays/ray_list.h"
#include "core/scene/background.h"
#include "core/space/large_vector.h"

namespace gxy {

/// A picture: RGBA in float, premultiplied by alpha, rows bottom to top. If depth was asked for, it has the
/// distance of each pixel's first surface from the eye in world units, 1e30 for a miss.
struct Picture {
  int width = 0, height = 0;
  LargeVector<float> rgba;
  std::vector<double> depth{};
  /// Instead of `rgba` where asked for: 4 per pixel, in units of 1 / CONTRIBUTION_ONE.
  LargeVector<int64_t> sums{};
  int samples = 1;  ///< samples of each pixel in the sums

  size_t bytes() const {
    return rgba.size() * sizeof(float) + depth.size() * sizeof(double) + sums.size() * sizeof(int64_t);
  }
};

/// Rows of a picture, from `first` to the one before `end`.
struct Rows {
  int first = 0, end = 0;
  int count() const { return end - first; }
};

/// Returns the RGBA of a picture of `size` pixels: the mean of `sums` over samples in front of `background`
/// (which is premultiplied by its alpha here). Colours below 0 become 0, because an incomplete frame may lack
/// light that something was already subtracted from. Runs on the threads of the calling thread's task arena.
LargeVector<float> pixelsOf(std::span<const int64_t> sums, int samples, const Background& background,
                            glm::ivec2 size);

/// Integer accumulators of the pixels of a picture or of some of its rows, so that sums do not depend on the
/// order of arrival. Thread safe. It takes 32 bytes per pixel, and 8 more with depth, from the first
/// contribution to release(). Blocks of pixels to which nothing is added are neither written nor read.
class Framebuffer {
 public:
  /// Called with the size of the memory when the first contribution arrives. The framebuffer keeps what it
  /// returns as long as the memory.
  using Hold = std::function<std::shared_ptr<void>(int64_t bytes)>;

  /// Of a whole picture.
  Framebuffer(int width, int height, int samples, bool depth, Hold hold = {})
      : Framebuffer({width, height}, {0, height}, samples, depth, std::move(hold)) {}
  /// Of some rows of a picture of this size.
  Framebuffer(glm::ivec2 size, Rows rows, int samples, bool depth, Hold hold = {});

  /// Adds contributions to their pixels. Pixels have their number in the whole picture. Returns false, without
  /// adding any, if a pixel lies outside the rows. Throws std::bad_alloc.
  bool add(std::span<const Contribution> contributions);
  /// Keeps the smallest depth of each pixel. Returns false, without adding any, if a pixel lies outside the
  /// rows or the framebuffer has no depth. Throws std::bad_alloc.
  bool addDepths(std::span<const DepthContribution> depths);

  /// Returns the rows with what has arrived so far, as pixelsOf would convert its sums. `together` uses the threads of the
  /// calling thread's task arena, otherwise only the calling thread works.
  Picture picture(const Background& background, bool together = false) const;
  /// Returns the sums and depths of the rows themselves; the framebuffer no longer has them.
  Picture takeSums();

  /// Frees the memory. Nothing may be added afterwards.
  void release();

  /// The number of pixels in blocks to which nothing was added.
  size_t pixelsLeft() const;

  /// Bytes that a framebuffer takes from its first contribution on.
  static int64_t bytesOf(int width, int height, bool depth) {
    return int64_t(width) * height * int64_t(4 * sizeof(int64_t) + (depth ? sizeof(double) : 0));
  }

 private:
  void take();  ///< allocates the memory if there is none; the lock is held

  size_t placeOf(uint32_t pixel) const { return size_t(pixel) - first_; }  ///< huge for one before the rows

  const glm::ivec2 size_;  ///< of the whole picture
  const Rows rows_;
  const size_t first_, pixels_;  ///< number of the first pixel, and how many there are
  const int samples_;
  const bool hasDepth_;
  const Hold hold_;
  mutable std::mutex mutex_;
  std::shared_ptr<void> held_;
  LargeVector<int64_t>
      sums_;  ///< 4 per pixel of the rows, in units of 2^-26; empty before the first contribution
  /// For each block of pixels: whether its sums are written. If not, they are 0.
  std::vector<uint8_t> begun_;
  std::vector<double> depth_;  ///< 1 per pixel; empty before the first contribution and without depth
};

}  // namespace gxy
