// SPDX-License-Identifier: Apache-2.0
// Lines through unstructured volumes against what mathematics says of them.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/analysis/mesh_flows.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

using V = glm::dvec3;

/// A linear field whose numbers floats have, and where it carries a point in a time.
struct LinearFlow {
  const char* name;
  V (*field)(V);
  V (*carried)(V, double);
  double time;    ///< of a line
  double growth;  ///< what the flow makes of an error in that time
};

const V kCentre(0.5, 0.5, 0);

const LinearFlow kUniform{"uniform", [](V) { return V(1, -0.5, 0.25); },
                          [](V p, double t) { return p + t * V(1, -0.5, 0.25); }, 0.25, 1};
const LinearFlow kRotation{"rotation", [](V p) { return V(-(p.y - 0.5), p.x - 0.5, 0.0625); },
                           [](V p, double t) {
                             const V q = p - kCentre;
                             return kCentre + V(q.x * std::cos(t) - q.y * std::sin(t),
                                                q.x * std::sin(t) + q.y * std::cos(t), q.z + t / 16);
                           },
                           5, 1};
const LinearFlow kSaddle{"saddle", [](V p) { return V(p.x - 0.5, -(p.y - 0.5), 0); },
                         [](V p, double t) {
                           const V q = p - kCentre;
                           return kCentre + V(q.x * std::exp(t), q.y * std::exp(-t), q.z);
                         },
                         1.5, std::exp(1.5)};

class LinearLines : public ::testing::TestWithParam<LinearFlow> {};

// Of a linear field all cells have the field itself, bent ones as well.
TEST_P(LinearLines, EndWhereTheFlowCarriesThemWithinTheTolerance) {
  const LinearFlow& flow = GetParam();
  const std::vector<V> seeds = placesIn(V(0.4), V(0.6), sweep(40), 3);
  for (const double bend : {0.0, 0.04})
    for (const NamedMesh& mesh : cubesOfCells(bentBy(bend))) {
      const MeshFlow lines(mesh.piece, flow.field);
      for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
        SCOPED_TRACE(mesh.name + (bend > 0 ? ", bent, " : ", ") + std::to_string(tolerance));
        const Lines traced =
            lines.trace(seeds, {.tolerance = tolerance, .time = flow.time, .points = PointsMode::Ends});
        ASSERT_EQ(traced.count(EndReason::Time), seeds.size());
        for (const LineEnd& e : traced.ends) {
          EXPECT_EQ(e.time, flow.time);
          const double cells = e.length / mesh.cell;
          const double off = glm::length(e.position - flow.carried(seeds[e.line], flow.time)) / mesh.cell;
          EXPECT_LE(off, tolerance * std::max(cells, 1.0) / 100 * flow.growth + 1e-9);
        }
      }
    }
}

