// SPDX-License-Identifier: Apache-2.0
#include "core/reference/bvh.h"

#include <algorithm>
#include <limits>

namespace gxy::reference {
namespace {
constexpr uint32_t kLeaf = 4;
}

Bvh::Bvh(std::span<const Box> boxes) {
  for (size_t i = 0; i < boxes.size(); i++) {
    if (!boxes[i].empty()) order_.push_back(uint32_t(i));
  }
  if (!order_.empty()) build(boxes, 0, uint32_t(order_.size()));
}

void Bvh::build(std::span<const Box> boxes, uint32_t first, uint32_t last) {
  const size_t self = nodes_.size();
  Box box, centres;
  for (uint32_t i = first; i < last; i++) {
    const Box& b = boxes[order_[i]];
    box.extend(b);
    centres.extend(0.5 * (b.lo + b.hi));
  }
  nodes_.push_back({box, first, last - first, 0});
  if (last - first <= kLeaf) return;
  const glm::dvec3 size = centres.hi - centres.lo;
  int axis = size.x > size.y ? 0 : 1;
  if (size.z > size[axis]) axis = 2;
  const uint32_t middle = first + (last - first) / 2;
  std::nth_element(
      order_.begin() + first, order_.begin() + middle, order_.begin() + last, [&](uint32_t a, uint32_t b) {
        const double x = boxes[a].lo[axis] + boxes[a].hi[axis], y = boxes[b].lo[axis] + boxes[b].hi[axis];
        return x != y ? x < y : a < b;
      });
  build(boxes, first, middle);
  nodes_[self].second = uint32_t(nodes_.size());
  nodes_[self].count = 0;
  nodes_[self].axis = axis;
  build(boxes, middle, last);
}

bool Bvh::mayMeet(const Box& box, const Ray& ray, Interval range) {
  constexpr double kSlack = 8 * std::numeric_limits<double>::epsilon();
  for (int a = 0; a < 3; a++) {
    if (ray.direction[a] == 0) {
      if (ray.origin[a] < box.lo[a] || ray.origin[a] > box.hi[a]) return false;
      continue;
    }
    const double t0 = (box.lo[a] - ray.origin[a]) / ray.direction[a],
                 t1 = (box.hi[a] - ray.origin[a]) / ray.direction[a];
    const double in = std::min(t0, t1), out = std::max(t0, t1);
    range = range.intersected({in - kSlack * std::abs(in), out + kSlack * std::abs(out)});
    if (!(range.lo <= range.hi)) return false;
  }
  return true;
}

}  // namespace gxy::reference
