// SPDX-License-Identifier: Apache-2.0
// The trees that rays walk on CPUs: complete, bounded, and as good as testing everything.
#include "backends/embree/geometry_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>
#include <set>
#include <vector>

#include "backends/embree/tree_layout.h"
#include "core/kernels/single_views.h"
#include "core/rays/ray_list.h"
#include "geometry_ispc.h"
#include "spawn_ispc.h"
#include "tests/support/ended.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

struct Case {
  int kind;
  size_t rows, corners, cornerRows;
};
const Case kCases[] = {{KIND_PARTICLES, TREE_SPHERE_ROWS, 1, 4},
                       {KIND_PATHLINES, TREE_TUBE_ROWS, 2, 4},
                       {KIND_TRIANGLES, TREE_TRIANGLE_ROWS, 3, 3}};

// Primitives of points anywhere, each of the next ones.
GeometryInPartition scattered(const Case& c, uint32_t primitives) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> anywhere(-1, 1);
  GeometryInPartition part;
  part.primitives = primitives;
  const auto points = uint32_t(primitives + c.corners - 1);
  for (uint32_t p = 0; p < points; p++) {
    for (int k = 0; k < 3; k++) part.points.push_back(anywhere(random));
    part.points.push_back(c.kind == KIND_TRIANGLES ? 0 : 0.01f);
  }
  for (uint32_t p = 0; p < primitives && c.corners > 1; p++)
    for (uint32_t k = 0; k < c.corners; k++) part.indices.push_back(p + k);
  for (uint32_t p = 0; p < primitives && c.kind == KIND_PATHLINES; p++) {
    part.neighbours.push_back(p == 0 ? p : p - 1);
    part.neighbours.push_back(p + 2 == points ? p + 1 : p + 2);
  }
  return part;
}

class Walk {
 public:
  Walk(const GeometryTree& tree, const Case& c, size_t lanes) : tree_(tree), case_(c), lanes_(lanes) {}

  void node(uint32_t index, int depth) {
    deepest = std::max(deepest, depth);
    const uint32_t* n = tree_.nodes.data() + index * TREE_NODE_ROWS * lanes_;
    const auto side = [&](size_t row, size_t k) { return std::bit_cast<float>(n[row * lanes_ + k]); };
    for (size_t k = 0; k < lanes_; k++) {
      if (side(0, k) > side(3, k)) continue;  // a missing child
      const uint32_t word = n[6 * lanes_ + k];
      if (!(word & TREE_LEAF)) {
        ASSERT_GT(word, index);
        node(word, depth + 1);
        continue;
      }
      for (const std::vector<float>& primitive : leaf(word)) {
        EXPECT_TRUE(seen.insert(primitive).second);
        for (size_t corner = 0; corner < case_.corners; corner++)
          for (size_t axis = 0; axis < 3; axis++) {
            const float* p = primitive.data() + corner * case_.cornerRows;
            const float r = case_.cornerRows == 4 ? p[3] : 0;
            EXPECT_LT(side(axis, k), p[axis] - r);
            EXPECT_GT(side(3 + axis, k), p[axis] + r);
          }
      }
    }
  }

  std::set<std::vector<float>> seen;
  int deepest = 0;

 private:
  // What is in a leaf, each once, and which it is at the end.
  std::set<std::vector<float>> leaf(uint32_t word) const {
    const size_t number = word & TREE_LEAF_NUMBER;
    std::set<std::vector<float>> found;
    for (size_t i = 0; i < lanes_; i++) {
      std::vector<float> rows;
      for (size_t row = 0; row <= case_.rows; row++)
        rows.push_back(tree_.leaves.at((number * (case_.rows + 1) + row) * lanes_ + i));
      rows.back() = float(std::bit_cast<uint32_t>(rows.back()));
      found.insert(rows);
    }
    EXPECT_EQ(found.size(), ((word & ~TREE_LEAF) >> TREE_COUNT_SHIFT) + 1);
    return found;
  }

  const GeometryTree& tree_;
  const Case& case_;
  const size_t lanes_;
};

TEST(GeometryTree, HoldsEveryPrimitiveOnceWithinItsBoxes) {
  for (const Case& c : kCases)
    for (const int lanes : {4, 8, 16})
      for (const uint32_t primitives : {1u, 3u, 5000u}) {
        const GeometryInPartition part = scattered(c, primitives);
        const GeometryTree tree = buildGeometryTree(c.kind, part, lanes);
        Walk walk(tree, c, size_t(lanes));
        walk.node(0, 1);
        EXPECT_EQ(walk.seen.size(), primitives) << c.kind << ", " << lanes;
        EXPECT_LE(walk.deepest, TREE_DEEPEST);
        if (c.kind != KIND_PATHLINES) continue;
        for (const size_t side : {16, 17})  // the first has nothing before it, the last nothing behind
          EXPECT_EQ(
              std::count_if(walk.seen.begin(), walk.seen.end(), [&](const auto& p) { return p[side] == 0; }),
              1);
      }
}

