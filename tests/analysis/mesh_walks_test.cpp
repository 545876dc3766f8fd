// SPDX-License-Identifier: Apache-2.0
// How lines go from cell to cell of unstructured volumes: on any ranks and cuts alike, along faces, over what is wrong with a mesh, and
// why they end.
#include <gtest/gtest.h>

#include <limits>

#include "core/analysis/mesh_heads.h"
#include "tests/analysis/mesh_flows.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

using V = glm::dvec3;

V swirl(V p) {
  return {-(p.y - 0.5) + 0.2 * std::sin(9 * p.z), p.x - 0.5 + 0.1 * std::cos(7 * p.x),
          0.3 * std::cos(5 * p.y)};
}
V alongX(V) { return {1, 0, 0}; }

/// Lines of ranks that are one thread, whose messages and tasks come in the order of a seed.
Lines tracedOnRanks(const std::vector<RankFlow>& flow, const std::vector<V>& seeds,
                    const TraceOptions& options, TraceDirection direction, uint64_t seed) {
  Traces traces(seed, flow, {});
  const FlightId id = traces.announce();
  traces.begin(id, seeds, options, direction);
  EXPECT_TRUE(traces.run(3'000'000));
  EXPECT_EQ(traces.outcome(id).ending.error, "");
  EXPECT_TRUE(traces.errors().empty());
  return traces.take(id);
}

void expectSameOnAnyCuts(const MeshPiece& cells, const std::vector<V>& seeds, const TraceOptions& options,
                         TraceDirection direction = TraceDirection::Forward) {
  const std::string expected = bitsOf(MeshFlow(cells, swirl).trace(seeds, options, direction));
  std::vector<Cut> cuts = manyCuts(unitBox(), 11);
  for (const int ranks : {1, 3}) {
    cuts.push_back(lattice(unitBox(), {2, 1, 1}, ranks));
    cuts.push_back(lattice(unitBox(), {3, 1, 1}, ranks));
    cuts.push_back(lattice(unitBox(), {2, 2, 2}, ranks));
  }
  uint64_t seed = 1;
  for (const Cut& cut : cuts) {
    const auto flow = meshFlowOnRanks(cells, swirl, cut);
    EXPECT_TRUE(bitsOf(tracedOnRanks(flow, seeds, options, direction, seed++)) == expected)
        << cut.name << ", " << cut.ranks << " ranks";
  }
}

/// Seeds inside, and some on faces, edges and points of cubes with sides of 1/4, where borders of partitions are, too.
std::vector<V> manySeeds(int n) {
  std::vector<V> seeds = placesIn(V(0), V(1), n, 9);
  for (const V& p : {V(0.25, 0.3, 0.3), V(0.5, 0.5, 0.3), V(0.5, 0.5, 0.5), V(0.75, 0.25, 0.4), V(0, 0, 0),
                     V(1, 0.5, 0.5), V(2, 0, 0)})
    seeds.push_back(p);
  return seeds;
}

TEST(MeshWalks, AreTheSameOnAnyRanksAndCuts) {
  for (const NamedMesh& mesh : cubesOfCells(bentBy(0.05))) {
    SCOPED_TRACE(mesh.name);
    expectSameOnAnyCuts(mesh.piece, manySeeds(sweep(24)), {.length = 3});
  }
}

TEST(MeshWalks, AreTheSameOnAnyRanksAndCutsHoweverPointsAreStored) {
  const MeshPiece cells = cubeOfAllCells(4, bentBy(0.05), noValue);
  const std::vector<V> seeds = manySeeds(12);
  expectSameOnAnyCuts(cells, seeds, {.time = 2, .points = PointsMode::EqualTime, .interval = 0.13},
                      TraceDirection::Both);
  expectSameOnAnyCuts(
      cells, seeds, {.length = 1.5, .normalised = true, .points = PointsMode::EqualLength, .interval = 0.11},
      TraceDirection::Backward);
  expectSameOnAnyCuts(
      cells, seeds,
      {.tolerance = 1e-6, .steps = 20, .points = PointsMode::Ends, .condition = TraceCondition{0, 1, 1.2}},
      TraceDirection::Both);
}

