// SPDX-License-Identifier: Apache-2.0
// The wrapper for C++, without a server. That it is C++11 is a matter of the example wave.cpp.
#include "insitu/api/galaxy_insitu.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace {

using gxy::insituType;
using gxy::Simulation;

constexpr const char* kNobodyThere = R"({"to": "127.0.0.1:1", "token-file": "-"})";
const Simulation::Indices kWhole{{4, 3, 2}}, kBegin{{0, 0, 0}};

static_assert(insituType<signed char>() == GXY_INT8 && insituType<unsigned char>() == GXY_UINT8);
static_assert(insituType<short>() == GXY_INT16 && insituType<unsigned short>() == GXY_UINT16);
static_assert(insituType<int>() == GXY_INT32 && insituType<unsigned>() == GXY_UINT32);
static_assert(insituType<long long>() == GXY_INT64 && insituType<unsigned long long>() == GXY_UINT64);
static_assert(insituType<float>() == GXY_FLOAT32 && insituType<double>() == GXY_FLOAT64);
static_assert(!std::is_copy_constructible_v<Simulation> && !std::is_copy_assignable_v<Simulation>);
static_assert(std::is_nothrow_move_constructible_v<Simulation> &&
              std::is_nothrow_move_assignable_v<Simulation>);

void expectStrides(const gxy_array& array, int64_t x, int64_t y, int64_t z) {
  EXPECT_EQ(array.stride[0], x);
  EXPECT_EQ(array.stride[1], y);
  EXPECT_EQ(array.stride[2], z);
}

TEST(Wrapper, ValuesInAnArrayWithGhostsHaveItsStrides) {
  const std::vector<double> whole(6 * 5 * 4);
  const gxy_array array = gxy::values(&whole[1 + 6 * (1 + 5)], {{6, 5, 4}});
  EXPECT_EQ(array.data, whole.data() + 37);
  EXPECT_EQ(array.type, GXY_FLOAT64);
  EXPECT_EQ(array.components, 1);
  EXPECT_EQ(array.memory, 0);
  expectStrides(array, 8, 48, 240);
}

TEST(Wrapper, ComponentsStandTogetherOrApart) {
  const std::vector<float> vectors(4 * 3 * 2 * 3);
  const gxy_array together = gxy::values(vectors.data(), kWhole, 3);
  EXPECT_EQ(together.components, 3);
  EXPECT_EQ(together.component_stride, 0);
  expectStrides(together, 12, 48, 144);
  const gxy_array apart = gxy::strided(vectors.data(), {{4, 16, 48}}, 3, 96);
  EXPECT_EQ(apart.component_stride, 96);
  expectStrides(apart, 4, 16, 48);
}

TEST(Wrapper, IsOffUnlessItIsSaidWhereTo) {
  const std::vector<float> values(4 * 3 * 2);
  Simulation sim("heat");
  EXPECT_EQ(sim.grid(kWhole, kBegin, kWhole), GXY_TAKEN);
  EXPECT_EQ(sim.field("t", gxy::values(values.data(), kWhole)), GXY_TAKEN);
  EXPECT_EQ(sim.publish(1, 0.5), GXY_OFF);
  EXPECT_EQ(sim.publishLast(2, 1), GXY_OFF);
  EXPECT_STREQ(sim.message(), "");
}

TEST(Wrapper, FieldsAreOfWhatTheGridCounts) {
  const std::vector<float> values(4 * 3 * 2);
  Simulation sim("heat", 1, 2, kNobodyThere);
  EXPECT_EQ(sim.grid(kWhole, kBegin, kWhole, {{0, 0, 0}}, {{1, 1, 1}}, GXY_OF_CELLS, 3), GXY_TAKEN);
  EXPECT_EQ(sim.field("t", gxy::values(values.data(), kWhole), 3), GXY_TAKEN);
  EXPECT_EQ(sim.field("t", gxy::values(values.data(), kWhole)), GXY_WRONG);
  EXPECT_NE(std::string(sim.message()).find("there is no block 0"), std::string::npos) << sim.message();
}

