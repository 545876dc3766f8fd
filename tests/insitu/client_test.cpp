// SPDX-License-Identifier: Apache-2.0
// The C interface without a server.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <string>

#include "insitu/api/galaxy_insitu.h"

extern "C" int publish_from_c(void);

namespace {

constexpr int64_t kSize[3] = {4, 4, 4}, kFirst[3] = {0, 0, 0};
constexpr double kOrigin[3] = {0, 0, 0}, kSpacing[3] = {1, 1, 1};
constexpr const char* kNowhere = R"({"to": "127.0.0.1:1", "token-file": "-"})";

struct Sim {
  explicit Sim(const char* options = nullptr, const char* name = "heat", int rank = 0, int ranks = 1)
      : sim(gxy_open(name, rank, ranks, options)) {}
  ~Sim() { gxy_close(sim, 0); }
  Sim(const Sim&) = delete;
  Sim& operator=(const Sim&) = delete;
  int grid(const char* mesh = "grid", int block = 0) {
    return gxy_grid(sim, mesh, block, GXY_OF_POINTS, kSize, kFirst, kSize, kOrigin, kSpacing);
  }
  int field(const char* name, const gxy_array& array, int block = 0) {
    return gxy_field(sim, "grid", block, name, GXY_OF_POINTS, array);
  }
  gxy_array array() const { return {values, GXY_FLOAT32, 1, {4, 16, 64}, 0, 0}; }
  std::string message() const { return gxy_message(sim); }
  void expectWrong(int result, const std::string& why) const {
    EXPECT_EQ(result, GXY_WRONG);
    EXPECT_NE(message().find(why), std::string::npos) << message();
  }
  gxy_sim* sim;
  float values[64] = {};
};

TEST(Interface, IsUsedFromC) { EXPECT_EQ(publish_from_c(), 0); }

TEST(Interface, IsOffUnlessItIsSaidWhereTo) {
  Sim s;
  EXPECT_EQ(s.grid(), GXY_TAKEN);
  EXPECT_EQ(s.field("t", s.array()), GXY_TAKEN);
  EXPECT_EQ(gxy_publish(s.sim, 1, 0), GXY_OFF);
  EXPECT_EQ(s.message(), "");
}

TEST(Interface, TheEnvironmentSaysWhereTo) {
  setenv("GALAXY_INSITU", "nowhere", 1);
  Sim wrong;
  unsetenv("GALAXY_INSITU");
  wrong.expectWrong(gxy_publish(wrong.sim, 1, 0), "expected \"off\", \"here\" or HOST:PORT");
  setenv("GALAXY_INSITU", "off", 1);
  Sim off(kNowhere);
  unsetenv("GALAXY_INSITU");
  EXPECT_EQ(gxy_publish(off.sim, 1, 0), GXY_OFF);
}

TEST(Interface, WrongOptionsAreTold) {
  const auto expect = [](const char* options, const char* why) {
    Sim s(options);
    s.expectWrong(s.grid(), why);
  };
  expect("[]", "expected a JSON object");
  expect(R"({"two": 1})", "there is no option \"two\", expected one of between, checksum, every, here");
  expect(R"({"to": 5})", "option \"to\": expected a text");
  expect(R"({"to": "here"})", "no server runs in this program, expected gxy_open_mpi()");
  expect(R"({"to": "here:70000"})", "expected \"off\", \"here\" or HOST:PORT");
  expect(R"({"scope": "all"})", "expected \"private\" or \"shared\"");
  expect(R"({"reconnect": -1})", "expected seconds");
  expect(R"({"steerable": {}})", "option \"steerable\": expected a list");
  expect(R"({"steerable": [{"name": "dt", "least": 1, "largest": 0}]})",
         "option \"steerable\": expected a list");
  expect(R"({"triggers": 5})", "expected a list, or the name of a file");
  expect(R"({"to": "127.0.0.1:1", "triggers": "nowhere.json"})", "nowhere.json cannot be read");
  expect(R"({"to": "127.0.0.1:1", "triggers": "/dev/null"})", "has no JSON list");
  expect(R"({"checksum": 1})", "option \"checksum\": expected true, false, or null");
  expect(R"({"every": 0})", "expected an integer from 1 up");
  expect(R"({"between": [1]})", "expected two times");
  expect(R"({"policy": "all"})", "expected \"skip\" or \"wait\"");
  expect(R"({"policy": "wait"})", "option \"time-out\": expected with policy \"wait\"");
  expect(R"({"policy": "wait", "time-out": -1})", "expected seconds from 0 up, or null");
}

TEST(Interface, WrongRanksAndNamesAreTold) {
  Sim rank(nullptr, "heat", 2, 2);
  rank.expectWrong(rank.grid(), "rank 2 of 2");
  Sim name(nullptr, "");
  name.expectWrong(name.grid(), "the name of a stream has 0 bytes");
  Sim null(nullptr, nullptr);
  null.expectWrong(null.grid(), "is NULL, expected a text");
  EXPECT_EQ(gxy_publish(nullptr, 1, 0), GXY_WRONG);
  EXPECT_STRNE(gxy_message(nullptr), "");
}

TEST(Interface, WrongGridsAndFieldsAreToldAndChangeNothing) {
  Sim s(kNowhere);
  const int64_t large[3] = {4, 4, 5};
  s.expectWrong(gxy_publish(s.sim, 1, 0),
                "expected gxy_grid() and gxy_field(), gxy_points() or gxy_cells() first");
  s.expectWrong(s.field("t", s.array()),
                "there is no mesh \"grid\", expected gxy_grid(), gxy_points() or gxy_cells() first");
  const int64_t none[3] = {4, 4, 0}, negative[3] = {4, 4, -1};
  s.expectWrong(gxy_grid(s.sim, "grid", 0, GXY_OF_CELLS, none, kFirst, none, kOrigin, kSpacing), "size 0");
  s.expectWrong(gxy_grid(s.sim, "grid", 0, GXY_OF_POINTS, kSize, negative, kSize, kOrigin, kSpacing),
                "first -1");
  s.expectWrong(gxy_grid(s.sim, "grid", 0, 7, kSize, kFirst, kSize, kOrigin, kSpacing),
                "expected one of gxy_of");
  s.expectWrong(gxy_grid(s.sim, "grid", 0, GXY_OF_POINTS, kSize, kFirst, large, kOrigin, kSpacing),
                "inside the grid");
  s.expectWrong(gxy_grid(s.sim, "grid", 0, GXY_OF_POINTS, kSize, kFirst, nullptr, kOrigin, kSpacing),
                "is NULL");
  EXPECT_EQ(s.grid(), GXY_TAKEN);
  s.expectWrong(gxy_publish(s.sim, 1, 0), "there is no field on mesh \"grid\"");
  s.expectWrong(s.field("t", s.array(), 1), "there is no block 1 on this rank");
  s.expectWrong(gxy_grid(s.sim, "grid", 1, GXY_OF_CELLS, kSize, kFirst, kSize, kOrigin, kSpacing),
                "cells beside points");
  s.expectWrong(gxy_field(s.sim, "grid", 0, "t", GXY_OF_CELLS, s.array()),
                "values of cells on a mesh that counts points");
  gxy_array a = s.array();
  a.type = 10;
  s.expectWrong(s.field("t", a), "type 10, expected one of gxy_type");
  a = s.array();
  a.stride[1] = 0;
  s.expectWrong(s.field("t", a), "stride[1] is 0");
  a = s.array();
  a.data = nullptr;
  s.expectWrong(s.field("t", a), "there are no data");
  a = s.array();
  a.memory = 1;
  s.expectWrong(s.field("t", a), "expected 0, the memory of the host");
  EXPECT_EQ(s.field("t", s.array()), GXY_TAKEN);
  EXPECT_NE(gxy_publish(s.sim, 5, 0), GXY_WRONG);
  s.expectWrong(gxy_publish(s.sim, 5, 0), "expected steps that ascend");
  s.expectWrong(s.field("u", s.array()), "after the first step");
  const int64_t half[3] = {4, 4, 2};
  const auto grid = [&](const char* mesh, int of, const int64_t* count) {
    return gxy_grid(s.sim, mesh, 0, of, kSize, kFirst, count, kOrigin, kSpacing);
  };
  s.expectWrong(grid("other", GXY_OF_POINTS, kSize), "a new mesh \"other\" after the first step");
  s.expectWrong(grid("grid", GXY_OF_CELLS, kSize), "cells beside points");
  EXPECT_EQ(s.grid(), GXY_TAKEN);
  EXPECT_NE(gxy_publish(s.sim, 6, 0), GXY_WRONG) << "the block and its fields are those of before";
  EXPECT_EQ(gxy_wanted(s.sim, 7, 0), 0);
  s.expectWrong(grid("grid", GXY_OF_POINTS, half), "another grid or block after gxy_wanted");
  EXPECT_EQ(s.grid(), GXY_TAKEN);
  EXPECT_NE(gxy_publish(s.sim, 7, 0), GXY_WRONG);
  EXPECT_EQ(grid("grid", GXY_OF_POINTS, half), GXY_TAKEN);
  s.expectWrong(gxy_publish(s.sim, 8, 0), "block 0 of mesh \"grid\" has no field \"t\" since it has changed");
  EXPECT_EQ(s.field("t", s.array()), GXY_TAKEN);
  EXPECT_NE(gxy_publish(s.sim, 8, 0), GXY_WRONG);
  EXPECT_NE(gxy_publish_last(s.sim, 9, 0), GXY_WRONG);
  s.expectWrong(s.grid(), "gxy_grid after gxy_publish_last");
  s.expectWrong(s.field("t", s.array()), "gxy_field after gxy_publish_last");
}

TEST(Interface, WrongParticlesAreToldAndChangeNothing) {
  Sim s(kNowhere);
  double positions[6] = {}, box[6] = {0, 0, 0, 1, 1, 1}, wrongBox[6] = {0, 0, 2, 1, 1, 1};
  int64_t numbers[2] = {0, 1};
  const gxy_array at = {positions, GXY_FLOAT64, 3, {24, 0, 0}, 0, 0},
                  ids = {numbers, GXY_INT64, 1, {8, 0, 0}, 0, 0}, none = {};
  const auto points = [&](const gxy_array& where, const gxy_array& which, int64_t count = 2,
                          const double* in = nullptr) {
    return gxy_points(s.sim, "atoms", count, where, which, in);
  };
  s.expectWrong(points(at, ids, -1), "count -1, expected 0 or more");
  s.expectWrong(points(at, ids, int64_t(1) << 40), "expected at most 2^32 - 2");
  s.expectWrong(points(at, ids, 2, wrongBox), "the box is empty");
  gxy_array a = at;
  a.components = 2;
  s.expectWrong(points(a, ids), "positions: 2 components, expected 3");
  a = at;
  a.type = GXY_INT32;
  s.expectWrong(points(a, ids), "expected float32 or float64");
  a = at;
  a.data = nullptr;
  s.expectWrong(points(a, ids), "positions: there are no data");
  a = at;
  a.stride[0] = 0;
  s.expectWrong(points(a, ids), "positions: stride[0] is 0");
  a = ids;
  a.type = GXY_FLOAT64;
  s.expectWrong(points(at, a), "expected one integer of 32 or 64 bits");
  s.expectWrong(gxy_field(s.sim, "atoms", 0, "mass", GXY_OF_POINTS, at), "there is no mesh \"atoms\"");
  EXPECT_EQ(points(at, ids, 2, box), GXY_TAKEN);
  s.expectWrong(gxy_grid(s.sim, "atoms", 0, GXY_OF_POINTS, kSize, kFirst, kSize, kOrigin, kSpacing),
                "has particles");
  s.expectWrong(gxy_field(s.sim, "atoms", 0, "mass", GXY_OF_CELLS, at),
                "values of cells on a mesh that counts points");
  s.expectWrong(gxy_field(s.sim, "atoms", 1, "mass", GXY_OF_POINTS, at), "there is no block 1");
  EXPECT_EQ(
      points({nullptr, GXY_FLOAT64, 3, {0, 0, 0}, 0, 0}, {nullptr, GXY_INT64, 1, {0, 0, 0}, 0, 0}, 0, box),
      GXY_TAKEN);
  EXPECT_EQ(gxy_field(s.sim, "atoms", 0, "mass", GXY_OF_POINTS, {nullptr, GXY_FLOAT64, 1, {0, 0, 0}, 0, 0}),
            GXY_TAKEN);
  EXPECT_NE(gxy_publish(s.sim, 1, 0), GXY_WRONG) << "a rank without particles";
  EXPECT_EQ(points(at, ids, 2, box), GXY_TAKEN);
  s.expectWrong(gxy_publish(s.sim, 2, 0), "gxy_publish, field \"mass\": there are no data");
  s.expectWrong(points(at, none, 2, box), "other ids or another box after the first step");
  s.expectWrong(points(at, ids), "other ids or another box after the first step");
  s.expectWrong(gxy_points(s.sim, "stars", 2, at, ids, box), "a new mesh after the first step");
}

TEST(Interface, WrongCellsAreToldAndChangeNothing) {
  Sim s(kNowhere);
  const double positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  int64_t ends[3] = {0, 3, 6}, points[6] = {0, 1, 2, 2, 1, 0};
  int triangle = GXY_TRIANGLE;
  uint8_t types[2] = {GXY_TRIANGLE, GXY_TRIANGLE};
  const gxy_array at = {positions, GXY_FLOAT64, 3, {24, 0, 0}, 0, 0},
                  all = {&triangle, GXY_INT32, 1, {0, 0, 0}, 0, 0},
                  each = {types, GXY_UINT8, 1, {1, 0, 0}, 0, 0},
                  offsets = {ends, GXY_INT64, 1, {8, 0, 0}, 0, 0},
                  corners = {points, GXY_INT64, 1, {8, 0, 0}, 0, 0}, none = {};
  const auto cells = [&](const gxy_array& where, const gxy_array& kinds, const gxy_array& from,
                         const gxy_array& of, int64_t count = 2, int64_t pointCount = 3) {
    return gxy_cells(s.sim, "surface", pointCount, where, count, kinds, from, of);
  };
  s.expectWrong(cells(at, each, offsets, corners, -1), "-1 cells, expected 0 or more");
  s.expectWrong(cells(at, each, offsets, corners, 2, -1), "gxy_cells: -1 points");
  s.expectWrong(cells(at, each, offsets, corners, int64_t(1) << 40), "cells, expected at most 2^32 - 2");
  s.expectWrong(cells(at, each, offsets, corners, 2, int64_t(1) << 40), "points, expected at most 2^32 - 2");
  gxy_array a = at;
  a.components = 2;
  s.expectWrong(cells(a, each, offsets, corners),
                "gxy_cells, \"surface\", positions: 2 components, expected 3");
  a = at;
  a.type = GXY_INT32;
  s.expectWrong(cells(a, each, offsets, corners), "positions of type 4, expected float32 or float64");
  a = each;
  a.type = GXY_FLOAT32;
  s.expectWrong(cells(at, a, offsets, corners),
                "types: type 8 and 1 components, expected one integer for each cell");
  a = each;
  a.data = nullptr;
  s.expectWrong(cells(at, a, offsets, corners), "types: there are no data");
  a = offsets;
  a.type = GXY_INT16;
  s.expectWrong(cells(at, each, a, corners),
                "offsets: type 2 and 1 components, expected one integer of 32 or 64 bits");
  a = offsets;
  a.stride[0] = 0;
  s.expectWrong(cells(at, each, a, corners), "offsets: stride[0] is 0");
  s.expectWrong(cells(at, each, none, corners), "offsets: there are none, expected cells + 1");
  a = corners;
  a.components = 3;
  s.expectWrong(cells(at, each, offsets, a), "connectivity: type 6 and 3 components, expected one integer");
  a = corners;
  a.data = nullptr;
  s.expectWrong(cells(at, each, offsets, a), "connectivity: there are no data");
  a = corners;
  a.memory = 1;
  s.expectWrong(cells(at, each, offsets, a), "connectivity: memory 1, expected 0");
  triangle = 25;
  s.expectWrong(
      cells(at, all, none, corners),
      "gxy_cells, \"surface\": cells of type 25 (quadratic hexahedra) are not supported, expected lines");
  triangle = GXY_POLYGON;
  s.expectWrong(cells(at, all, none, corners), "offsets: there are none");
  triangle = GXY_TRIANGLE;
  s.expectWrong(gxy_field(s.sim, "surface", 0, "height", GXY_OF_POINTS, at), "there is no mesh \"surface\"");
  s.expectWrong(cells(at, all, none, corners, int64_t(1) << 31), "more than 2^32 - 2 points together");

  EXPECT_EQ(cells(at, all, none, corners), GXY_TAKEN) << s.message();
  s.expectWrong(gxy_grid(s.sim, "surface", 0, GXY_OF_POINTS, kSize, kFirst, kSize, kOrigin, kSpacing),
                "has cells");
  s.expectWrong(gxy_points(s.sim, "surface", 3, at, none, nullptr),
                "this mesh has cells, expected another name");
  s.expectWrong(gxy_field(s.sim, "surface", 1, "height", GXY_OF_POINTS, at), "there is no block 1");
  EXPECT_EQ(gxy_field(s.sim, "surface", 0, "height", GXY_OF_POINTS, at), GXY_TAKEN);
  EXPECT_EQ(gxy_field(s.sim, "surface", 0, "region", GXY_OF_CELLS, corners), GXY_TAKEN);
  EXPECT_EQ(gxy_field(s.sim, "surface", 0, "height", GXY_OF_CELLS, corners), GXY_TAKEN);
  s.expectWrong(gxy_publish(s.sim, 1, 0), "field \"height\" is there twice");
}

TEST(Interface, WrongCellsOfTheFirstStepAreToldAtOnce) {
  Sim s(kNowhere);
  double positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  int32_t ends[3] = {0, 3, 6}, points[6] = {0, 1, 2, 2, 1, 0};
  int types[2] = {GXY_TRIANGLE, GXY_TRIANGLE};
  const gxy_array at = {positions, GXY_FLOAT64, 3, {24, 0, 0}, 0, 0};
  const auto tell = [&](int64_t count = 2) {
    EXPECT_EQ(gxy_cells(s.sim, "surface", 3, at, count, {types, GXY_INT32, 1, {4, 0, 0}, 0, 0},
                        {ends, GXY_INT32, 1, {4, 0, 0}, 0, 0}, {points, GXY_INT32, 1, {4, 0, 0}, 0, 0}),
              GXY_TAKEN)
        << s.message();
  };
  const auto expect = [&](auto& value, auto wrong, const char* why) {
    const auto before = value;
    value = wrong;
    tell();
    s.expectWrong(gxy_publish(s.sim, 1, 0), std::string("gxy_publish, cells \"surface\", cell ") + why);
    value = before;
  };
  expect(types[1], 12, "1: type 12, of cells with a volume, in a mesh of triangles");
  expect(types[1], 24, "1: cells of type 24 (quadratic tetrahedra) are not supported, expected lines");
  expect(types[1], 261, "1: cells of type 255 are not supported");
  expect(types[1], GXY_LINE, "1: type 3, of lines, in a mesh of triangles");
  expect(types[1], GXY_QUAD, "1: 3 points, expected 4 for type 9");
  expect(ends[2], 2, "1: its offsets do not ascend");
  expect(ends[0], -1, "0: its offsets do not ascend");
  expect(ends[1], 4, "0: 4 points, expected 3");
  expect(points[4], -1, "1: its point 1 is negative");
  expect(points[4], 3, "1: its point 1 is 3 in connectivity, expected one of the 3 points");
  expect(positions[8], double(INFINITY), "0: the coordinates of point 2 are not finite");
  tell();
  EXPECT_EQ(gxy_field(s.sim, "surface", 0, "height", GXY_OF_POINTS, at), GXY_TAKEN);
  EXPECT_NE(gxy_publish(s.sim, 1, 0), GXY_WRONG) << s.message();
  tell();
  s.expectWrong(gxy_publish(s.sim, 2, 0), "gxy_publish, field \"height\": there are no data");
  const int line = GXY_LINE;
  s.expectWrong(gxy_cells(s.sim, "surface", 3, at, 2, {&line, GXY_INT32, 1, {0, 0, 0}, 0, 0}, {},
                          {points, GXY_INT32, 1, {4, 0, 0}, 0, 0}),
                "or cells of another kind (lines, triangles or cells with a volume), after the first step");
  tell(0);
  EXPECT_EQ(gxy_field(s.sim, "surface", 0, "height", GXY_OF_POINTS, at), GXY_TAKEN);
  EXPECT_NE(gxy_publish(s.sim, 2, 0), GXY_WRONG) << s.message();
  Sim off;
  types[0] = 12;
  EXPECT_EQ(gxy_cells(off.sim, "surface", 3, at, 2, {types, GXY_INT32, 1, {4, 0, 0}, 0, 0},
                      {ends, GXY_INT32, 1, {4, 0, 0}, 0, 0}, {points, GXY_INT32, 1, {4, 0, 0}, 0, 0}),
            GXY_TAKEN);
  EXPECT_EQ(gxy_publish(off.sim, 1, 0), GXY_OFF) << "nothing is read";
}

TEST(Interface, CellsWithAVolumeHaveFieldsOfPointsOrCells) {
  Sim s(kNowhere);
  const double positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const int32_t points[4] = {0, 1, 2, 3};
  const int type = GXY_TETRAHEDRON;
  const gxy_array at = {positions, GXY_FLOAT64, 3, {24, 0, 0}, 0, 0},
                  heat = {positions, GXY_FLOAT64, 1, {24, 0, 0}, 0, 0};
  const auto tell = [&](int64_t count) {
    EXPECT_EQ(gxy_cells(s.sim, "block", 4, at, count, {&type, GXY_INT32, 1, {0, 0, 0}, 0, 0}, {},
                        {points, GXY_INT32, 1, {4, 0, 0}, 0, 0}),
              GXY_TAKEN)
        << s.message();
  };
  tell(1);
  s.expectWrong(
      gxy_publish(s.sim, 1, 0),
      "cells \"block\": cells with a volume without a field, expected one or more fields of points");
  EXPECT_EQ(gxy_field(s.sim, "block", 0, "region", GXY_OF_CELLS, heat), GXY_TAKEN);
  EXPECT_NE(gxy_publish(s.sim, 1, 0), GXY_WRONG) << s.message();
  s.expectWrong(gxy_field(s.sim, "block", 0, "other", GXY_OF_POINTS, heat), "a new field");
  Sim other(kNowhere);
  std::swap(s.sim, other.sim);
  tell(0);
  EXPECT_EQ(gxy_field(s.sim, "block", 0, "heat", GXY_OF_POINTS, heat), GXY_TAKEN);
  EXPECT_NE(gxy_publish(s.sim, 1, 0), GXY_WRONG) << s.message();
  tell(1);
  s.expectWrong(gxy_field(s.sim, "block", 0, "region", GXY_OF_CELLS, heat), "a new field");
}

TEST(Interface, ASimulationWithoutAServerRunsOn) {
  Sim s(kNowhere);
  s.grid();
  s.field("t", s.array());
  for (int step = 1; step <= 1000; step++) EXPECT_EQ(gxy_publish(s.sim, step, 0), GXY_LOST);
  for (int i = 0; i < 1000 && s.message().empty(); i++) {
    const timespec moment{0, 10000000};
    nanosleep(&moment, nullptr);
  }
  EXPECT_NE(s.message().find("is a server running there?"), std::string::npos) << s.message();
  gxy_stat statistics;
  EXPECT_EQ(gxy_statistics(s.sim, &statistics), GXY_TAKEN);
  EXPECT_EQ(statistics.offered, 1000);
  EXPECT_EQ(statistics.taken, 0);
}

TEST(Interface, NothingIsWaitedForWithoutAServer) {
  Sim s(R"({"to": "127.0.0.1:1", "token-file": "-", "policy": "wait", "time-out": null})");
  s.grid();
  s.field("t", s.array());
  EXPECT_EQ(gxy_publish(s.sim, 1, 0), GXY_LOST);
  EXPECT_EQ(gxy_publish(s.sim, 2, 0), GXY_LOST);
  EXPECT_EQ(gxy_publish_last(s.sim, 3, 0), GXY_LOST) << "it is kept nevertheless";
}

TEST(Interface, WhatIsWantedIsAskedOnceAndOfTheNextPublish) {
  Sim s(kNowhere);
  s.grid();
  s.field("t", s.array());
  s.expectWrong(gxy_wanted_settle(s.sim, 1, 1), "expected that of gxy_wanted just before");
  EXPECT_EQ(gxy_wanted(s.sim, 1, 0.5), 0);
  s.expectWrong(gxy_wanted(s.sim, 1, 0.5), "expected gxy_publish next");
  s.expectWrong(gxy_wanted_settle(s.sim, 2, 1), "step 2, expected that of gxy_wanted");
  EXPECT_EQ(gxy_wanted_settle(s.sim, 1, 1), GXY_TAKEN);
  s.expectWrong(gxy_publish(s.sim, 2, 0.5), "expected the same step and time");
  s.expectWrong(gxy_publish(s.sim, 1, 0.25), "expected the same step and time");
  EXPECT_EQ(gxy_publish(s.sim, 1, 0.5), GXY_LOST);
  EXPECT_EQ(gxy_publish(s.sim, 2, 1), GXY_LOST) << "without asking";
  Sim off;
  EXPECT_EQ(gxy_wanted(off.sim, 1, 0), 0);
  EXPECT_EQ(gxy_wanted_settle(off.sim, 1, 1), GXY_TAKEN);
}

TEST(Interface, AStepIsSkippedAlsoBeforeThereIsAMesh) {
  Sim s(kNowhere);
  EXPECT_NE(gxy_skip(s.sim, 1, 0), GXY_WRONG);
  s.expectWrong(gxy_skip(s.sim, 1, 0), "gxy_skip: step 1 after step 1, expected steps that ascend");
  s.grid();
  s.field("t", s.array());
  EXPECT_NE(gxy_publish(s.sim, 2, 0), GXY_WRONG);
  EXPECT_NE(gxy_skip(s.sim, 3, 0), GXY_WRONG);
  s.expectWrong(gxy_publish(s.sim, 3, 0), "step 3 after step 3");
  Sim off;
  EXPECT_EQ(gxy_skip(off.sim, 1, 0), GXY_OFF);
}

TEST(Interface, NothingFollowsTheLastStep) {
  Sim s(kNowhere);
  s.grid();
  s.field("t", s.array());
  EXPECT_NE(gxy_publish_last(s.sim, 1, 0), GXY_WRONG);
  s.expectWrong(gxy_publish(s.sim, 2, 0), "gxy_publish after gxy_publish_last");
  s.expectWrong(gxy_publish_last(s.sim, 2, 0), "gxy_publish_last after gxy_publish_last");
  s.expectWrong(gxy_skip(s.sim, 2, 0), "gxy_skip after gxy_publish_last");
}

}  // namespace