TEST(MeshWalks, ThroughTangledCellsAllEndAndAreTheSameOnAnyRanksAndCuts) {
  // By so much of the sides of the cubes points are moved, and so many lines of 1000 get stuck at most.
  for (const auto& [bend, most] : {std::pair(0.2, 0), std::pair(0.6, 20), std::pair(1.6, 300)})
    for (const NamedMesh& mesh : cubesOfCells(bentBy(bend / 4))) {
      SCOPED_TRACE(mesh.name + ", " + std::to_string(bend));
      const std::vector<V> seeds = manySeeds(200);  // always as many, as a rate is asked for
      const Lines lines = MeshFlow(mesh.piece, swirl).trace(seeds, {.length = 2}, TraceDirection::Both);
      EXPECT_EQ(lines.ends.size(), 2 * seeds.size());
      EXPECT_LE(1000 * lines.count(EndReason::Stuck), size_t(most) * lines.ends.size());
      EXPECT_EQ(lines.count(EndReason::Closed), 0u);
      if (bend > 0.2)
        expectSameOnAnyCuts(mesh.piece, manySeeds(sweep(8)), {.length = 2}, TraceDirection::Both);
    }
}

TEST(MeshWalks, AlongFacesAndEdgesGoStraightOn) {
  std::vector<V> seeds;
  for (const double y : {0.0, 0.25, 0.3, 0.5, 1.0})
    for (const double z : {0.0, 0.1, 0.5, 0.75, 1.0}) seeds.push_back({0, y, z});
  for (const NamedMesh& mesh : cubesOfCells(noMove)) {
    SCOPED_TRACE(mesh.name);
    const Lines lines = MeshFlow(mesh.piece, alongX).trace(seeds, {.points = PointsMode::Ends});
    for (const LineEnd& e : lines.ends) {
      EXPECT_EQ(e.reason, EndReason::Left) << e.line;
      EXPECT_LE(glm::length(e.position - (seeds[e.line] + V(1, 0, 0))), 1e-9) << e.line;
      EXPECT_NEAR(e.time, 1, 1e-9) << e.line;
    }
  }
}

TEST(MeshWalks, AlongDiagonalsGoThroughPointsOfTheMesh) {
  for (const NamedMesh& mesh : cubesOfCells(noMove)) {
    SCOPED_TRACE(mesh.name);
    const MeshFlow lines(mesh.piece, [](V) { return V(1, 1, 1); });
    const Lines traced = lines.trace({V(0), V(0.125), V(0.25)}, {.points = PointsMode::Ends});
    for (const LineEnd& e : traced.ends) {
      EXPECT_EQ(e.reason, EndReason::Left) << e.line;
      EXPECT_LE(glm::length(e.position - V(1)), 1e-9) << e.line;
    }
  }
}

TEST(MeshWalks, StayOnAWallThatTheFieldFollows) {
  // Nothing goes through the wall z = 0, and the field turns on it.
  const auto onWall = [](V p) { return V(-(p.y - 0.5), p.x - 0.5, p.z); };
  for (const NamedMesh& mesh : cubesOfCells(noMove)) {
    const Lines lines = MeshFlow(mesh.piece, onWall).trace({V(0.8, 0.5, 0)}, {.tolerance = 1e-6, .time = 6});
    EXPECT_EQ(lines.ends[0].reason, EndReason::Time) << mesh.name;
    EXPECT_LE(std::abs(lines.ends[0].position.z), 1e-8) << mesh.name;
    EXPECT_LE(glm::length(lines.ends[0].position - V(0.5 + 0.3 * std::cos(6), 0.5 + 0.3 * std::sin(6), 0)),
              1e-6)
        << mesh.name;
  }
}

/// Hexahedra without one of them.
MeshPiece withHole(uint32_t n, uint32_t cell) {
  MeshPiece piece = cubeOfHexes(n, noMove, noValue);
  auto& hexes = piece.cells.points[size_t(CellType::Hexahedron)];
  hexes.erase(hexes.begin() + 8 * cell, hexes.begin() + 8 * (cell + 1));
  return piece;
}

TEST(MeshWalks, EndAtHolesAndDoNotBeginInThem) {
  const MeshFlow lines(withHole(4, 1 + 4 * (1 + 4 * 1)), alongX);
  const Lines traced = lines.trace({V(0.1, 0.4, 0.4), V(0.3, 0.4, 0.4), V(0.6, 0.4, 0.4)}, {});
  EXPECT_EQ(traced.end(0).reason, EndReason::Left);
  EXPECT_LE(glm::length(traced.end(0).position - V(0.25, 0.4, 0.4)), 1e-9);
  EXPECT_EQ(traced.end(0).points, 2);
  EXPECT_EQ(traced.end(1).reason, EndReason::Outside);
  EXPECT_EQ(traced.end(1).points, 0);
  EXPECT_EQ(traced.end(1).position, V(0.3, 0.4, 0.4));
  EXPECT_EQ(traced.end(2).reason, EndReason::Left);
  EXPECT_LE(glm::length(traced.end(2).position - V(1, 0.4, 0.4)), 1e-9);
  expectSameOnAnyCuts(withHole(4, 21), manySeeds(10), {.length = 3});
}

