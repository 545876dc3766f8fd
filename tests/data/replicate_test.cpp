// SPDX-License-Identifier: Apache-2.0
#include "core/data/replicate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "core/comm/error.h"
#include "tests/data/random_partitioning.h"
#include "tests/support/ended.h"

namespace gxy {
namespace {

Box domainBox() {
  Box b;
  b.lo = {-1, 0, 100};
  b.hi = {1, 3, 101};
  return b;
}

double radiusOf(double value) { return 0.002 * value; }

/// Random primitives, some outside the domain, some with a coordinate on a face; lines and meshes share
/// points. Meshes have colours, the others values. All have two fields besides.
GeometryBlock randomGeometry(std::mt19937& random, GeometryKind kind, const Partitioning& p,
                             uint32_t points) {
  GeometryBlock block;
  block.fields = {{"pair", 2, {}}, {"one", 1, {}}};
  const Box& d = p.domain();
  for (uint32_t i = 0; i < points; ++i) {
    glm::dvec3 x;
    for (int a = 0; a < 3; ++a) {
      const double side = d.hi[a] - d.lo[a];
      const auto faces = p.faces(a);
      const double previous = block.points.empty() ? d.lo[a] : block.points.back()[a];
      switch (random() % 4) {
        case 0:
          x[a] = faces[random() % faces.size()];
          break;
        case 1:
          x[a] = std::uniform_real_distribution<>(d.lo[a] - 0.2 * side, d.hi[a] + 0.2 * side)(random);
          break;
        default:
          x[a] = previous + std::uniform_real_distribution<>(-0.05, 0.05)(random) * side;
      }
    }
    block.points.push_back(x);
    block.normals.push_back({0, 0, float(i % 7)});
    for (PointField& f : block.fields)
      for (int c = 0; c < f.components; c++) f.values.push_back(float(random() % 20));
    if (kind == GeometryKind::Triangles)
      block.colors.push_back({float(random() % 30) / 29, float(random() % 2), 0.5f});
    else
      block.values.push_back(float(random() % 30));
    if (kind == GeometryKind::PathLines) block.radiusValues.push_back(float(random() % 20));
  }
  for (uint32_t i = 0; i < points; ++i) {
    if (kind == GeometryKind::Particles) block.ids.push_back(i * 3 + 1);
    if (kind == GeometryKind::PathLines && i + 1 < points) {
      block.segments.push_back({i, i + 1});
      block.neighbours.push_back({i > 0 ? i - 1 : i, i + 2 < points ? i + 2 : i + 1});
      block.ids.push_back(i + 5);
    }
    if (kind == GeometryKind::Triangles && i + 2 < points) {
      block.triangles.push_back({i, i + 1, i + 2});
      block.ids.push_back(i);
    }
  }
  return block;
}

/// The definition, by comparing each primitive's box with each partition's.
std::set<uint64_t> idsTouching(const GeometryBlock& all, GeometryKind kind, const Partitioning& p, int part) {
  std::set<uint64_t> ids;
  for (size_t i = 0; i < all.ids.size(); ++i) {
    Box box;
    double reach = 0;
    for (uint32_t c : primitivePoints(all, kind, i)) {
      box.extend(all.points[c]);
      if (kind != GeometryKind::Triangles)
        reach = std::max(reach, radiusOf(kind == GeometryKind::PathLines ? double(all.radiusValues[c])
                                                                         : double(all.values[c])));
    }
    reach += borderSlack(p);
    bool touches = true;
    for (int a = 0; a < 3; ++a) {
      const double lo = p.box(part).lo[a], hi = p.box(part).hi[a];
      touches = touches && (lo == p.domain().lo[a] || box.hi[a] + reach >= lo);
      touches = touches && (hi == p.domain().hi[a] || box.lo[a] - reach <= hi);
    }
    if (touches) ids.insert(all.ids[i]);
  }
  return ids;
}

/// The blocks of all partitions of a rank, when all messages come at once.
std::map<int, GeometryBlock> unpackReceived(
    GeometryKind kind, const Partitioning& p, int rank, std::span<const Bytes> messages,
    const Advance& advance = [](double) {}) {
  ReceivedBlocks received(kind, p, rank);
  received.take(messages);
  return received.merged(advance);
}

/// All blocks when the primitives are spread over the ranks at random and messages arrive in random order.
std::map<int, GeometryBlock> replicateOver(std::mt19937& random, const GeometryBlock& all, GeometryKind kind,
                                           const Partitioning& p, int ranks) {
  std::vector<std::vector<uint32_t>> readBy(static_cast<size_t>(ranks));
  for (uint32_t i = 0; i < all.ids.size(); ++i) readBy[random() % readBy.size()].push_back(i);
  std::vector<std::vector<Bytes>> arrived(static_cast<size_t>(ranks));
  for (const auto& mine : readBy) {
    std::vector<Bytes> messages = packForOwners(subset(all, kind, mine), kind, p, radiusOf, ranks);
    for (size_t r = 0; r < messages.size(); ++r) arrived[r].push_back(std::move(messages[r]));
  }
  std::map<int, GeometryBlock> blocks;
  for (int r = 0; r < ranks; ++r) {
    std::shuffle(arrived[size_t(r)].begin(), arrived[size_t(r)].end(), random);
    blocks.merge(unpackReceived(kind, p, r, arrived[size_t(r)]));
  }
  return blocks;
}

class Replicate : public testing::TestWithParam<GeometryKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, Replicate,
                         testing::Values(GeometryKind::Particles, GeometryKind::PathLines,
                                         GeometryKind::Triangles));

TEST_P(Replicate, EveryPartitionHasExactlyThePrimitivesThatTouchIt) {
  std::mt19937 random(42);
  for (int ranks = 1; ranks <= 8; ++ranks) {
    const Partitioning p = test::randomPartitioning(random, domainBox(), 1 + ranks * 2, ranks);
    const GeometryBlock all = randomGeometry(random, GetParam(), p, 150);
    const std::map<int, GeometryBlock> blocks = replicateOver(random, all, GetParam(), p, ranks);
    ASSERT_EQ(blocks.size(), size_t(p.partitions()));
    for (const auto& [part, block] : blocks) {
      EXPECT_NO_THROW(validate(block, GetParam()));
      const std::set<uint64_t> expected = idsTouching(all, GetParam(), p, part);
      EXPECT_EQ(block.ids, std::vector<uint64_t>(expected.begin(), expected.end()));
    }
  }
}

TEST_P(Replicate, NeitherReadersNorArrivalChangeABlock) {
  std::mt19937 random(43);
  const Partitioning p = test::randomPartitioning(random, domainBox(), 11, 4);
  const GeometryBlock all = randomGeometry(random, GetParam(), p, 200);
  const auto first = replicateOver(random, all, GetParam(), p, 4);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(replicateOver(random, all, GetParam(), p, 4), first);
}

TEST_P(Replicate, PrimitivesArriveAsTheyWereRead) {
  std::mt19937 random(44);
  const GeometryKind kind = GetParam();
  const Partitioning p = test::randomPartitioning(random, domainBox(), 6, 3);
  const GeometryBlock all = randomGeometry(random, kind, p, 120);
  std::map<uint64_t, size_t> byId;
  for (size_t i = 0; i < all.ids.size(); ++i) byId[all.ids[i]] = i;
  const auto expectSame = [&](const GeometryBlock& block, uint32_t got, uint32_t original) {
    EXPECT_EQ(block.points[got], all.points[original]);
    EXPECT_EQ(block.normals[got], all.normals[original]);
    if (kind == GeometryKind::Triangles)
      EXPECT_EQ(block.colors[got], all.colors[original]);
    else
      EXPECT_EQ(block.values[got], all.values[original]);
    EXPECT_EQ(block.radiusValues.empty(), all.radiusValues.empty());
    if (!all.radiusValues.empty()) {
      EXPECT_EQ(block.radiusValues[got], all.radiusValues[original]);
    }
  };
  for (const auto& [part, block] : replicateOver(random, all, kind, p, 3)) {
    for (size_t i = 0; i < block.ids.size(); ++i) {
      const size_t original = byId.at(block.ids[i]);
      const PrimitivePoints got = primitivePoints(block, kind, i),
                            want = primitivePoints(all, kind, original);
      for (int c = 0; c < got.count; ++c) expectSame(block, got.points[size_t(c)], want.points[size_t(c)]);
      if (kind == GeometryKind::PathLines) {
        for (size_t n : {0, 1}) expectSame(block, block.neighbours[i][n], all.neighbours[original][n]);
      }
    }
    EXPECT_LE(block.points.size(), all.points.size());
  }
}

TEST_P(Replicate, EachPrimitiveHasOneHome) {
  std::mt19937 random(45);
  const Partitioning p = test::randomPartitioning(random, domainBox(), 9, 5);
  const GeometryBlock all = randomGeometry(random, GetParam(), p, 300);
  std::vector<uint64_t> ids;
  for (const std::vector<uint32_t>& home : homesOf(all, GetParam(), p, 5))
    for (const uint32_t primitive : home) ids.push_back(all.ids[primitive]);
  std::sort(ids.begin(), ids.end());
  EXPECT_EQ(ids, all.ids);
}

TEST_P(Replicate, IsEndedWhereverItsProgressThrows) {
  std::mt19937 random(47);
  const Partitioning p = test::randomPartitioning(random, domainBox(), 5, 1);
  const GeometryBlock all = randomGeometry(random, GetParam(), p, 30'000);
  std::vector<std::vector<uint32_t>> homes;
  EXPECT_GE(test::timesEnded([&](const Advance& a) { homes = homesOf(all, GetParam(), p, 1, a); }), 3);
  const GeometryBlock home = subset(all, GetParam(), homes.at(0));
  std::vector<Bytes> messages;
  EXPECT_GE(test::timesEnded(
                [&](const Advance& a) { messages = packForOwners(home, GetParam(), p, radiusOf, 1, a); }),
            4);
  std::map<int, GeometryBlock> blocks;
  EXPECT_GE(
      test::timesEnded([&](const Advance& a) { blocks = unpackReceived(GetParam(), p, 0, messages, a); }), 3);
  EXPECT_EQ(blocks, unpackReceived(GetParam(), p, 0, packForOwners(home, GetParam(), p, radiusOf, 1)));
}

TEST_P(Replicate, TruncatedMessagesAreRefused) {
  std::mt19937 random(46);
  const Partitioning p = Partitioning::single(domainBox());
  const Bytes whole = packForOwners(randomGeometry(random, GetParam(), p, 5), GetParam(), p, radiusOf, 1)[0];
  for (size_t size = 1; size < whole.size(); ++size) {
    const Bytes cut(whole.begin(), whole.begin() + std::ptrdiff_t(size));
    EXPECT_THROW(unpackReceived(GetParam(), p, 0, std::span(&cut, 1)), Error) << size;
  }
}

TEST(ReplicateParticles, CoincidentOnesAreAllKept) {
  const Partitioning p = Partitioning::single(domainBox());
  GeometryBlock block;
  block.points.assign(1000, {0, 1, 100.5});
  for (uint64_t i = 0; i < 1000; ++i) block.ids.push_back(i);
  const std::vector<Bytes> messages = packForOwners(block, GeometryKind::Particles, p, radiusOf, 1);
  EXPECT_EQ(unpackReceived(GeometryKind::Particles, p, 0, messages).at(0), block);
}

TEST(ReplicateParticles, InfiniteRadiiTouchEveryPartitionAndNanNone) {
  std::mt19937 random(1);
  const Partitioning p = test::randomPartitioning(random, domainBox(), 7, 1);
  Box point;
  point.extend({0, 1, 100.5});
  EXPECT_EQ(partitionsTouched(p, point, INFINITY).size(), 7u);
  GeometryBlock block;
  block.points = {{0, 1, 100.5}};
  block.ids = {0};
  const auto nan = [](double) { return NAN; };
  size_t copies = 0;
  for (const auto& [part, b] : unpackReceived(GeometryKind::Particles, p, 0,
                                              packForOwners(block, GeometryKind::Particles, p, nan, 1))) {
    copies += b.ids.size();
  }
  EXPECT_EQ(copies, 1u);
}

TEST(ReplicateTriangles, AnIdThatComesTwiceIsRefused) {
  std::mt19937 random(1);
  const Partitioning p = Partitioning::single(domainBox());
  const GeometryBlock block = randomGeometry(random, GeometryKind::Triangles, p, 5);
  std::vector<Bytes> messages = packForOwners(block, GeometryKind::Triangles, p, radiusOf, 1);
  messages.push_back(messages[0]);
  EXPECT_THROW(unpackReceived(GeometryKind::Triangles, p, 0, messages), Error);
}

TEST(Geometry, UnusablePrimitivesAreDroppedAndCounted) {
  GeometryBlock block;
  block.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {NAN, 0, 0}, {1e-200, 0, 0}, {0, 1e-200, 0}};
  block.triangles = {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}, {0, 0, 1}, {0, 5, 6}};
  block.ids = {10, 11, 12, 13, 14};
  EXPECT_EQ(dropUnusable(block, GeometryKind::Triangles), 3);
  EXPECT_EQ(block.ids, (std::vector<uint64_t>{10, 14}));
  EXPECT_EQ(block.points.size(), 5u);
  EXPECT_EQ(dropUnusable(block, GeometryKind::Triangles), 0);
}

