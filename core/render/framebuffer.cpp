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
  Picture picture{width_, height_, std::vector<float>(sums_.size()), depth_};
  const double unit = 1.0 / (double(CONTRIBUTION_ONE) * samples_);
  for (size_t i = 0; i < sums_.size(); i += 4) {
    const double alpha = std::clamp(double(sums_[i + 3]) * unit, 0.0, 1.0);
    const double behind = (1 - alpha) * background.a;
    for (int k = 0; k < 3; k++)
      picture.rgba[i + k] = float(std::max(double(sums_[i + k]) * unit, 0.0) + behind * background[k]);
    picture.rgba[i + 3] = float(alpha + behind);
  }
  return picture;
}

}  // namespace gxy
