// SPDX-License-Identifier: Apache-2.0
// The hierarchy over geometry: complete, bounded, and the same for the same data.
#include <gtest/gtest.h>

#include <bit>
#include <set>

#include "backends/vulkan/hierarchy.h"
#include "core/rays/fill_views.h"
#include "core/rays/primitive_bounds.h"
#include "shaders/layout.h"
#include "tests/agreement/scenes.h"

namespace gxy::vulkan {
namespace {

class Walk {
 public:
  Walk(const CompiledScene& scene, Hierarchy hierarchy) : scene_(scene), h_(std::move(hierarchy)) {}

  void node(uint32_t index, int depth) {
    deepest = std::max(deepest, depth);
    const uint32_t* n = &h_.nodes.at(size_t(index) * NODE_WORDS);
    for (uint32_t k = 0; k < 4; k++) {
      const uint32_t child = n[24 + k];
      if (child == NODE_NONE) continue;
      if (!(child & NODE_LEAF)) {
        node(child, depth + 1);
        continue;
      }
      const uint32_t count = (child >> NODE_COUNT_SHIFT & 7) + 1;
      for (uint32_t i = child & NODE_FIRST; i < (child & NODE_FIRST) + count; i++) {
        const uint32_t op = h_.primitives.at(2 * i), primitive = h_.primitives.at(2 * i + 1);
        EXPECT_TRUE(seen.insert({op, primitive}).second) << op << " " << primitive;
        const GeometryInPartition& part = *scene_.operators.at(op).parts.at(0).geometry;
        const PrimitiveBounds b = primitiveBounds(viewKindOf(scene_.operators[op]), part, primitive);
        for (uint32_t a = 0; a < 3; a++) {
          EXPECT_LE(std::bit_cast<float>(n[4 * a + k]), b.lo[a]);
          EXPECT_GE(std::bit_cast<float>(n[12 + 4 * a + k]), b.hi[a]);
        }
      }
    }
  }

  std::set<std::pair<uint32_t, uint32_t>> seen;
  int deepest = 0;

 private:
  const CompiledScene& scene_;
  const Hierarchy h_;
};

TEST(Hierarchy, HoldsEveryPrimitiveOnceWithinItsBoxes) {
  const auto scene = agreement::solids("solids", 16).compile();
  Walk walk(*scene, hierarchyOf(*scene, 0));
  walk.node(0, 1);
  size_t primitives = 0;
  for (const CompiledOperator& op : scene->operators)
    if (const auto part = op.parts.find(0); part != op.parts.end() && part->second.geometry)
      primitives += part->second.geometry->primitives;
  EXPECT_GT(primitives, 100u);
  EXPECT_EQ(walk.seen.size(), primitives);
}

// As many as several threads of the builder share.
TEST(Hierarchy, OfTheSameDataHasTheSameBytes) {
  agreement::TestScene test = agreement::solids("solids", 16);
  test.add(agreement::surfaces(VisType::Triangles),
           agreement::makeGeometry(GeometryKind::Triangles, agreement::sphereMesh(230, false, false)));
  const auto scene = test.compile();
  const Hierarchy first = hierarchyOf(*scene, 0);
  EXPECT_GT(first.primitives.size(), 100'000u);
  for (int i = 0; i < 5; i++) {
    const Hierarchy again = hierarchyOf(*scene, 0);
    EXPECT_EQ(again.nodes, first.nodes);
    EXPECT_EQ(again.primitives, first.primitives);
  }
}

TEST(Hierarchy, OfCoincidentSpheresFitsTheStack) {
  GeometryBlock block;
  block.points.assign(100'000, {0.1, 0.2, 0.3});
  agreement::TestScene test = agreement::sceneFrom("coincident", {0, 0, 4}, 16, 16);
  Vis vis = agreement::surfaces(VisType::Particles);
  vis.radius0 = vis.radius1 = 0.1;
  test.add(vis, agreement::makeGeometry(GeometryKind::Particles, std::move(block)));
  const auto scene = test.compile();
  Walk walk(*scene, hierarchyOf(*scene, 0));
  walk.node(0, 1);
  EXPECT_EQ(walk.seen.size(), 100'000u);
  EXPECT_LE(3 * walk.deepest + 1, STACK_ENTRIES);
}

TEST(Hierarchy, OfNoGeometryIsEmpty) {
  agreement::TestScene test = agreement::sceneFrom("volume", {0, 0, 4}, 16, 16);
  test.add(agreement::rendered({{0, 0}, {1, 1}}), agreement::wavy());
  EXPECT_TRUE(hierarchyOf(*test.compile(), 0).nodes.empty());
}

}  // namespace
}  // namespace gxy::vulkan
