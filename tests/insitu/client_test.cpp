// SPDX-License-Identifier: Apache-2.0
// The C interface without a server.
#include <gtest/gtest.h>

#include <chrono>
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
  expect(R"({"two": 1})", "there is no option \"two\", expected one of between, every, here");
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
  s.expectWrong(gxy_publish(s.sim, 1, 0), "expected gxy_grid() and gxy_field(), or gxy_points(), first");
  s.expectWrong(s.field("t", s.array()),
                "there is no mesh \"grid\", expected gxy_grid() or gxy_points() first");
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
  s.expectWrong(s.grid(), "after the first step");
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