TEST(Geometry, RepeatedPointsOfALineAreDroppedAndTheirNeighboursJoined) {
  GeometryBlock block;
  const auto addLine = [&](std::initializer_list<double> xs) {
    const auto first = uint32_t(block.points.size()), last = first + uint32_t(xs.size()) - 1;
    for (double x : xs) block.points.push_back({x, 0, 0}), block.values.push_back(float(x));
    for (uint32_t i = first; i < last; i++) {
      block.ids.push_back(block.ids.size());
      block.segments.push_back({i, i + 1});
      block.neighbours.push_back({i > first ? i - 1 : i, i + 1 < last ? i + 2 : i + 1});
    }
  };
  addLine({0, 0, 1, 1, 1, 2, 2});  // ids 0 to 5
  addLine({3, 3, 3});              // 6, 7
  addLine({4, 4, 5});              // 8, 9: of another value, so no repetition
  block.values[11] = 9;
  EXPECT_EQ(dropUnusable(block, GeometryKind::PathLines), 5);
  EXPECT_EQ(block.ids, (std::vector<uint64_t>{1, 4, 6, 8, 9}));
  const GeometryBlock one = merged(GeometryKind::PathLines, std::span(&block, 1));
  const auto x = [&](uint32_t point) { return one.points[point].x; };
  using Ends = std::array<double, 4>;  // before, first, second, after
  const std::vector<Ends> expected{{0, 0, 1, 2}, {0, 1, 2, 2}, {3, 3, 3, 3}, {4, 4, 4, 5}, {4, 4, 5, 5}};
  for (size_t p = 0; p < expected.size(); p++) {
    const auto [a, b] = one.segments[p];
    const auto [before, after] = one.neighbours[p];
    EXPECT_EQ((Ends{x(before), x(a), x(b), x(after)}), expected[p]) << p;
    EXPECT_EQ(before != a, p == 1 || p == 4) << p;
    EXPECT_EQ(after != b, p == 0 || p == 3) << p;
  }
}