// All in one place, so that no box parts them; and in a series of places, each half as far as the last.
TEST(GeometryTree, IsNoDeeperThanTheStackHolds) {
  for (const bool series : {false, true}) {
    GeometryInPartition part;
    part.primitives = uint32_t(sweep(100'000));
    for (uint32_t p = 0; p < part.primitives; p++)
      part.points.insert(part.points.end(),
                         {series ? std::ldexp(1.f, -int(p % 120)) : 0.5f, 0.5f, 0.5f, 1e-3f * float(p + 1)});
    for (const int lanes : {4, 16}) {
      const GeometryTree tree = buildGeometryTree(KIND_PARTICLES, part, lanes);
      Walk walk(tree, kCases[0], size_t(lanes));
      walk.node(0, 1);
      EXPECT_EQ(walk.seen.size(), part.primitives);
      EXPECT_LE(walk.deepest, TREE_DEEPEST);
    }
  }
}

// And is then the same as if it had never been begun before.
TEST(GeometryTree, IsEndedWhereverItsProgressThrows) {
  for (const Case& c : kCases) {
    const GeometryInPartition part = scattered(c, 30'000);
    GeometryTree tree;
    EXPECT_GE(timesEnded([&](const Advance& advance) { tree = buildGeometryTree(c.kind, part, 8, advance); }),
              4);
    const GeometryTree whole = buildGeometryTree(c.kind, part, 8);
    EXPECT_TRUE(std::ranges::equal(tree.nodes, whole.nodes));
    EXPECT_EQ(tree.leaves.size(), whole.leaves.size());
  }
}

/// The first n primitives once more.
void repeat(const Case& c, GeometryInPartition& part, uint32_t n) {
  const auto append = [n](auto& all, size_t each) {
    if (all.empty()) return;
    const auto first = all;
    all.insert(all.end(), first.begin(), first.begin() + int64_t(each * n));
  };
  if (c.kind == KIND_PARTICLES) append(part.points, 4);
  append(part.indices, c.corners);
  append(part.neighbours, 2);
  part.primitives += n;
}

struct Nearest {
  bool met = false;
  float t = 0;
  uint32_t primitive = 0;
};

// What is tested one by one. goesOn: also what is as far as the last surface, behind it in order.
Nearest nearestOf(const Case& c, const GeometryInPartition& part, const RayView& r, size_t i, bool goesOn) {
  using namespace single;
  const vec3 o = make_v3(r.ox[i], r.oy[i], r.oz[i]), d = make_v3(r.dx[i], r.dy[i], r.dz[i]);
  const float in = r.tIn[i] > 0 ? std::nextafter(r.tIn[i], 0.f) : 0.f;
  const auto number = [&](uint32_t point, size_t k) { return part.points[4 * size_t(point) + k]; };
  const auto at = [&](uint32_t point) {
    return make_v3(number(point, 0), number(point, 1), number(point, 2));
  };
  Nearest nearest;
  nearest.t = std::min(r.tOut[i], r.tEnd[i]);
  for (uint32_t p = 0; p < part.primitives; p++) {
    // The last surface was met in this operator: those of higher numbers may be as far.
    const bool again = goesOn && r.tLast[i] > 0 && p > r.lastPrimitive[i];
    const float after = std::max(in, again ? std::nextafter(r.tLast[i], 0.f) : r.tLast[i]);
    float t = 0;
    bool hit = false;
    if (c.kind == KIND_PARTICLES) {
      vec3 normal;
      hit = hitSphere(o, d, at(p), number(p, 3), after, t, normal);
    } else if (c.kind == KIND_TRIANGLES) {
      const uint32_t* corner = &part.indices[3 * size_t(p)];
      float b, w;
      hit = hitTriangle(o, d, at(corner[0]), at(corner[1]), at(corner[2]), after, t, b, w);
    } else {
      const uint32_t *ends = &part.indices[2 * size_t(p)], *near = &part.neighbours[2 * size_t(p)];
      const Tube tube{at(ends[0]),        at(ends[1]),        at(near[0]),        at(near[1]),
                      number(ends[0], 3), number(ends[1], 3), number(near[0], 3), number(near[1], 3),
                      near[0] != ends[0], near[1] != ends[1]};
      TubeHit h;
      const uint32_t* before = &part.indices[2 * size_t(r.lastPrimitive[i])];
      hit = hitTube(tube, o, d, after, {r.tLast[i], at(before[0]), at(before[1])}, h);
      t = h.t;
    }
    if (hit && t < nearest.t) nearest = {true, t, p};
  }
  return nearest;
}

// Rays from anywhere, from points and from within spheres, along axes too, of lengths other than 1, in parts of their ways; some in
// bundles of up to 48 that go much the same way.
TEST(GeometryRays, MeetWhatOnePrimitiveAfterTheOtherMeets) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> anywhere(-2, 2), unit(0, 1);
  const auto oneOf = [&](uint32_t n) { return random() % n == 0; };
  for (const Case& c : kCases)
    for (const float scale : {1.f, 1e-6f, 1e6f})
      for (const float offset : {0.f, 1000.f}) {
        GeometryInPartition part = scattered(c, 500);
        for (size_t k = 0; k < part.points.size(); k++)
          part.points[k] =
              scale * (k % 4 == 3 ? part.points[k] * 10 * unit(random) : part.points[k] + offset);
        repeat(c, part, 40);
        const GeometryTree tree = buildGeometryTree(c.kind, part, ispc::gangWidth());
        const GeometryTreeView trees{tree.nodes.data(), tree.leaves.data()};
        single::OperatorView op{};
        op.kind = c.kind;
        op.points = part.points.data();
        op.indices = part.indices.data();
        const single::VolumeView field{};
        single::SceneView scene{};
        scene.operators = 1;
        scene.operator_ = &op;
        scene.field = &field;
        scene.hierarchy = &trees;
        constexpr int kRays = sweep(4000);
        RayList rays(kRays);
        rays.resize(kRays);
        RayView r = rays.view();
        size_t alike = 0;
        for (size_t i = 0; i < kRays; i++) {
          const size_t point = 4 * (random() % (part.points.size() / 4));
          const bool from = oneOf(4), through = oneOf(2), again = alike > 0;
          alike = again ? alike - 1 : oneOf(30) ? random() % 48 : 0;
          float o[3], d[3];
          for (size_t k = 0; k < 3; k++) {
            o[k] = from ? part.points[point + k] : scale * (anywhere(random) + offset);
            d[k] = oneOf(6)           ? 0
                   : through && !from ? (part.points[point + k] - o[k]) / scale
                                      : anywhere(random);
          }
          if (again) {  // as the one before, nearly
            const float before[2][3] = {{r.ox[i - 1], r.oy[i - 1], r.oz[i - 1]},
                                        {r.dx[i - 1], r.dy[i - 1], r.dz[i - 1]}};
            for (size_t k = 0; k < 3; k++) {
              o[k] = before[0][k] + (from ? 0.01f * scale * anywhere(random) : 0);
              d[k] = before[1][k] + 0.01f * anywhere(random);
            }
          }
          const float length = std::hypot(d[0], d[1], d[2]);
          const float by = length > 0 ? (oneOf(4) ? 0.7f : 1.f) / length : 0;
          r.info[i] = oneOf(20) ? RAY_OCCLUSION << 16 : RAY_SHADOW << 16;
          r.start[i] = 0;
          r.ox[i] = o[0], r.oy[i] = o[1], r.oz[i] = o[2];
          r.dx[i] = d[0] * by, r.dy[i] = d[1] * by, r.dz[i] = length > 0 ? d[2] * by : 1;
          r.tIn[i] = oneOf(3) ? scale * unit(random) : 0;
          r.tLast[i] = oneOf(3) ? scale * unit(random) : -1;
          r.tOut[i] = scale * (oneOf(2) ? 10 : 2 * unit(random));
          r.tEnd[i] = oneOf(3) ? scale * unit(random) : 1e30f;
          r.lastOperator[i] = 0;
          r.lastPrimitive[i] = random() % 500;
          if (const Nearest before = nearestOf(c, part, r, i, true);
              before.met && oneOf(3)) {  // from there on
            r.tLast[i] = before.t;
            r.lastPrimitive[i] = before.primitive;
          }
          r.A[i] = 0;
          r.hitKind[i] = HIT_NONE;
        }
        ispc::hitGeometry(&scene, &r, kRays, true);
        ispc::hitGeometry(&scene, &r, kRays, false);
        int met = 0;
        for (size_t i = 0; i < kRays; i++) {
          const Nearest expected = nearestOf(c, part, r, i, true);
          met += expected.met;
          const auto where = [&] {
            return std::to_string(c.kind) + ", " + std::to_string(scale) + ", " + std::to_string(offset) +
                   ", ray " + std::to_string(i);
          };
          ASSERT_EQ(r.A[i], nearestOf(c, part, r, i, false).met ? 1.f : 0.f) << where();
          ASSERT_EQ(r.hitKind[i], expected.met ? HIT_GEOMETRY : HIT_NONE) << where();
          if (!expected.met) continue;
          ASSERT_EQ(r.tHit[i], expected.t) << where();
          ASSERT_EQ(r.hitPrimitive[i], expected.primitive) << where();
        }
        EXPECT_GT(met, kRays / 50) << c.kind << ", " << scale << ", " << offset;
        EXPECT_LT(met, kRays * 19 / 20) << c.kind << ", " << scale << ", " << offset;
      }
}

}  // namespace
}  // namespace gxy::test
