// SPDX-License-Identifier: Apache-2.0
// Bounding volume hierarchies that Embree builds and the backends traverse themselves.
#pragma once
#include <array>
#include <cstdint>
#include <exception>
#include <limits>
#include <mutex>
#include <new>
#include <string>
#include <vector>

#include "backends/bvh/embree.h"
#include "core/comm/parallel_for.h"
#include "core/comm/thread_order.h"
#include "core/rays/compiled_scene.h"
#include "core/rays/primitive_bounds.h"

namespace gxy::embree {

/// Appends the boxes (primitiveBounds) of the primitives of a part of this kind (KIND_*) to `all` as geometry `id`. Runs on all cores.
inline void addPrimitives(std::vector<RTCBuildPrimitive>& all, unsigned id, int kind,
                          const GeometryInPartition& part) {
  const size_t first = all.size();
  all.resize(first + part.primitives);
  parallelFor(size_t(0), size_t(part.primitives), [&](size_t i) {
    const PrimitiveBounds b = primitiveBounds(kind, part, i);
    all[first + i] = {b.lo[0], b.lo[1], b.lo[2], id, b.hi[0], b.hi[1], b.hi[2], unsigned(i)};
  });
}

/// A tree whose nodes have up to `Children` children, and whose leaves have up to `Largest` primitives. It is
/// built on all cores by the surface area heuristic. Its shape follows from the primitives, but the order of
/// its memory does not.
template <unsigned Children, unsigned Largest>
class Tree {
 public:
  struct Node {
    bool leaf;
    unsigned count = 0;  ///< children or primitives
  };
  struct Inner : Node {
    Inner() : Node{false} {}
    std::array<Node*, Children> child{};
    std::array<RTCBounds, Children> bounds;
  };
  struct Leaf : Node {
    Leaf() : Node{true} {}
    std::array<std::array<unsigned, 2>, Largest> primitives;  ///< geometry, number
  };

  /// Builds a tree of one primitive or more, which the builder reorders. It is at most `deepest` levels deep,
  /// and leaves of up to `smallest` primitives are not split. Throws Error if the build fails, and what
  /// `advance` throws.
  Tree(const Device& device, std::vector<RTCBuildPrimitive> primitives, unsigned deepest, unsigned smallest,
       const Advance& advance)
      : bvh_(rtcNewBVH(device.get())) {
    Progress progress{advance};
    progress_ = &progress;
    RTCBuildArguments build = rtcDefaultBuildArguments();
    build.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
    build.maxBranchingFactor = Children;
    build.maxDepth = deepest;
    build.minLeafSize = smallest;
    build.maxLeafSize = Largest;
    // The heuristic counts leaves, and not primitives, as a step takes as long for one primitive as for a whole leaf. So leaves
    // are nearly full.
    build.sahBlockSize = smallest;
    build.bvh = bvh_.get();
    build.primitives = primitives.data();
    build.primitiveCount = build.primitiveArrayCapacity = primitives.size();
    build.userPtr = this;
    build.createNode = [](RTCThreadLocalAllocator allocator, unsigned, void* tree) -> void* {
      return inOrder(tree, [&] { return static_cast<Node*>(made<Inner>(allocator)); });
    };
    build.setNodeChildren = [](void* node, void** children, unsigned count, void* tree) {
      inOrder(tree, [&] {
        inner(node).count = count;
        for (unsigned k = 0; k < count; k++) inner(node).child[k] = static_cast<Node*>(children[k]);
        return node;
      });
    };
    build.setNodeBounds = [](void* node, const RTCBounds** bounds, unsigned count, void* tree) {
      inOrder(tree, [&] {
        for (unsigned k = 0; k < count; k++) inner(node).bounds[k] = *bounds[k];
        return node;
      });
    };
    build.createLeaf = [](RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* found, size_t count,
                          void* tree) -> void* {
      return inOrder(tree, [&] {
        Leaf* n = made<Leaf>(allocator);
        n->count = unsigned(count);
        for (size_t i = 0; i < count; i++) n->primitives[i] = {found[i].geomID, found[i].primID};
        return static_cast<Node*>(n);
      });
    };
    build.buildProgress = [](void* tree, double fraction) {
      const bool goesOn = inOrder(tree, [&] { return static_cast<Tree*>(tree)->progress_->tell(fraction); });
      // Embree 3.13 ignores what this returns. It takes an exception as one of its own: the build fails and
      // is undone.
      if (!goesOn) throw Error("ended");
      return true;
    };
    ThreadOrder(this).handOver();
    auto* root = static_cast<Node*>(rtcBuildBVH(&build));
    ThreadOrder(this).takeBack();
    if (progress.end) std::rethrow_exception(progress.end);
    const std::string what =
        "building the hierarchy over " + std::to_string(primitives.size()) + " primitives";
    device.expectDone(what);
    if (!root) throw Error("Embree: " + what + " failed");
    if (!root->leaf) {
      root_ = static_cast<Inner*>(root);
      return;
    }
    constexpr float kAll = std::numeric_limits<float>::max();
    above_.count = 1;
    above_.child[0] = root;
    above_.bounds[0] = {-kAll, -kAll, -kAll, 0, kAll, kAll, kAll, 0};
  }
  Tree(const Tree&) = delete;
  Tree& operator=(const Tree&) = delete;

  const Inner& root() const { return *root_; }

 private:
  struct Progress {
    const Advance& advance;
    std::mutex mutex{};
    std::exception_ptr end{};  ///< what `advance` threw first

    /// Calls `advance`. Returns whether the build is to go on.
    bool tell(double fraction) {
      try {
        advance(fraction);
        return true;
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!end) end = std::current_exception();
        return false;
      }
    }
  };

  template <class T>
  static T* made(RTCThreadLocalAllocator allocator) {
    return new (rtcThreadLocalAlloc(allocator, sizeof(T), alignof(T))) T;
  }
  // Runs our code on a thread of the builder, in an order that the thread sanitizer knows.
  template <class F>
  static auto inOrder(const void* tree, F&& f) {
    const ThreadOrder order(tree);
    order.begin();
    const auto made = f();
    order.end();
    return made;
  }
  static Inner& inner(void* node) { return *static_cast<Inner*>(static_cast<Node*>(node)); }

  Progress* progress_ = nullptr;  ///< used only while the tree is built
  Bvh bvh_;                       ///< owns the nodes
  Inner above_;
  const Inner* root_ = &above_;
};

}  // namespace gxy::embree
