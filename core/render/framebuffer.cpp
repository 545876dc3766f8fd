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

Framebuffer::Framebuffer(glm::ivec2 size, Rows rows, int samples, bool depth, Hold hold)
    : size_(size),
      rows_(rows),
      first_(size_t(size.x) * size_t(rows.first)),
      pixels_(size_t(size.x) * size_t(rows.count())),
      samples_(samples),
      hasDepth_(depth),
      hold_(std::move(hold)),
      begun_(blocksOf(pixels_)) {}

void Framebuffer::take() {
  if (!sums_.empty()) return;
  if (hold_) held_ = hold_(bytesOf(size_.x, rows_.count(), hasDepth_));
  if (hasDepth_) depth_.assign(pixels_, kMiss);
  sums_.resize(4 * pixels_);
}

bool Framebuffer::add(std::span<const Contribution> contributions) {
  for (const Contribution& c : contributions)
    if (placeOf(c.pixel) >= pixels_) return false;
  if (contributions.empty()) return true;
  std::lock_guard lock(mutex_);
  take();
  for (const Contribution& c : contributions) {
    const size_t place = placeOf(c.pixel);
    uint8_t& begun = begun_[place / kBlock];
    if (!begun) std::ranges::fill(partOf(std::span(sums_), place / kBlock), 0);
    begun = 1;
    int64_t* p = &sums_[4 * place];
    p[0] += c.r;
    p[1] += c.g;
    p[2] += c.b;
    p[3] += c.a;
  }
  return true;
}

bool Framebuffer::addDepths(std::span<const DepthContribution> depths) {
  for (const DepthContribution& d : depths)
    if (!hasDepth_ || placeOf(d.pixel) >= pixels_) return false;
  if (depths.empty()) return true;
  std::lock_guard lock(mutex_);
  take();
  for (const DepthContribution& d : depths) {
    double& depth = depth_[placeOf(d.pixel)];
    depth = std::min(depth, d.depth);
  }
  return true;
}

size_t Framebuffer::pixelsLeft() const {
  std::lock_guard lock(mutex_);
  size_t left = 0;
  for (size_t b = 0; b < begun_.size(); b++)
    if (!begun_[b]) left += std::min(kBlock, pixels_ - kBlock * b);
  return left;
}

Picture Framebuffer::picture(const Background& background, bool together) const {
  std::lock_guard lock(mutex_);
  const Mean mean(samples_, background, size_);
  static constexpr std::array<int64_t, 4 * kBlock> kNothing{};
  std::array<float, 4> empty{};
  mean(0, std::span(kNothing).first(4), empty);
  LargeVector<float> rgba(4 * pixels_);
  const auto convert = [&](size_t b) {
    const std::span<float> part = partOf(std::span(rgba), b);
    const size_t first = first_ + kBlock * b;
    if (begun_[b]) return mean(first, partOf(std::span(sums_), b), part);
    if (background.isGradient()) return mean(first, std::span(kNothing).first(part.size()), part);
    for (size_t i = 0; i < part.size(); i++) part[i] = empty[i % 4];
  };
  if (together)
    parallelFor(size_t(0), begun_.size(), convert);
  else
    for (size_t b = 0; b < begun_.size(); b++) convert(b);
  std::vector<double> depth = depth_;
  if (hasDepth_ && depth.empty()) depth.assign(pixels_, kMiss);
  return {size_.x, rows_.count(), std::move(rgba), std::move(depth), {}, samples_};
}

Picture Framebuffer::takeSums() {
  std::lock_guard lock(mutex_);
  take();
  for (size_t b = 0; b < begun_.size(); b++)
    if (!begun_[b]) std::ranges::fill(partOf(std::span(sums_), b), 0);
  begun_.clear();
  return {size_.x, rows_.count(), {}, std::move(depth_), std::exchange(sums_, {}), samples_};
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