/// Cubes of 1/4 where x < 1/2, and others of 1/8: points hang in the faces between them, whose coordinates are a little off.
MeshPiece withHangingPoints(double off) {
  const auto half = [](MeshPiece piece, double from) {
    for (V& p : piece.points) p.x = from + 0.5 * p.x;
    return piece;
  };
  MeshPiece fine = half(cubeOfHexes(8, noMove, noValue), 0.5);
  for (V& p : fine.points)
    if (p.x == 0.5) p.x += off;
  return joined(half(cubeOfHexes(4, noMove, noValue), 0), fine);
}

TEST(MeshWalks, GoOnOverHangingPoints) {
  for (const double off : {0.0, 5e-8, -5e-8}) {
    const MeshPiece piece = withHangingPoints(off);
    const MeshFlow lines(piece, [](V) { return V(1, 0.25, -0.125); });
    const std::vector<V> seeds = placesIn(V(0.05, 0.1, 0.2), V(0.3, 0.7, 0.9), 20, 3);
    for (const bool backward : {false, true}) {
      std::vector<V> from = seeds;
      if (backward)
        for (V& p : from) p.x = 1 - p.x, p.y = 1 - p.y, p.z = 1 - p.z;
      const Lines traced = lines.trace(from, {.time = 0.6, .points = PointsMode::Ends},
                                       backward ? TraceDirection::Backward : TraceDirection::Forward);
      for (const LineEnd& e : traced.ends) {
        EXPECT_EQ(e.reason, EndReason::Time) << off;
        EXPECT_LE(glm::length(e.position - (from[e.line] + e.time * V(1, 0.25, -0.125))), 1e-6) << off;
      }
    }
    expectSameOnAnyCuts(piece, manySeeds(10), {.length = 2});
  }
}

TEST(MeshWalks, GoThroughTetrahedraWithoutVolume) {
  // The halves of the face x = 1/2 are others on both sides, and between them is a flat tetrahedron.
  MeshPiece left = cubeOfTets(1, noMove, noValue), right = left;
  for (V& p : left.points) p.x = 0.5 * p.x;
  for (V& p : right.points) p = V(0.5 + 0.5 * p.x, 1 - p.y, p.z);
  MeshPiece piece = joined(left, right);
  auto& tets = piece.cells.points[size_t(CellType::Tetrahedron)];
  tets.insert(tets.end(), {1, 3, 7, 5});
  const std::vector<V> seeds = placesIn(V(0.05, 0.1, 0.1), V(0.45, 0.9, 0.9), 50, 2);
  for (const auto direction : {TraceDirection::Forward, TraceDirection::Backward}) {
    const double sign = direction == TraceDirection::Forward ? 1 : -1;
    const Lines lines = MeshFlow(piece, [sign](V) {
                          return V(sign, 0, 0);
                        }).trace(seeds, {.points = PointsMode::Ends}, direction);
    for (const LineEnd& e : lines.ends) {
      EXPECT_EQ(e.reason, EndReason::Left) << e.line;
      EXPECT_LE(glm::length(e.position - V(1, seeds[e.line].y, seeds[e.line].z)), 1e-9) << e.line;
    }
  }
}

TEST(MeshWalks, AreTheSameInUnitsOfAnySize) {
  const MeshPiece piece = cubeOfAllCells(4, bentBy(0.04), noValue);
  const std::vector<V> seeds = manySeeds(20);
  const Lines lines = MeshFlow(piece, swirl).trace(seeds, {.time = 2});
  for (const double unit : {0x1p40, 0x1p-40}) {
    MeshPiece scaled = piece;
    std::vector<V> from = seeds;
    for (auto* points : {&scaled.points, &from})
      for (V& p : *points) p *= unit;
    const MeshFlow flow(
        scaled, [unit](V p) { return unit * swirl(p / unit); }, whole({V(0), V(unit)}));
    const Lines traced = flow.trace(from, {.time = 2});
    ASSERT_EQ(traced.points.size(), lines.points.size());
    for (size_t i = 0; i < lines.points.size(); i++) {
      EXPECT_EQ(traced.points.position[i] / unit, lines.points.position[i]);
      EXPECT_EQ(traced.points.time[i], lines.points.time[i]);
    }
  }
}