TEST_P(LinearLines, GoBackTheWayThatTheyCame) {
  const LinearFlow& flow = GetParam();
  const std::vector<V> seeds = placesIn(V(0.45), V(0.55), 8, 4);
  const MeshFlow lines(cubeOfAllCells(4, bentBy(0.04), noValue), flow.field);
  const TraceOptions options{.tolerance = 1e-6, .time = flow.time / 2, .points = PointsMode::Ends};
  const Lines there = lines.trace(seeds, options);
  std::vector<V> ends;
  for (const LineEnd& e : there.ends) ends.push_back(e.position);
  const Lines back = lines.trace(ends, options, TraceDirection::Backward);
  for (const LineEnd& e : back.ends) {
    EXPECT_EQ(e.time, -flow.time / 2);
    EXPECT_NEAR(e.length, -there.ends[e.line].length, 1e-6);
    EXPECT_LE(glm::length(e.position - seeds[e.line]), 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Flows, LinearLines, ::testing::Values(kUniform, kRotation, kSaddle),
                         [](const auto& flow) { return std::string(flow.param.name); });

TEST(MeshLines, HaveTheLengthOfTheWay) {
  for (const NamedMesh& mesh : cubesOfCells(bentBy(0.04))) {
    const MeshFlow lines(mesh.piece, kRotation.field);
    const V seed(0.75, 0.5, 0.25);
    const Lines traced = lines.trace({seed}, {.tolerance = 1e-6, .time = 4, .points = PointsMode::Ends});
    EXPECT_NEAR(traced.ends[0].length, 4 * std::hypot(0.25, 0.0625), 1e-7) << mesh.name;
  }
}

V abc(V p) {
  const V q = 2 * std::numbers::pi * p;
  return {std::sin(q.z) + 0.7 * std::cos(q.y), 0.8 * std::sin(q.x) + std::cos(q.z),
          0.7 * std::sin(q.y) + 0.8 * std::cos(q.x)};
}

/// Follows a line by the smallest steps: the classical Runge-Kutta method in space, where each stage searches for its cell.
V followed(const Mesh& mesh, V p, double time, int steps) {
  const MeshReader reader(mesh);
  const auto velocity = [&](V q) {
    const auto place = reader.place(0, q);
    V v(0);
    for (int a = 0; a < 3 && place; a++) v[a] = valueAt(mesh, *place, a);
    return v;
  };
  const double h = time / steps;
  for (int i = 0; i < steps; i++) {
    const V k1 = velocity(p), k2 = velocity(p + h / 2 * k1), k3 = velocity(p + h / 2 * k2),
            k4 = velocity(p + h * k3);
    p += h / 6 * (k1 + 2. * k2 + 2. * k3 + k4);
  }
  return p;
}

TEST(MeshLines, OfAnyFieldAreThoseOfTheSmallestSteps) {
  const std::vector<V> seeds = placesIn(V(0.35), V(0.65), 6, 5);
  for (const NamedMesh& mesh : cubesOfCells(bentBy(0.04))) {
    const auto one = meshInOnePiece(withField(mesh.piece, 3, abc), unitBox());
    const MeshFlow lines(mesh.piece, abc);
    const Lines fine = lines.trace(seeds, {.tolerance = 1e-6, .time = 0.2, .points = PointsMode::Ends});
    const Lines coarse = lines.trace(seeds, {.tolerance = 1e-2, .time = 0.2, .points = PointsMode::Ends});
    ASSERT_EQ(fine.count(EndReason::Time), seeds.size()) << mesh.name;
    for (const LineEnd& e : fine.ends) {
      // Steps across faces, where the field has kinks, have an error of order 2.
      const V truth = followed(*one, seeds[e.line], 0.2, 2000);
      EXPECT_LE(glm::length(e.position - truth), 2e-7) << mesh.name;
      EXPECT_LE(glm::length(coarse.end(e.line).position - truth), 1e-3 * mesh.cell) << mesh.name;
    }
  }
}

TEST(MeshLines, ThroughAGridMadeIntoHexahedraAreThoseOfTheGrid) {
  const uint32_t n = 8;
  const Flow grid(gridOver(V(0), V(1), {n + 1, n + 1, n + 1}), abc);
  const MeshFlow mesh(cubeOfHexes(n, noMove, noValue), abc);
  const std::vector<V> seeds = placesIn(V(0), V(1), 60, 6);
  const TraceOptions options{.tolerance = 1e-4, .length = 1.5};
  const Lines a = grid.trace(seeds, options), b = mesh.trace(seeds, options);
  ASSERT_EQ(a.ends.size(), b.ends.size());
  for (size_t i = 0; i < a.ends.size(); i++) {
    EXPECT_EQ(a.ends[i].reason, b.ends[i].reason);
    EXPECT_EQ(a.ends[i].points, b.ends[i].points);
    EXPECT_NEAR(a.ends[i].time, b.ends[i].time, 1e-5);
    EXPECT_NEAR(a.ends[i].length, b.ends[i].length, 1e-5);
    EXPECT_LE(glm::length(a.ends[i].position - b.ends[i].position), 2e-5);
  }
}

TEST(MeshLines, OfDataOfCellsGoThroughTheirAveragesAtPoints) {
  MeshPiece piece = cubeOfHexes(8, noMove, noValue);
  piece.ofCells = true;
  piece.components = 3;
  piece.values.clear();
  auto& values = piece.cellValues[size_t(CellType::Hexahedron)];
  const std::vector<V> centres = centresOf(piece, CellType::Hexahedron);
  for (const V& c : centres)
    for (const double x : {-(c.y - 0.5), c.x - 0.5, 0.0625}) values.push_back(float(x));
  piece.duplicates[size_t(CellType::Hexahedron)].assign(centres.size(), 0);
  const auto partitioning = std::make_shared<const Partitioning>(Partitioning::single(unitBox()));
  const auto mesh = cut(WholeMesh{piece}, *partitioning, 1).at(0);
  const MeshFields fields({mesh}, partitioning);
  const Lines lines = trace(fields, fields, {V(0.7, 0.5, 0.3)}, {.tolerance = 1e-6, .time = 5});
  EXPECT_LE(glm::length(lines.ends[0].position - kRotation.carried(V(0.7, 0.5, 0.3), 5)), 1e-6);
}

}  // namespace
}  // namespace gxy::test