TEST(Geometry, PointsOfDifferentColoursStayTwo) {
  GeometryBlock block;
  block.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 1}};
  block.colors = {{1, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0.5f}, {1, 0, 0}};
  block.triangles = {{0, 1, 2}, {3, 4, 5}};
  block.ids = {0, 1};
  const GeometryBlock one = merged(GeometryKind::Triangles, std::span(&block, 1));
  EXPECT_EQ(one.triangles, (std::vector<std::array<uint32_t, 3>>{{0, 1, 2}, {0, 3, 4}}));
  EXPECT_EQ(one.colors[3], glm::vec3(1, 0, 0.5f));
  GeometryBlock line;
  line.points = {{0, 0, 0}, {0, 0, 0}, {1, 0, 0}};
  line.colors = {{1, 0, 0}, {0, 1, 0}, {0, 1, 0}};
  line.segments = {{0, 1}, {1, 2}};
  line.neighbours = {{0, 2}, {0, 2}};
  line.ids = {0, 1};
  EXPECT_EQ(dropUnusable(line, GeometryKind::PathLines), 0) << "a ball of each colour";
  line.colors[1] = line.colors[0];
  GeometryBlock same = line;
  EXPECT_EQ(dropUnusable(same, GeometryKind::PathLines), 1);
  line.radiusValues = {1, 2, 2};
  EXPECT_EQ(dropUnusable(line, GeometryKind::PathLines), 0) << "a ball of each radius";
  Geometry geometry;
  geometry.blocks[0] = block;
  EXPECT_EQ(bytesOf(geometry), 6 * 24 + 6 * 12 + 2 * 12 + 2 * 8);
}