TEST(Wrapper, ParticlesAreRowsOfValues) {
  const std::vector<double> positions(6);
  const std::vector<long long> ids(2);
  expectStrides(gxy::row(positions.data(), 3), 24, 0, 0);
  expectStrides(gxy::row(positions.data(), 3, 64), 64, 0, 0);
  const double box[6] = {0, 0, 0, 1, 1, 1};
  Simulation sim("cloud", 0, 1, kNobodyThere);
  EXPECT_EQ(sim.grid(kWhole, kBegin, kWhole, {{0, 0, 0}}, {{1, 1, 1}}, GXY_OF_CELLS), GXY_TAKEN);
  EXPECT_EQ(sim.points(2, gxy::row(positions.data(), 3), gxy::row(ids.data()), box), GXY_TAKEN)
      << sim.message();
  EXPECT_EQ(sim.pointField("mass", gxy::row(positions.data())), GXY_TAKEN) << sim.message();
  EXPECT_EQ(sim.points(2, gxy::row(positions.data(), 2)), GXY_WRONG);
}

TEST(Wrapper, CellsAreRowsOfNumbers) {
  const std::vector<float> positions{0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::vector<int> triangles{0, 1, 2, 2, 1, 0}, offsets{0, 3, 6};
  const std::vector<unsigned char> types{GXY_TRIANGLE, GXY_POLYGON};
  expectStrides(gxy::allOf(GXY_QUAD), 0, 0, 0);
  EXPECT_EQ(*static_cast<const unsigned char*>(gxy::allOf(GXY_QUAD).data), 9);
  Simulation sim("sea", 0, 1, kNobodyThere);
  const gxy_array at = gxy::row(positions.data(), 3), corners = gxy::row(triangles.data());
  EXPECT_EQ(sim.cells(3, at, 2, gxy::allOf(GXY_TRIANGLE), corners), GXY_TAKEN) << sim.message();
  EXPECT_EQ(sim.cells(3, at, 2, gxy::row(types.data()), corners), GXY_WRONG) << "there are no offsets";
  EXPECT_EQ(sim.cells(3, at, 2, gxy::row(types.data()), corners, gxy::row(offsets.data())), GXY_TAKEN)
      << sim.message();
  EXPECT_EQ(sim.cellsField("height", gxy::row(positions.data())), GXY_TAKEN) << sim.message();
  EXPECT_EQ(sim.cellsField("region", gxy::row(offsets.data()), GXY_OF_CELLS), GXY_TAKEN) << sim.message();
  const std::vector<long long> pyramid{0, 1, 2, 1, 0};
  EXPECT_EQ(sim.cells(3, at, 1, gxy::allOf(GXY_PYRAMID), gxy::row(pyramid.data()), gxy_array(), "volume"),
            GXY_TAKEN)
      << sim.message();
  EXPECT_EQ(sim.cellsField("heat", gxy::row(positions.data()), GXY_OF_POINTS, "volume"), GXY_TAKEN);
  EXPECT_EQ(sim.publish(1, 0), GXY_LOST) << sim.message();
}

TEST(Wrapper, StepsAreAskedForSkippedAndSteered) {
  const std::vector<float> values(4 * 3 * 2);
  Simulation sim(
      "heat", 0, 1,
      R"({"to": "127.0.0.1:1", "token-file": "-", "steerable": [{"name": "dt", "least": 0, "largest": 1}]})");
  sim.grid(kWhole, kBegin, kWhole);
  sim.field("t", gxy::values(values.data(), kWhole));
  double dt = 0;
  EXPECT_EQ(sim.skip(1, 0.5), GXY_LOST);
  EXPECT_FALSE(sim.wanted(2, 1));
  EXPECT_EQ(sim.settle(2, true), GXY_TAKEN);
  EXPECT_EQ(sim.publish(2, 1), GXY_LOST);
  EXPECT_FALSE(sim.steered("dt", dt));
  EXPECT_FALSE(sim.steered("dx", dt));
  EXPECT_NE(std::string(sim.message()).find("steerable"), std::string::npos);
}

TEST(Wrapper, AStreamMovesWithItsObject) {
  const std::vector<float> values(4 * 3 * 2);
  Simulation first("heat", 0, 1, kNobodyThere);
  first.grid(kWhole, kBegin, kWhole, {{0, 0, 0}}, {{1, 1, 1}}, GXY_OF_CELLS);
  Simulation second(std::move(first));
  EXPECT_EQ(second.field("t", gxy::values(values.data(), kWhole)), GXY_TAKEN);
  Simulation third("other");
  third = std::move(second);
  EXPECT_EQ(third.publish(1, 0), GXY_LOST);
  EXPECT_EQ(third.publish(2, 0), GXY_LOST);
  EXPECT_EQ(third.statistics().offered, 2);
  third.close(0);
  EXPECT_EQ(third.publish(3, 0), GXY_WRONG);
  EXPECT_EQ(third.statistics().offered, 0);
  third.close(0);
}

}  // namespace
