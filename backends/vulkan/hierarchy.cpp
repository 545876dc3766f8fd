// SPDX-License-Identifier: Apache-2.0
#include "backends/vulkan/hierarchy.h"

#include <bit>
#include <string>

#include "backends/bvh/tree.h"
#include "core/comm/error.h"
#include "core/rays/fill_views.h"
#include "shaders/layout.h"

namespace gxy::vulkan {

namespace {

constexpr unsigned kChildren = 4, kLargestLeaf = 8;
constexpr unsigned kDeepest = (STACK_ENTRIES - 1) / (kChildren - 1);

using Tree = embree::Tree<kChildren, kLargestLeaf>;

// Numbers nodes and lists primitives depth first, because the builder's threads call back in any order.
class Flatten {
 public:
  explicit Flatten(Hierarchy& out) : out_(out) {}

  uint32_t node(const Tree::Inner& n) {
    const size_t at = out_.nodes.size();
    const auto index = uint32_t(at / NODE_WORDS);
    out_.nodes.resize(at + NODE_WORDS);
    for (unsigned k = 0; k < kChildren; k++) {
      const bool there = k < n.count;
      if (there) {
        const RTCBounds& b = n.bounds[k];
        const float sides[6] = {b.lower_x, b.lower_y, b.lower_z, b.upper_x, b.upper_y, b.upper_z};
        for (unsigned side = 0; side < 6; side++)
          out_.nodes[at + side * kChildren + k] = std::bit_cast<uint32_t>(sides[side]);
      }
      const uint32_t word = !there             ? NODE_NONE
                            : n.child[k]->leaf ? leaf(static_cast<const Tree::Leaf&>(*n.child[k]))
                                               : node(static_cast<const Tree::Inner&>(*n.child[k]));
      out_.nodes[at + 6 * kChildren + k] = word;
    }
    return index;
  }

 private:
  uint32_t leaf(const Tree::Leaf& n) {
    const size_t first = out_.primitives.size() / 2;
    if (first + n.count > NODE_FIRST)
      throw Error("a partition has more than " + std::to_string(NODE_FIRST) +
                  " primitives; cut the data into more partitions");
    for (unsigned i = 0; i < n.count; i++) {
      out_.primitives.push_back(n.primitives[i][0]);
      out_.primitives.push_back(n.primitives[i][1]);
    }
    return NODE_LEAF | (n.count - 1) << NODE_COUNT_SHIFT | uint32_t(first);
  }

  Hierarchy& out_;
};

// Appends the primitives of this kind that an operator has in the partition.
void addPrimitives(std::vector<RTCBuildPrimitive>& all, const CompiledScene& scene, size_t op, int partition,
                   int kind) {
  const auto found = scene.operators[op].parts.find(partition);
  if (found == scene.operators[op].parts.end()) return;
  const bool isOfCells = kind == KIND_MESH || kind == KIND_HEX_MESH;
  const auto& primitives = isOfCells ? found->second.surfaces : found->second.geometry;
  if (primitives) embree::addPrimitives(all, unsigned(op), kind, *primitives);
}

Hierarchy hierarchyOver(std::vector<RTCBuildPrimitive> primitives, const Advance& advance) {
  Hierarchy hierarchy;
  if (primitives.empty()) return hierarchy;
  const embree::Device device;
  const Tree tree(device, std::move(primitives), kDeepest, 1, advance);
  Flatten(hierarchy).node(tree.root());
  return hierarchy;
}

}  // namespace

Hierarchy hierarchyOf(const CompiledScene& scene, int partition, const Advance& advance) {
  std::vector<RTCBuildPrimitive> primitives;
  for (size_t op = 0; op < scene.operators.size(); op++)
    addPrimitives(primitives, scene, op, partition, viewKindOf(scene.operators[op]));
  return hierarchyOver(std::move(primitives), advance);
}

Hierarchy shellHierarchyOf(const CompiledScene& scene, int op, int partition, const Advance& advance) {
  std::vector<RTCBuildPrimitive> primitives;
  const int kind = viewKindOf(scene.operators[size_t(op)]) == KIND_MESH ? KIND_SHELL : KIND_HEX_SHELL;
  addPrimitives(primitives, scene, size_t(op), partition, kind);
  return hierarchyOver(std::move(primitives), advance);
}

}  // namespace gxy::vulkan
