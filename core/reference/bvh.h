// SPDX-License-Identifier: Apache-2.0
// Bvh: a tree of boxes in double. It finds all primitives that a ray may meet.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/data/box.h"
#include "core/reference/ray.h"

namespace gxy::reference {

/// A tree of boxes, halved at the median of the longest axis. Immutable; safe to use from any thread.
class Bvh {
 public:
  /// `boxes` has one box per primitive; empty ones are never found.
  explicit Bvh(std::span<const Box> boxes);

  /// Calls visit(primitive) for all primitives whose box the ray may meet within t in [lo, limit()]; `limit`
  /// may shrink while visiting.
  template <class Visit, class Limit>
  void traverse(const Ray& ray, double lo, Limit limit, Visit visit) const {
    if (nodes_.empty()) return;
    std::vector<uint32_t> stack{0};
    while (!stack.empty()) {
      const Node& node = nodes_[stack.back()];
      const uint32_t index = stack.back();
      stack.pop_back();
      if (!mayMeet(node.box, ray, {lo, limit()})) continue;
      if (node.count == 0) {
        const bool nearFirst = ray.direction[node.axis] >= 0;
        stack.push_back(nearFirst ? node.second : index + 1);
        stack.push_back(nearFirst ? index + 1 : node.second);
      }
      for (uint32_t i = 0; i < node.count; i++) visit(order_[node.second + i]);
    }
  }

 private:
  struct Node {
    Box box;
    /// Inner node: index of the second child; the first child follows its parent. Leaf: its first entry in
    /// order_.
    uint32_t second;
    uint32_t count;  ///< leaf: number of its primitives; inner node: 0
    int axis;
  };
  static bool mayMeet(const Box& box, const Ray& ray, Interval range);
  void build(std::span<const Box> boxes, uint32_t first, uint32_t last);

  std::vector<Node> nodes_;
  std::vector<uint32_t> order_;
};

}  // namespace gxy::reference