TEST(Geometry, InconsistentBlocksAreRefused) {
  GeometryBlock block;
  block.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  block.triangles = {{0, 1, 2}};
  block.ids = {0};
  EXPECT_NO_THROW(validate(block, GeometryKind::Triangles));
  EXPECT_THROW(validate(block, GeometryKind::Particles), Error);
  EXPECT_THROW(validate(block, GeometryKind::PathLines), Error);
  block.values = {1};
  EXPECT_THROW(validate(block, GeometryKind::Triangles), Error);
  block.values.clear();
  block.colors.assign(2, glm::vec3(1));
  EXPECT_THROW(validate(block, GeometryKind::Triangles), Error);
  block.colors.assign(3, glm::vec3(1));
  EXPECT_NO_THROW(validate(block, GeometryKind::Triangles));
  GeometryBlock plain = block;
  plain.colors.clear();
  plain.ids = {1};
  EXPECT_THROW(merged(GeometryKind::Triangles, std::vector{block, plain}), Error);
  block.radiusValues.assign(2, 1);
  EXPECT_THROW(validate(block, GeometryKind::Triangles), Error);
  block.radiusValues.clear();
  block.values.assign(3, 1);
  EXPECT_THROW(validate(block, GeometryKind::Triangles), Error) << "values and colours";
  block.values.clear();
  block.triangles[0][1] = 3;
  EXPECT_THROW(validate(block, GeometryKind::Triangles), Error);
}

}  // namespace
}  // namespace gxy
