// SPDX-License-Identifier: Apache-2.0
// Where lines end, which points are stored, and what is recorded at them.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "tests/kernels/random.h"
#include "tests/lines/flow_fields.h"

namespace gxy::test {
namespace {

const double kPi = std::numbers::pi;

Flow rotation() {
  return Flow(gridOver({-1, -1, -1}, {1, 1, 1}, {9, 9, 5}),
              [](glm::dvec3 p) { return glm::dvec3(-p.y, p.x, 0); });
}
Flow uniform() {
  return Flow(gridOver({0, 0, 0}, {8, 2, 2}, {9, 3, 3}), [](glm::dvec3) { return glm::dvec3(2, 0, 0); });
}

TEST(Limits, EachEndsLinesInItsOwnUnitAndIsMetExactly) {
  const Flow flow = uniform();
  const LineEnd time = flow.trace({{0.25, 1, 1}}, {.time = 1.3}).ends[0];
  EXPECT_EQ(time.reason, EndReason::Time);
  EXPECT_EQ(time.time, 1.3);
  EXPECT_NEAR(time.position.x, 2.85, 1e-6);
  const LineEnd length = flow.trace({{0.25, 1, 1}}, {.length = 3.3}).ends[0];
  EXPECT_EQ(length.reason, EndReason::Length);
  EXPECT_EQ(length.length, 3.3);
  EXPECT_NEAR(length.position.x, 3.55, 1e-6);
  EXPECT_NEAR(length.time, 1.65, 1e-6);
  const LineEnd steps = flow.trace({{0.25, 1, 1}}, {.steps = 3}).ends[0];
  EXPECT_EQ(steps.reason, EndReason::Steps);
  EXPECT_EQ(steps.position.x, 3);
  const LineEnd left = flow.trace({{0.25, 1, 1}}).ends[0];
  EXPECT_EQ(left.reason, EndReason::Left);
  EXPECT_EQ(left.position.x, 8);
}

TEST(Limits, LengthsOfCurvedLinesAreMetExactly) {
  const Flow flow = rotation();
  for (const double length : {1e-7, 0.01, 1.0, 2 * kPi * 0.6, 123.0}) {
    const LineEnd e = flow.trace({{0.6, 0, 0.1}}, {.length = length}).ends[0];
    ASSERT_EQ(e.reason, EndReason::Length);
    EXPECT_EQ(e.length, length);
    EXPECT_NEAR(e.time, length / 0.6, 1e-5 * length / 0.6 + 1e-9);
  }
}

TEST(Limits, OfZeroEndLinesAtTheirSeeds) {
  const Flow flow = uniform();
  const TraceOptions all[] = {{.time = 0}, {.length = 0}, {.steps = 0}};
  const EndReason reasons[] = {EndReason::Time, EndReason::Length, EndReason::Steps};
  for (int k = 0; k < 3; k++) {
    const Lines lines = flow.trace({{0.5, 0.5, 0.5}}, all[k]);
    EXPECT_EQ(lines.ends[0].reason, reasons[k]);
    EXPECT_EQ(lines.ends[0].position, glm::dvec3(0.5));
    EXPECT_EQ(lines.points.size(), 1u);
  }
}

TEST(Limits, WithoutAnyLinesEndAfterTenDiagonals) {
  const Flow flow = rotation();
  const LineEnd e = flow.trace({{0.6, 0, 0}}).ends[0];
  EXPECT_EQ(e.reason, EndReason::Length);
  EXPECT_EQ(e.length, 10 * std::sqrt(12.0));
}

TEST(Ends, SlowLinesEndAtTheMinimumSpeedAndAtZeros) {
  const Flow flow(gridOver({-1, -1, -1}, {1, 1, 1}, {8, 8, 8}), [](glm::dvec3 p) { return -p; });
  const LineEnd slow = flow.trace({{0.9, 0, 0}}, {.minimumSpeed = 0.3}).ends[0];
  EXPECT_EQ(slow.reason, EndReason::Slow);
  EXPECT_LE(slow.position.x, 0.3);
  EXPECT_GE(slow.position.x, 0.3 * std::exp(-0.11));
  const LineEnd zero = flow.trace({{0.9, 0.3, -0.2}}).ends[0];
  EXPECT_EQ(zero.reason, EndReason::Slow);
  EXPECT_LE(glm::length(zero.position), 1e-6);
  const Flow still(gridOver({-1, -1, -1}, {1, 1, 1}, {3, 3, 3}), [](glm::dvec3) { return glm::dvec3(0); });
  EXPECT_EQ(still.trace({{0.9, 0.3, -0.2}}).ends[0].reason, EndReason::Slow);
}

TEST(Ends, ACellWithoutDataEndsLinesOnItsFace) {
  for (const double hole : {double(NAN), double(INFINITY), -double(INFINITY)}) {
    const Flow flow(gridOver({0, 0, 0}, {8, 2, 2}, {9, 3, 3}),
                    [&](glm::dvec3 p) { return glm::dvec3(2, p.x == 5 && p.y == 1 ? hole : 0, 0); });
    const Lines lines = flow.trace({{0.25, 0.5, 1.5}, {4.5, 0.5, 0.5}});
    EXPECT_EQ(lines.ends[0].reason, EndReason::NoData);
    EXPECT_EQ(lines.ends[0].position.x, 4);
    EXPECT_EQ(lines.ends[1].reason, EndReason::NoData);
    EXPECT_EQ(lines.ends[1].points, 1);
    EXPECT_TRUE(std::isnan(lines.points.speed.back()));
  }
}

TEST(Points, OfCellsAreTheSeedAllCrossingsAndTheEnd) {
  const Flow flow = uniform();
  const Lines lines = flow.trace({{0.25, 1, 1}}, {.time = 1.3});
  ASSERT_EQ(lines.points.size(), 4u);
  const double expected[] = {0.25, 1, 2, 2.85};
  for (int i = 0; i < 4; i++) {
    EXPECT_EQ(lines.points.number[size_t(i)], i);
    EXPECT_NEAR(lines.points.position[size_t(i)].x, expected[i], 1e-6);
    EXPECT_NEAR(lines.points.time[size_t(i)], (expected[i] - 0.25) / 2, 1e-6);
    EXPECT_NEAR(lines.points.length[size_t(i)], expected[i] - 0.25, 1e-6);
    EXPECT_EQ(lines.points.speed[size_t(i)], 2);
  }
  EXPECT_EQ(lines.ends[0].points, 4);
}

TEST(Points, OfALineThatLeavesEndOnTheDomain) {
  const Lines lines = uniform().trace({{6.5, 1, 1}});
  ASSERT_EQ(lines.points.size(), 3u);
  EXPECT_EQ(lines.points.position.back().x, 8);
}

TEST(Points, OfEndsAreTwo) {
  const Lines lines = rotation().trace({{0.6, 0, 0}, {0.3, 0.1, 0}}, {.time = 5, .points = PointsMode::Ends});
  ASSERT_EQ(lines.points.size(), 4u);
  EXPECT_EQ(lines.points.number, (std::vector<int32_t>{0, 1, 0, 1}));
  EXPECT_EQ(lines.points.time[1], 5);
}

TEST(Points, AtEqualTimesAreExactMultiplesWhateverTheTolerance) {
  const Flow flow = rotation();
  for (const double dt : {0.003, 0.1, 0.7, 7.0}) {
    std::vector<PathPoints> all;
    for (const double tolerance : {1e-3, 1e-4})
      all.push_back(
          flow.trace({{0.6, 0, 0}},
                     {.tolerance = tolerance, .time = 21, .points = PointsMode::EqualTime, .interval = dt})
              .points);
    const size_t n = size_t(std::floor(21 / dt + 1e-9)) + 1;
    ASSERT_EQ(all[0].size(), n) << dt;
    ASSERT_EQ(all[1].size(), n) << dt;
    for (size_t i = 0; i < n; i++) {
      EXPECT_EQ(all[0].time[i], double(i) * dt);
      const double angle = double(i) * dt;
      const glm::dvec3 truth(0.6 * std::cos(angle), 0.6 * std::sin(angle), 0);
      for (const PathPoints& points : all) {
        EXPECT_LE(glm::length(points.position[i] - truth), 2e-5);
        EXPECT_NEAR(points.length[i], 0.6 * angle, 2e-5);
        EXPECT_NEAR(points.speed[i], 0.6f, 1e-5f);
      }
    }
  }
}

TEST(Points, AtEqualLengthsAreExactMultiples) {
  const Flow flow = rotation();
  for (const double ds : {0.002, 0.05, 1.0}) {
    const Lines lines =
        flow.trace({{0.6, 0, 0}}, {.time = 3.001, .points = PointsMode::EqualLength, .interval = ds});
    ASSERT_EQ(lines.points.size(), size_t(std::floor(1.8006 / ds)) + 1) << ds;
    for (size_t i = 0; i < lines.points.size(); i++) {
      const double angle = double(i) * ds / 0.6;
      EXPECT_EQ(lines.points.length[i], double(i) * ds);
      EXPECT_NEAR(lines.points.time[i], angle, 1e-5);
      EXPECT_LE(glm::length(lines.points.position[i] - 0.6 * glm::dvec3(std::cos(angle), std::sin(angle), 0)),
                1e-5);
    }
  }
}

TEST(Points, FarMoreThanOneACellAllCome) {
  const Lines lines =
      uniform().trace({{0, 1, 1}}, {.time = 4, .points = PointsMode::EqualTime, .interval = 1e-5});
  ASSERT_EQ(lines.points.size(), 400001u);
  for (size_t i = 0; i < lines.points.size(); i += 997) {
    EXPECT_EQ(lines.points.number[i], int32_t(i));
    EXPECT_NEAR(lines.points.position[i].x, 2e-5 * double(i), 1e-6);
  }
}

TEST(Directions, BackwardLinesHaveNegativeTimesAndNumbersAndBothShareTheSeed) {
  const Flow flow = uniform();
  const Lines lines = flow.trace({{4.5, 1, 1}}, {.time = 1}, TraceDirection::Both);
  ASSERT_EQ(lines.ends.size(), 2u);
  EXPECT_EQ(lines.ends[1].time, -1);
  EXPECT_NEAR(lines.ends[1].position.x, 2.5, 1e-6);
  std::vector<int32_t> numbers;
  for (int32_t n = -3; n <= 3; n++) numbers.push_back(n);
  EXPECT_EQ(lines.points.number, numbers);
  for (size_t i = 0; i < numbers.size(); i++) {
    EXPECT_NEAR(lines.points.position[i].x, 4.5 + 2 * lines.points.time[i], 1e-6);
    EXPECT_NEAR(lines.points.length[i], 2 * lines.points.time[i], 1e-6);
  }
  EXPECT_EQ(flow.trace({{4.5, 1, 1}}, {.time = 1}, TraceDirection::Backward).points.size(), 4u);
}

TEST(FieldLines, HaveTheirLengthAsTime) {
  const Flow flow = rotation();
  const Lines lines = flow.trace({{0.6, 0, 0}}, {.time = 2.5, .normalised = true});
  EXPECT_EQ(lines.ends[0].reason, EndReason::Time);
  EXPECT_EQ(lines.ends[0].time, 2.5);
  EXPECT_EQ(lines.ends[0].length, 2.5);
  const double angle = 2.5 / 0.6;
  EXPECT_LE(glm::length(lines.ends[0].position - 0.6 * glm::dvec3(std::cos(angle), std::sin(angle), 0)),
            1e-5);
  const Lines points = flow.trace(
      {{0.6, 0, 0}}, {.time = 2.5, .normalised = true, .points = PointsMode::EqualTime, .interval = 0.1});
  ASSERT_EQ(points.points.size(), 26u);
  EXPECT_EQ(points.points.time[3], 3 * 0.1);
  EXPECT_EQ(points.points.length[3], 3 * 0.1);
}

// Three fields beside the vectors, of which one is of narrow integers.
class Recording : public testing::Test {
 protected:
  const Grid grid_ = gridOver({-1, -1, -1}, {1, 1, 1}, {9, 9, 5});
  const Partitioning cut_ = Partitioning::single(grid_.box());
  const std::shared_ptr<const Volume> bytes_ = volumeOf(
      grid_, cut_, 1, [](glm::dvec3 p) { return std::vector<double>{100 + 80 * p.x}; }, ScalarType::UInt8);
  const std::shared_ptr<const CompiledFields> fields_ = std::make_shared<const CompiledFields>(
      std::vector{volumeOf(grid_, cut_, 3, vectorsOf([](glm::dvec3 p) { return glm::dvec3(-p.y, p.x, 0); })),
                  volumeOf(grid_, cut_, 2,
                           [](glm::dvec3 p) {
                             return std::vector<double>{3 * p.x + p.y, p.z};
                           }),
                  bytes_},
      std::make_shared<const Partitioning>(cut_));
  const std::unique_ptr<DeviceFields> device_ = makePlainFields(fields_, 0);
};

TEST_F(Recording, ValuesOfOtherFieldsAreThoseAtThePoints) {
  ASSERT_EQ(fields_->recorded().size(), 3u);
  const Lines lines = trace(*device_, *fields_, {{0.6, 0, 0.2}}, {.time = 6});
  const PathPoints& p = lines.points;
  ASSERT_EQ(p.values.size(), 3u);
  for (size_t i = 0; i < p.size(); i++) {
    EXPECT_NEAR(p.values[0][i], 3 * p.position[i].x + p.position[i].y, 1e-6);
    EXPECT_NEAR(p.values[1][i], 0.2f, 1e-7f);
    EXPECT_NEAR(p.values[2][i], 100 + 80 * p.position[i].x, 1e-4);
  }
}

TEST_F(Recording, AConditionEndsLinesWithinAStepOfWhereItIsMet) {
  const Lines lines =
      trace(*device_, *fields_, {{0.6, 0, 0.2}, {-0.6, 0, 0}}, {.condition = TraceCondition{0, -10, 0}});
  const LineEnd& e = lines.ends[0];
  EXPECT_EQ(e.reason, EndReason::Condition);
  const double value = 3 * e.position.x + e.position.y;
  EXPECT_LE(value, 0);
  EXPECT_GE(value, -3.2 * grid_.spacing.x);
  EXPECT_EQ(lines.ends[1].reason, EndReason::Condition);
  EXPECT_EQ(lines.ends[1].points, 1);
}

TEST(StoredTypes, OfIntegersGiveTheLinesOfTheirValues) {
  const Grid grid = gridOver({-1, -1, -1}, {1, 1, 1}, {9, 9, 5});
  const FlowFunction f = [](glm::dvec3 p) { return glm::dvec3(60 + 8 * p.y, 40 - 8 * p.x, 4); };
  const Lines expected = Flow(grid, f).trace({{-0.9, -0.8, -0.3}}, {.time = 0.02});
  for (const ScalarType type : {ScalarType::Int8, ScalarType::UInt8, ScalarType::Int16, ScalarType::UInt16}) {
    const Lines lines = Flow(grid, f, type).trace({{-0.9, -0.8, -0.3}}, {.time = 0.02});
    EXPECT_EQ(lines.points.position, expected.points.position) << nameOf(type);
  }
}

// The samples are centres of cells, so the data end half a cell inside the outermost points.
TEST(Rims, LinesEndWhereTheDataDo) {
  Grid grid = gridOver({-0.5, -0.5, -0.5}, {8.5, 2.5, 2.5}, {10, 4, 4});
  grid.rim = true;
  const Flow flow(grid, [](glm::dvec3) { return glm::dvec3(2, 0, 0); });
  const Lines lines = flow.trace({{0, 1, 1}, {8, 1, 1}, {-0.1, 1, 1}}, {}, TraceDirection::Both);
  EXPECT_EQ(lines.end(0).reason, EndReason::Left);
  EXPECT_EQ(lines.end(0).position.x, 8);
  EXPECT_EQ(lines.end(0, true).length, 0);
  EXPECT_EQ(lines.end(1).length, 0);
  EXPECT_EQ(lines.end(1, true).position.x, 0);
  EXPECT_EQ(lines.end(2).reason, EndReason::Outside);
}

}  // namespace
}  // namespace gxy::test
