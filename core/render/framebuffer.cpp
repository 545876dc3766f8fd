// SPDX-License-Identifier: Apache-2.0
#include "core/render/framebuffer.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/comm/parallel_for.h"

namespace gxy {

namespace {

constexpr size_t kBlock = 64;   // pixels: 2 KB of sums
constexpr double kMiss = 1e30;  // depth of a pixel that shows no surface

size_t blocksOf(size_t pixels) { return (pixels + kBlock - 1) / kBlock; }

// The part of block `b` in an array of four numbers per pixel.
template <class T>
std::span<T> partOf(std::span<T> all, size_t b) {
  return all.subspan(4 * kBlock * b, std::min(4 * kBlock, all.size() - 4 * kBlock * b));
}

// Converts sums into RGBA, as pixelsOf says.
class Mean {
 public:
  Mean(int samples, const Background& background, glm::ivec2 size)
      : unit_(1.0 / (double(CONTRIBUTION_ONE) * samples)), background_(background), size_(size) {}

  // Converts the pixels from number `first` on.
  void operator()(size_t first, std::span<const int64_t> sums, std::span<float> rgba) const {
    glm::dvec4 background = background_.at(0, size_.y);
    for (size_t i = 0; i < sums.size(); i += 4) {
      if (background_.isGradient())
        background = background_.at(int((first + i / 4) / size_t(size_.x)), size_.y);
      const double alpha = std::clamp(double(sums[i + 3]) * unit_, 0.0, 1.0);
      const double behind = (1 - alpha) * background.a;
      for (size_t k = 0; k < 3; k++)
        rgba[i + k] = float(std::max(double(sums[i + k]) * unit_, 0.0) + behind * background[int(k)]);
      rgba[i + 3] = float(alpha + behind);
    }
  }

 private:
  double unit_;
  Background background_;
  glm::ivec2 size_;
};

}  // namespace

Framebuffer::Framebuffer(int width, int height, int samples, bool depth, Hold hold)
    : width_(width),
      height_(height),
      samples_(samples),
      hasDepth_(depth),
      hold_(std::move(hold)),
      begun_(blocksOf(size_t(width) * size_t(height))) {}

void Framebuffer::take() {
  if (!sums_.empty()) return;
  if (hold_) held_ = hold_(bytesOf(width_, height_, hasDepth_));
  const size_t pixels = size_t(width_) * size_t(height_);
  if (hasDepth_) depth_.assign(pixels, kMiss);
  sums_.resize(4 * pixels);
}

bool Framebuffer::add(std::span<const Contribution> contributions) {
  const size_t pixels = size_t(width_) * size_t(height_);
  for (const Contribution& c : contributions)
    if (c.pixel >= pixels) return false;
  if (contributions.empty()) return true;
  std::lock_guard lock(mutex_);
  take();
  for (const Contribution& c : contributions) {
    uint8_t& begun = begun_[c.pixel / kBlock];
    if (!begun) std::ranges::fill(partOf(std::span(sums_), c.pixel / kBlock), 0);
    begun = 1;
    int64_t* p = &sums_[size_t(4) * c.pixel];
    p[0] += c.r;
    p[1] += c.g;
    p[2] += c.b;
    p[3] += c.a;
  }
  return true;
}

bool Framebuffer::addDepths(std::span<const DepthContribution> depths) {
  const size_t pixels = hasDepth_ ? size_t(width_) * size_t(height_) : 0;
  for (const DepthContribution& d : depths)
    if (d.pixel >= pixels) return false;
  if (depths.empty()) return true;
  std::lock_guard lock(mutex_);
  take();
  for (const DepthContribution& d : depths) depth_[d.pixel] = std::min(depth_[d.pixel], d.depth);
  return true;
}

size_t Framebuffer::pixelsLeft() const {
  std::lock_guard lock(mutex_);
  const size_t pixels = size_t(width_) * size_t(height_);
  size_t left = 0;
  for (size_t b = 0; b < begun_.size(); b++)
    if (!begun_[b]) left += std::min(kBlock, pixels - kBlock * b);
  return left;
}

Picture Framebuffer::picture(const Background& background, bool together) const {
  std::lock_guard lock(mutex_);
  const Mean mean(samples_, background, {width_, height_});
  static constexpr std::array<int64_t, 4 * kBlock> kNothing{};
  std::array<float, 4> empty{};
  mean(0, std::span(kNothing).first(4), empty);
  const size_t pixels = size_t(width_) * size_t(height_);
  LargeVector<float> rgba(4 * pixels);
  const auto convert = [&](size_t b) {
    const std::span<float> part = partOf(std::span(rgba), b);
    if (begun_[b]) return mean(kBlock * b, partOf(std::span(sums_), b), part);
    if (background.isGradient()) return mean(kBlock * b, std::span(kNothing).first(part.size()), part);
    for (size_t i = 0; i < part.size(); i++) part[i] = empty[i % 4];
  };
  if (together)
    parallelFor(size_t(0), begun_.size(), convert);
  else
    for (size_t b = 0; b < begun_.size(); b++) convert(b);
  std::vector<double> depth = depth_;
  if (hasDepth_ && depth.empty()) depth.assign(pixels, kMiss);
  return {width_, height_, std::move(rgba), std::move(depth), {}, samples_};
}

Picture Framebuffer::takeSums() {
  std::lock_guard lock(mutex_);
  take();
  for (size_t b = 0; b < begun_.size(); b++)
    if (!begun_[b]) std::ranges::fill(partOf(std::span(sums_), b), 0);
  begun_.clear();
  return {width_, height_, {}, std::move(depth_), std::exchange(sums_, {}), samples_};
}

void Framebuffer::release() {
  std::lock_guard lock(mutex_);
  sums_ = LargeVector<int64_t>();
  depth_ = std::vector<double>();
  held_ = nullptr;
}

LargeVector<float> pixelsOf(std::span<const int64_t> sums, int samples, const Background& background,
                            glm::ivec2 size) {
  const Mean mean(samples, background, size);
  LargeVector<float> rgba(sums.size());
  parallelFor(size_t(0), blocksOf(sums.size() / 4),
              [&](size_t b) { mean(kBlock * b, partOf(sums, b), partOf(std::span(rgba), b)); });
  return rgba;
}

}  // namespace gxy