TEST(MeshWalks, GoThroughCellsThatOverlapAndFacesOfThreeCells) {
  MeshPiece piece = cubeOfHexes(4, noMove, noValue);
  // Another hexahedron on the face between two of them, which reaches into one of the two.
  auto& hexes = piece.cells.points[size_t(CellType::Hexahedron)];
  std::vector<uint32_t> more(hexes.begin() + 8 * 21, hexes.begin() + 8 * 22);
  for (size_t k : {1, 2, 5, 6}) {
    const V p = piece.points[more[k]] + V(0.125, 0, 0);
    more[k] = uint32_t(piece.points.size());
    piece.points.push_back(p);
    piece.numbers.push_back(piece.numbers.size());
  }
  hexes.insert(hexes.end(), more.begin(), more.end());
  const Lines lines = MeshFlow(piece, alongX).trace({V(0.1, 0.4, 0.4)}, {.points = PointsMode::Ends});
  EXPECT_EQ(lines.ends[0].reason, EndReason::Left);
  EXPECT_LE(glm::length(lines.ends[0].position - V(1, 0.4, 0.4)), 1e-9);
  expectSameOnAnyCuts(piece, manySeeds(20), {.length = 3}, TraceDirection::Both);
}

TEST(MeshWalks, EndForTheReasonsOfLines) {
  const MeshPiece piece = cubeOfAllCells(4, bentBy(0.04), noValue);
  const MeshFlow lines(piece, alongX);
  const V seed(0.1, 0.4, 0.4);
  const auto endOf = [&](const TraceOptions& options) { return lines.trace({seed}, options).ends[0]; };
  EXPECT_EQ(endOf({.time = 0.5}).reason, EndReason::Time);
  EXPECT_EQ(endOf({.time = 0.5}).time, 0.5);
  EXPECT_EQ(endOf({.length = 0.5}).reason, EndReason::Length);
  EXPECT_EQ(endOf({.length = 0.5}).length, 0.5);
  EXPECT_LE(glm::length(endOf({.length = 0.5}).position - V(0.6, 0.4, 0.4)), 5e-6);
  EXPECT_EQ(endOf({.time = 0}).reason, EndReason::Time);
  EXPECT_EQ(endOf({.time = 0}).points, 1);
  EXPECT_EQ(endOf({.steps = 2}).reason, EndReason::Steps);
  EXPECT_EQ(endOf({.minimumSpeed = 1.5}).reason, EndReason::Slow);
  // The recorded scalar is x y + z.
  const LineEnd met = endOf({.condition = TraceCondition{0, 0.6, 2}});
  EXPECT_EQ(met.reason, EndReason::Condition);
  EXPECT_NEAR(met.position.x, 0.5, 0.26);
  EXPECT_GE(met.position.x, 0.45);
  EXPECT_EQ(lines.trace({V(std::numeric_limits<double>::quiet_NaN())}, {}).ends[0].reason,
            EndReason::Outside);
  const MeshFlow stagnant(piece, [](V p) { return V(0.5) - p; });
  EXPECT_EQ(stagnant.trace({seed}, {}).ends[0].reason, EndReason::Slow);
  EXPECT_LE(glm::length(stagnant.trace({seed}, {}).ends[0].position - V(0.5)), 1e-5);
  const MeshFlow around(cubeOfHexes(1, noMove, noValue), [](V p) { return V(0.5 - p.y, p.x - 0.5, 0); });
  EXPECT_EQ(around.trace({seed}, {.length = 1e300, .points = PointsMode::Ends}).ends[0].reason,
            EndReason::Closed);
  const MeshFlow still(piece, [](V) { return V(0); });
  EXPECT_EQ(still.trace({seed}, {}).ends[0].reason, EndReason::Slow);
}

TEST(MeshWalks, EndAtCellsWithoutData) {
  const MeshFlow lines(cubeOfHexes(4, noMove, noValue), [](V p) {
    return p == V(0.75, 0.5, 0.5) ? V(std::numeric_limits<double>::quiet_NaN()) : V(1, 0, 0);
  });
  const Lines traced = lines.trace({V(0.1, 0.4, 0.4), V(0.6, 0.4, 0.4)}, {});
  EXPECT_EQ(traced.end(0).reason, EndReason::NoData);
  EXPECT_LE(glm::length(traced.end(0).position - V(0.5, 0.4, 0.4)), 1e-9);
  EXPECT_EQ(traced.end(1).reason, EndReason::NoData);
  EXPECT_EQ(traced.end(1).points, 1);
}

