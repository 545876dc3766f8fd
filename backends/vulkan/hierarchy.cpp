// SPDX-License-Identifier: Apache-2.0
#include "gxy/vulkan/hierarchy.h"

#include <array>
#include <bit>
#include <memory>
#include <string>

#include "gxy/comm/error.h"
#include "gxy/comm/parallel_for.h"
#include "gxy/embree/embree.h"
#include "gxy/rays/primitive_bounds.h"
#include "gxy/shaders/layout.h"

namespace gxy::vulkan {

namespace {

constexpr unsigned kChildren = 4, kLargestLeaf = 8;
constexpr unsigned kDeepest = (STACK_ENTRIES - 1) / (kChildren - 1);

// A node while the tree is built: one with children, or a leaf with primitives.
struct Node {
  unsigned children = 0, leaf = 0;
  std::array<Node*, kChildren> child{};
  std::array<RTCBounds, kChildren> bounds;
  std::array<std::array<unsigned, 2>, kLargestLeaf> primitives;
};

Node* makeNode(RTCThreadLocalAllocator allocator) {
  return new (rtcThreadLocalAlloc(allocator, sizeof(Node), alignof(Node))) Node;
}

// Numbers nodes and lists primitives depth first: the builder's threads called back in any order.
class Flatten {
 public:
  explicit Flatten(Hierarchy& out) : out_(out) {}

  uint32_t node(const Node& n) {
    const size_t at = out_.nodes.size();
    const auto index = uint32_t(at / NODE_WORDS);
    out_.nodes.resize(at + NODE_WORDS);
    for (unsigned k = 0; k < kChildren; k++) {
      const bool there = k < n.children;
      if (there) {
        const RTCBounds& b = n.bounds[k];
        const float sides[6] = {b.lower_x, b.lower_y, b.lower_z, b.upper_x, b.upper_y, b.upper_z};
        for (unsigned side = 0; side < 6; side++)
          out_.nodes[at + side * kChildren + k] = std::bit_cast<uint32_t>(sides[side]);
      }
      const uint32_t word = !there ? NODE_NONE : n.child[k]->leaf ? leaf(*n.child[k]) : node(*n.child[k]);
      out_.nodes[at + 6 * kChildren + k] = word;
    }
    return index;
  }

 private:
  uint32_t leaf(const Node& n) {
    const size_t first = out_.primitives.size() / 2;
    if (first + n.leaf > NODE_FIRST)
      throw Error("a partition has more than " + std::to_string(NODE_FIRST) +
                  " primitives; cut the data into more partitions");
    for (unsigned i = 0; i < n.leaf; i++) {
      out_.primitives.push_back(n.primitives[i][0]);
      out_.primitives.push_back(n.primitives[i][1]);
    }
    return NODE_LEAF | (n.leaf - 1) << NODE_COUNT_SHIFT | uint32_t(first);
  }

  Hierarchy& out_;
};

std::vector<RTCBuildPrimitive> primitivesOf(const CompiledScene& scene, int partition) {
  std::vector<RTCBuildPrimitive> all;
  for (size_t op = 0; op < scene.operators.size(); op++) {
    const auto found = scene.operators[op].parts.find(partition);
    if (found == scene.operators[op].parts.end()) continue;
    if (!found->second.geometry) continue;
    const GeometryPart& part = *found->second.geometry;
    const int corners = cornersOf(scene.operators[op].vis.type);
    const size_t first = all.size();
    all.resize(first + part.primitives);
    parallelFor(size_t(0), size_t(part.primitives), [&](size_t i) {
      const PrimitiveBounds b = primitiveBounds(corners, part.points.data(), part.indices.data(), i);
      all[first + i] = {b.lo[0], b.lo[1], b.lo[2], unsigned(op), b.hi[0], b.hi[1], b.hi[2], unsigned(i)};
    });
  }
  return all;
}

}  // namespace

int cornersOf(VisType type) {
  switch (type) {
    case VisType::Particles:
      return 1;
    case VisType::PathLines:
      return 2;
    default:
      return 3;
  }
}

Hierarchy hierarchyOf(const CompiledScene& scene, int partition) {
  Hierarchy hierarchy;
  std::vector<RTCBuildPrimitive> primitives = primitivesOf(scene, partition);
  if (primitives.empty()) return hierarchy;
  const embree::Device device;
  const embree::Bvh bvh(rtcNewBVH(device.get()));
  RTCBuildArguments build = rtcDefaultBuildArguments();
  build.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
  build.maxBranchingFactor = kChildren;
  build.maxDepth = kDeepest;
  build.minLeafSize = 1;
  build.maxLeafSize = kLargestLeaf;
  build.bvh = bvh.get();
  build.primitives = primitives.data();
  build.primitiveCount = primitives.size();
  build.primitiveArrayCapacity = primitives.size();
  build.createNode = [](RTCThreadLocalAllocator allocator, unsigned, void*) -> void* {
    return makeNode(allocator);
  };
  build.setNodeChildren = [](void* node, void** children, unsigned count, void*) {
    auto& n = *static_cast<Node*>(node);
    n.children = count;
    for (unsigned k = 0; k < count; k++) n.child[k] = static_cast<Node*>(children[k]);
  };
  build.setNodeBounds = [](void* node, const RTCBounds** bounds, unsigned count, void*) {
    for (unsigned k = 0; k < count; k++) static_cast<Node*>(node)->bounds[k] = *bounds[k];
  };
  build.createLeaf = [](RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* found, size_t count,
                        void*) -> void* {
    Node* n = makeNode(allocator);
    n->leaf = unsigned(count);
    for (size_t i = 0; i < count; i++) n->primitives[i] = {found[i].geomID, found[i].primID};
    return n;
  };
  auto* root = static_cast<Node*>(rtcBuildBVH(&build));
  const std::string what = "building the hierarchy over " + std::to_string(primitives.size()) + " primitives";
  device.expectDone(what);
  if (!root) throw Error("Embree: " + what + " failed");
  Node above;  // a root has children
  if (root->leaf) {
    above.children = 1;
    above.child[0] = root;
    constexpr float kAll = std::numeric_limits<float>::max();
    above.bounds[0] = {-kAll, -kAll, -kAll, 0, kAll, kAll, kAll, 0};
    root = &above;
  }
  Flatten(hierarchy).node(*root);
  return hierarchy;
}

}  // namespace gxy::vulkan
