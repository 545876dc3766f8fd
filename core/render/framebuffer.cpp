// SPDX-License-Identifier: Apache-2.0
#include "gxy/render/framebuffer.h"

#include <algorithm>

namespace gxy {

Framebuffer::Framebuffer(int width, int height, int samples, bool depth)
    : width_(width), height_(height), samples_(samples), sums_(size_t(4) * width * height, 0) {
  if (depth) depth_.assign(size_t(width) * height, 1e30);
}

bool Framebuffer::add(std::span<const Contribution> contributions) {
  const size_t pixels = sums_.size() / 4;
  for (const Contribution& c : contributions)
    if (c.pixel >= pixels) return false;
  std::lock_guard lock(mutex_);
  for (const Contribution& c : contributions) {
    int64_t* p = &sums_[size_t(4) * c.pixel];
    p[0] += c.r;
    p[1] += c.g;
    p[2] += c.b;
    p[3] += c.a;
  }
  return true;
}

bool Framebuffer::addDepths(std::span<const DepthContribution> depths) {
  for (const DepthContribution& d : depths)
    if (d.pixel >= depth_.size()) return false;
  std::lock_guard lock(mutex_);
  for (const DepthContribution& d : depths) depth_[d.pixel] = std::min(depth_[d.pixel], d.depth);
  return true;
}

Picture Framebuffer::picture(const glm::dvec4& background) const {
  std::lock_guard lock(mutex_);
  return {width_, height_, pixelsOf(sums_, samples_, background), depth_, {}, samples_};
}

Picture Framebuffer::sums() const {
  std::lock_guard lock(mutex_);
  return {width_, height_, {}, depth_, sums_, samples_};
}

std::vector<float> pixelsOf(std::span<const int64_t> sums, int samples, const glm::dvec4& background) {
  std::vector<float> rgba(sums.size());
  const double unit = 1.0 / (double(CONTRIBUTION_ONE) * samples);
  for (size_t i = 0; i < sums.size(); i += 4) {
    const double alpha = std::clamp(double(sums[i + 3]) * unit, 0.0, 1.0);
    const double behind = (1 - alpha) * background.a;
    for (size_t k = 0; k < 3; k++)
      rgba[i + k] = float(std::max(double(sums[i + k]) * unit, 0.0) + behind * background[int(k)]);
    rgba[i + 3] = float(alpha + behind);
  }
  return rgba;
}

}  // namespace gxy