TEST(MeshWalks, StorePointsAtEqualTimesAndLengths) {
  const MeshFlow lines(cubeOfAllCells(4, bentBy(0.04), noValue), [](V) { return V(2, 0, 0); });
  const V seed(0.125, 0.4, 0.4);
  const Lines byTime =
      lines.trace({seed}, {.time = 0.375, .points = PointsMode::EqualTime, .interval = 0.0625});
  ASSERT_EQ(byTime.points.size(), 7u);
  const Lines byLength =
      lines.trace({seed}, {.length = 0.75, .points = PointsMode::EqualLength, .interval = 0.125});
  ASSERT_EQ(byLength.points.size(), 7u);
  for (size_t i = 0; i < 7; i++) {
    EXPECT_EQ(byTime.points.time[i], 0.0625 * double(i));
    EXPECT_EQ(byLength.points.length[i], 0.125 * double(i));
    for (const Lines* l : {&byTime, &byLength}) {
      const V& p = l->points.position[i];
      EXPECT_LE(glm::length(p - (seed + V(0.125 * double(i), 0, 0))), 5e-6);
      EXPECT_NEAR(l->points.values[0][i], p.x * p.y + p.z, 0.01) << "the scalar is not linear";
      EXPECT_EQ(l->points.speed[i], 2);
    }
  }
}

TEST(MeshWalks, DoNotDependOnPackets) {
  const MeshFlow lines(cubeOfAllCells(4, bentBy(0.05), noValue), swirl, lattice(unitBox(), {2, 2, 2}, 1));
  const std::vector<V> seeds = manySeeds(30);
  EXPECT_TRUE(bitsOf(lines.trace(seeds, {.length = 2}, TraceDirection::Both, 1)) ==
              bitsOf(lines.trace(seeds, {.length = 2}, TraceDirection::Both)));
}

TEST(MeshWalks, RefuseFieldsThatAreNoVectorsOrOnOtherCells) {
  const auto partitioning = std::make_shared<const Partitioning>(Partitioning::single(unitBox()));
  const auto mesh = [&](uint32_t n, int components) {
    return cut(WholeMesh{withField(cubeOfHexes(n, noMove, noValue), components, alongX)}, *partitioning, 1)
        .at(0);
  };
  const auto errorOf = [&](std::vector<std::shared_ptr<const Mesh>> meshes) -> std::string {
    try {
      MeshFields(std::move(meshes), partitioning);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(errorOf({mesh(2, 1)}), "unstructured volume \"mesh\" has 1 components; lines need vectors of 3");
  EXPECT_EQ(errorOf({mesh(2, 3), mesh(3, 1)}),
            "unstructured volume \"mesh\" has other points or cells than the vectors \"mesh\"; expected the "
            "same, of the same import");
  EXPECT_EQ(errorOf({}), "lines read 0 volumes; expected 1 to 8");
  EXPECT_EQ(errorOf({mesh(2, 3), mesh(2, 1)}), "");
}

TEST(MeshWalks, HeadsThatNoRankWouldSendAreRefused) {
  const auto refused = [](auto spoil) {
    HeadList heads(0, 1, kMeshHeads);
    heads.clear(0, 5, false);
    MeshHead head;
    head.leaving = 2;
    spoil(head);
    head.writeTo(heads, 0);
    return wrongInMesh(heads) != nullptr;
  };
  EXPECT_FALSE(refused([](MeshHead&) {}));
  EXPECT_TRUE(refused([](MeshHead& h) { h.cell = 3; }));
  EXPECT_TRUE(refused([](MeshHead& h) { h.leaving = -1; }));
  EXPECT_TRUE(refused([](MeshHead& h) { h.place.x = 1.5; }));
  EXPECT_TRUE(refused([](MeshHead& h) { h.place.y = std::numeric_limits<double>::quiet_NaN(); }));
  EXPECT_TRUE(refused([](MeshHead& h) { h.near.y = std::numeric_limits<float>::infinity(); }));
  EXPECT_TRUE(refused([](MeshHead& h) { h.time = -1; }));
  EXPECT_TRUE(refused([](MeshHead& h) { h.step = 0; }));
  EXPECT_TRUE(refused([](MeshHead& h) { h.points = -1; }));
}

}  // namespace
}  // namespace gxy::test
