// SPDX-License-Identifier: Apache-2.0
// libcatalyst-galaxy.so, opened by the stand-in for Catalyst as a simulation's Catalyst opens it. recorder.h stands before the
// library that publishes.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <random>
#include <set>

#include "tests/insitu/catalyst/simulated.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

TEST_F(Catalyst, TellsWhatItIs) {
  Tree about;
  ASSERT_EQ(initialize(), 0);
  EXPECT_EQ(catalyst_about(about.node()), 0);
  EXPECT_STREQ(stand_in_text(about.node(), "catalyst/implementation"), "galaxy");
  EXPECT_STREQ(stand_in_text(about.node(), "catalyst/version"), GALAXY_VERSION);
  EXPECT_STREQ(stand_in_text(about.node(), "catalyst/galaxy/message"), "");
  EXPECT_EQ(catalyst_results(about.node()), 0);
}

TEST_F(Catalyst, AGridOfOneRankIsPublished) {
  params_.set("catalyst/galaxy/name", "heat"), params_.set("catalyst/galaxy/seconds", 2.5);
  ASSERT_EQ(initialize(), 0);
  Simple tree;
  EXPECT_EQ(execute(tree), 0);
  expectGrid(0, {4, 3, 2}, {0, 0, 0}, {4, 3, 2});
  EXPECT_EQ(read(), std::vector<double>(tree.values.begin(), tree.values.end()));
  tree.step(7), tree.set("catalyst/galaxy/last", 1);
  EXPECT_EQ(execute(tree), 0);
  EXPECT_EQ(recorded().steps, (std::vector<std::pair<int64_t, double>>{{1, 0.5}, {7, 3.5}}));
  EXPECT_TRUE(recorded().last);
  EXPECT_EQ(catalyst_finalize(params_.node()), 0);
  EXPECT_EQ(recorded().closed, 2.5);
  EXPECT_EQ(recorded().name, "heat");
  EXPECT_EQ(said(), "");
}

TEST_F(Catalyst, AllTypesOfNumbersAreTaken) {
  const auto check = [this]<class T>(T) {
    const std::vector<T> values{T(-1), 2, 3, std::numeric_limits<T>::max(), 5, 6, 7, 8};
    Simple tree;
    tree.grid({2, 2, 2}), tree.external(kField + "/values", values);
    ASSERT_EQ(initialize(), 0);
    EXPECT_EQ(execute(tree), 0) << said();
    EXPECT_EQ(read(), std::vector<double>(values.begin(), values.end()));
  };
  check(int8_t()), check(uint8_t()), check(int16_t()), check(uint16_t()), check(int32_t()), check(uint32_t());
  check(int64_t()), check(uint64_t()), check(float()), check(double());
}

TEST_F(Catalyst, ComponentsTogetherApartAndAnywhereAreReadAlike) {
  std::vector<double> expected(72), memory(400);
  std::iota(expected.begin(), expected.end(), 0.);
  struct Layout {
    int64_t first[3], stride;  // in values
    bool copied;
  };
  for (const Layout& layout :
       {Layout{{0, 1, 2}, 3, false}, Layout{{1, 2, 3}, 4, false}, Layout{{0, 100, 200}, 1, false},
        Layout{{200, 100, 0}, 2, false}, Layout{{0, 200, 100}, 1, true}}) {
    Simple tree;
    tree.remove(kField + "/values");
    for (size_t c = 0; c < 3; c++) {
      for (size_t n = 0; n < 24; n++)
        memory[size_t(layout.first[c] + int64_t(n) * layout.stride)] = expected[3 * n + c];
      tree.external(kField + "/values/" + "uvw"[c], memory.data(), 24, 8 * layout.stride,
                    8 * layout.first[c]);
    }
    ASSERT_EQ(initialize(), 0);
    EXPECT_EQ(execute(tree), 0) << said();
    EXPECT_EQ(read(), expected) << layout.first[1];
    EXPECT_EQ(recorded().fields.begin()->second.data != &memory[size_t(layout.first[0])], layout.copied);
  }
}

TEST_F(Catalyst, ComponentsMayHaveStridesOfTheirOwn) {
  const auto one = numbered(24), other = numbered(48);
  std::vector<double> expected;
  for (int n = 0; n < 24; n++) expected.insert(expected.end(), {double(n), 2. * n});
  Simple tree;
  tree.remove(kField + "/values");
  tree.external(kField + "/values/u", one);
  tree.external(kField + "/values/v", other.data(), 24, 8);
  ASSERT_EQ(initialize(), 0);
  EXPECT_EQ(execute(tree), 0) << said();
  EXPECT_EQ(read(), expected);
}

TEST_F(Catalyst, NeighboursShareALayerOfPointsThatIsOwnedOnce) {
  ASSERT_EQ(initialize(), 0);
  Tree tree;
  tree.step();
  const auto low = numbered(24), high = numbered(48);
  const std::string a = kMesh + "/low", b = kMesh + "/high";
  tree.grid({4, 3, 2}, {0, 0, 0}, a), tree.grid({4, 3, 4}, {0, 0, 1}, b);
  tree.field("vertex", a + "/fields/t"), tree.field("vertex", b + "/fields/t");
  tree.external(a + "/fields/t/values", low), tree.external(b + "/fields/t/values", high);
  EXPECT_EQ(execute(tree), 0) << said();
  expectGrid(0, {4, 3, 5}, {0, 0, 0}, {4, 3, 1});
  expectGrid(1, {4, 3, 5}, {0, 0, 1}, {4, 3, 4});
  EXPECT_EQ(read(0), std::vector<double>(low.begin(), low.begin() + 12));
  EXPECT_EQ(read(1), std::vector<double>(high.begin(), high.end()));
}

TEST_F(Catalyst, AMeshMayHaveDomains) {
  ASSERT_EQ(initialize(), 0);
  Simple tree;
  tree.grid({4, 3, 2}, {}, kMesh + "/domain_000000"), tree.set("catalyst/channels/grid/type", "mesh");
  tree.remove(kMesh + "/topologies"), tree.remove(kMesh + "/coordsets"), tree.remove(kMesh + "/fields");
  const std::string field = kMesh + "/domain_000000/fields/t";
  tree.field("vertex", field), tree.external(field + "/values", tree.values);
  tree.set(kMesh + "/domain_000001/empty", 1), tree.remove(kMesh + "/domain_000001/empty");
  EXPECT_EQ(execute(tree), 0) << said();
  expectGrid(0, {4, 3, 2}, {0, 0, 0}, {4, 3, 2});
  EXPECT_EQ(said(), "");
}

TEST_F(Catalyst, PointsThatAreNotSharedAreAllOwned) {
  params_.set("catalyst/galaxy/shared", 0);
  ranks(0, 2), whole({4, 3, 4});
  ASSERT_EQ(initialize(), 0);
  Simple tree;
  EXPECT_EQ(execute(tree), 0) << said();
  expectGrid(0, {4, 3, 4}, {0, 0, 0}, {4, 3, 2});
}

TEST_F(Catalyst, GhostsAreNotOwned) {
  for (const char* association : {"vertex", "element"}) {
    const bool cells = association[0] == 'e';
    Tree tree;
    tree.step(), tree.grid({5, 5, 5}, {-1, -1, -1});  // one layer of ghost cells around 2 x 2 x 2
    tree.field(association), tree.field("element", kMesh + "/fields/vtkGhostType");
    std::vector<uint8_t> ghosts(64, 1);
    std::vector<double> expected;
    const auto values = numbered(cells ? 64 : 125);
    for (size_t k = 1; k < 3; k++)
      for (size_t j = 1; j < 3; j++) ghosts[1 + 4 * (j + 4 * k)] = ghosts[2 + 4 * (j + 4 * k)] = 0;
    const size_t n = cells ? 4 : 5, end = cells ? 3 : 4;
    for (size_t k = 1; k < end; k++)
      for (size_t j = 1; j < end; j++)
        for (size_t i = 1; i < end; i++) expected.push_back(double(i + n * (j + n * k)));
    tree.external(kField + "/values", values), tree.external(kMesh + "/fields/vtkGhostType/values", ghosts);
    ASSERT_EQ(initialize(), 0);
    EXPECT_EQ(execute(tree), 0) << said();
    const int64_t count = cells ? 2 : 3;
    expectGrid(0, {count, count, count}, {0, 0, 0}, {count, count, count});
    EXPECT_EQ(read(), expected);
    EXPECT_EQ(recorded().fields.size(), 1u);
    ASSERT_EQ(initialize(), 0);
    ghosts[1 + 4 * (1 + 4)] = 2;
    EXPECT_EQ(execute(tree), kWrong);
    expectSaid("vtkGhostType/values: the 7 values that are 0, for what is no ghost, are not a box");
  }
}

TEST_F(Catalyst, GhostsOfPointsSayWhichPointsAreOwned) {
  ranks(0, 2), whole({6, 6, 2});
  ASSERT_EQ(initialize(), 0);
  Simple tree;
  std::vector<int32_t> ghosts(24, 1);
  for (const size_t n : {5, 6, 9, 10, 17, 18, 21, 22}) ghosts[n] = 0;
  tree.grid({4, 3, 2}, {-1, -1, 0});
  tree.field("vertex", kMesh + "/fields/ascent_ghosts"),
      tree.external(kMesh + "/fields/ascent_ghosts/values", ghosts);
  EXPECT_EQ(execute(tree), 0) << said();
  expectGrid(0, {6, 6, 2}, {0, 0, 0}, {2, 2, 2});
  EXPECT_EQ(read(), (std::vector<double>{5, 6, 9, 10, 17, 18, 21, 22}));
  tree.field("element"), tree.external(kField + "/values", tree.values.data(), 6);
  ASSERT_EQ(initialize(), 0);
  EXPECT_EQ(execute(tree), kWrong);
  expectSaid("ghosts of points do not say which cells are ghosts");
}

TEST_F(Catalyst, AGridOfTwoDimensionsHasOneLayerOfCells) {
  ASSERT_EQ(initialize(), 0);
  Simple tree;
  tree.grid({4, 3, 1}), tree.remove(kMesh + "/coordsets/coords/dims/k");
  tree.field("element"), tree.external(kField + "/values", tree.values.data(), 6);
  EXPECT_EQ(execute(tree), 0) << said();
  expectGrid(0, {3, 2, 1}, {0, 0, 0}, {3, 2, 1});
  EXPECT_EQ(read(), (std::vector<double>{0, 1, 2, 3, 4, 5}));
  const std::vector<uint8_t> ghosts(6);
  tree.field("vertex"), tree.external(kField + "/values", tree.values.data(), 12);
  tree.field("element", kMesh + "/fields/vtkGhostType"),
      tree.external(kMesh + "/fields/vtkGhostType/values", ghosts);
  ASSERT_EQ(initialize(), 0);
  for (int step = 1; step < 3; step++) {
    tree.step(step);
    EXPECT_EQ(execute(tree), 0);
  }
  expectSaid("grid/data/topologies/mesh: fields of points in one layer, expected two layers");
  EXPECT_TRUE(recorded().grids.empty());
  EXPECT_EQ(recorded().skipped.size(), 2u);
}

TEST_F(Catalyst, ARankWithoutAPartHasABlockWithoutPoints) {
  for (const char* association : {"vertex", "element"}) {
    const int64_t size = association[0] == 'v' ? 4 : 3;
    ranks(2, 3), whole({4, 4, 4});
    Simple tree;
    for (size_t a = 0; a < 3; a++) params_.set(std::string("catalyst/galaxy/spacing/") + "xyz"[a], 0.25);
    ASSERT_EQ(initialize(), 0);
    tree.grid({0, 0, 0}), tree.field(association);
    for (const char* path : {"origin/x", "spacing/dx"}) tree.set(kMesh + "/coordsets/coords/" + path, 0.1);
    tree.external(kField + "/values", static_cast<float*>(nullptr), 0);
    EXPECT_EQ(execute(tree), 0) << said();
    expectGrid(0, {size, size, size}, {0, 0, 0}, {0, 0, 0});
    EXPECT_EQ(recorded().fields.begin()->second.type, GXY_FLOAT32);
  }
}

TEST_F(Catalyst, WithSeveralRanksTheWholeGridIsSaid) {
  ranks(1, 3);
  Simple tree;
  tree.grid({4, 3, 2}, {0, 0, 1});
  ASSERT_EQ(initialize(), 0);
  EXPECT_EQ(execute(tree), kWrong);
  expectSaid(
      "rank 1: catalyst/channels/grid/data/topologies/mesh: with several ranks, the size of the whole grid");
  whole({4, 3, 4}, false);
  ASSERT_EQ(initialize(), 0);
  EXPECT_EQ(execute(tree), kWrong);
  expectSaid("the origin of the whole grid is not known, expected catalyst/galaxy/origin");
  tree.set(kMesh + "/topologies/mesh/elements/origin/k0", 1);
  tree.step(2);
  EXPECT_EQ(execute(tree), 0) << said();
  expectGrid(0, {4, 3, 4}, {0, 0, 1}, {4, 3, 1});
  tree.remove(kMesh + "/topologies/mesh/elements");
  whole({4, 3, 4});
  ASSERT_EQ(initialize(), 0);
  EXPECT_EQ(execute(tree), 0) << said();
  expectGrid(0, {4, 3, 4}, {0, 0, 1}, {4, 3, 1});
  EXPECT_EQ(recorded().rank, 1);
  EXPECT_EQ(recorded().ranks, 3);
}

TEST_F(Catalyst, AFileSaysWhatTheSimulationDoesNot) {
  const std::string path = testing::TempDir() + "catalyst_test.json";
  std::ofstream(path) << R"({"size": [4, 3, 4], "origin": [-1, 2, 0], "ranks": 3, "name": "file"})";
  params_.set("catalyst/galaxy/name", "program"), params_.set("catalyst/galaxy/rank", 1);
  setenv("GALAXY_CATALYST", path.c_str(), 1);
  ASSERT_EQ(initialize(), 0) << said();
  std::remove(path.c_str());
  Simple tree;
  tree.grid({4, 3, 2}, {0, 0, 1});
  EXPECT_EQ(execute(tree), 0) << said();
  expectGrid(0, {4, 3, 4}, {0, 0, 1}, {4, 3, 1});
  EXPECT_EQ(recorded().name, "file");
  EXPECT_EQ(recorded().rank, 1);
  EXPECT_EQ(recorded().ranks, 3);
  EXPECT_EQ(initialize(), kWrong);
  expectSaid("GALAXY_CATALYST: " + path + ": expected a file with a JSON object");
  std::ofstream(path) << R"({"rang": 1})";
  EXPECT_EQ(initialize(), kWrong);
  expectSaid(path + ": \"rang\" is not known");
  std::remove(path.c_str());
  ranks(1, 3), setenv("GALAXY_CATALYST", "", 1);
  EXPECT_EQ(initialize(), 0) << said();
}

TEST_F(Catalyst, RanksAreThoseOfTheLauncher) {
  setenv("OMPI_COMM_WORLD_RANK", "2", 1), setenv("OMPI_COMM_WORLD_SIZE", "5", 1);
  ASSERT_EQ(initialize(), 0);
  unsetenv("OMPI_COMM_WORLD_RANK");
  EXPECT_EQ(recorded().rank, 2);
  EXPECT_EQ(recorded().ranks, 5);
}

TEST_F(Catalyst, BlocksThatDoNotFitTogetherAreNamed) {
  const auto values = numbered(24);
  const std::string a = kMesh + "/a", b = kMesh + "/b";
  for (const bool spacing : {false, true}) {
    Tree tree;
    tree.step(), tree.grid({4, 3, 2}, {}, a), tree.grid({4, 3, 2}, {0, 0, 1}, b);
    if (spacing)
      tree.set(b + "/coordsets/coords/spacing/dy", 0.3);
    else
      tree.set(b + "/coordsets/coords/origin/z", 0.3);
    tree.field("vertex", a + "/fields/t"), tree.field("vertex", b + "/fields/t");
    tree.external(a + "/fields/t/values", values), tree.external(b + "/fields/t/values", values);
    ASSERT_EQ(initialize(), 0);
    EXPECT_EQ(execute(tree), kWrong);
    expectSaid(spacing ? "b/topologies/mesh: spacing 0.3 beside 0.25, expected the same"
                       : "b/topologies/mesh: its origin 0.3 is 1.2 cells from 0 on axis 2");
  }
}

TEST_F(Catalyst, SpacingThatEachRankRoundsDifferentlyIsTheSameOnAll) {
  const std::string spacing = kMesh + "/coordsets/coords/spacing/dx";
  std::set<double> seen;
  for (const double ulps : {-4, 0, 4}) {
    ranks(0, 2), whole({4, 3, 4});
    ASSERT_EQ(initialize(), 0);
    Simple tree;
    tree.set(spacing, 0.1 * (1 + ulps * std::numeric_limits<double>::epsilon()));
    EXPECT_EQ(execute(tree), 0) << said();
    seen.insert(recorded().grids.at({"grid", 0}).spacing[0]);
  }
  EXPECT_EQ(seen.size(), 1u);
  EXPECT_NEAR(*seen.begin(), 0.1, 1e-10);
  for (size_t a = 0; a < 3; a++)
    params_.set(std::string("catalyst/galaxy/spacing/") + "xyz"[a], a == 0 ? 0.1 : 0.25);
  ASSERT_EQ(initialize(), 0);
  Simple tree;
  tree.set(spacing, double(0.1f)), tree.set(kMesh + "/coordsets/coords/origin/y", 2.0002);
  EXPECT_EQ(execute(tree), 0) << said();
  EXPECT_EQ(recorded().grids.at({"grid", 0}).spacing[0], 0.1);
}

TEST_F(Catalyst, WhatIsNotTakenIsSaidOnce) {
  params_.set("catalyst/scripts/a", "a.py");
  ASSERT_EQ(initialize(), 0);
  expectSaid("catalyst/scripts: what is to be done with the data is said to the server, left out");
  Simple tree;
  const auto expect = [&](const std::string& what) {
    EXPECT_EQ(execute(tree), 0);
    expectSaid(what);
    tree.step(int(recorded().steps.size()) + 1);
    EXPECT_EQ(execute(tree), 0);
    EXPECT_EQ(said(), "");
    tree.step(int(recorded().steps.size()) + 1);
  };
  EXPECT_EQ(execute(tree), 0);
  tree.step(2);
  tree.set("catalyst/channels/amr/type", "amrmesh");
  expect("channels/amr: type \"amrmesh\" is not taken");
  tree.set(kMesh + "/matsets/m/topology", "mesh");
  expect("grid/data/matsets: materials are not taken");
  tree.set(kMesh + "/fields/g/topology", "mesh"), tree.set(kMesh + "/fields/g/basis", "H1");
  expect("fields/g: a grid function of finite elements, left out");
  tree.set(kMesh + "/fields/m/topology", "mesh"), tree.set(kMesh + "/fields/m/matset", "m");
  expect("fields/m: a field of materials, left out");
  tree.set(kMesh + "/fields/n/matset", "m"), tree.external(kMesh + "/fields/n/values", tree.values);
  expect("fields/n: a field of materials, left out");
  tree.field("element", kMesh + "/fields/e"),
      tree.external(kMesh + "/fields/e/values", tree.values.data(), 6);
  expect("fields/e/values: a grid has fields of its points or of its cells so far, left out");
  tree.field("vertex", kMesh + "/fields/new"), tree.external(kMesh + "/fields/new/values", tree.values);
  expect("fields/new/values: gxy_field, \"new\": a new field");
  tree.grid({4, 3, 2}, {}, "catalyst/channels/other/data"), tree.grid({4, 3, 2});
  tree.set("catalyst/channels/other/type", "mesh");
  expect("other/data/topologies/mesh: a new grid after the first step, left out");
  for (const char* type : {"rectilinear", "structured", "unstructured"}) {
    tree.set("catalyst/channels/other/data/topologies/mesh/type", type);
    expect(std::string("type \"") + type +
           "\" on coordinates of type \"uniform\" is not taken so far, left out");
  }
  EXPECT_EQ(recorded().fields.size(), 1u);
}

TEST_F(Catalyst, WrongNodesAreToldAndTheNextStepGoesOn) {
  const auto expect = [this](const std::string& what, auto spoil) {
    ASSERT_EQ(initialize(), 0);
    Simple tree;
    spoil(tree);
    EXPECT_EQ(execute(tree), kWrong) << what;
    expectSaid(what, what);
    EXPECT_TRUE(recorded().steps.empty()) << what;
    ASSERT_EQ(recorded().skipped.size(), 1u) << what;
    tree.step(7), tree.remove("catalyst/channels");
    EXPECT_EQ(execute(tree), kWrong);
    EXPECT_EQ(recorded().skipped.back(), (std::pair<int64_t, double>{7, 3.5})) << what;
    Simple next;
    next.step(8);
    EXPECT_EQ(execute(next), 0) << what << said();
  };
  const std::string coords = kMesh + "/coordsets/coords";
  for (const std::string& path : std::initializer_list<std::string>{
           "catalyst/state", "catalyst/state/time", "catalyst/channels", "catalyst/channels/grid/type",
           kMesh + "/topologies", kMesh + "/topologies/mesh/type", kMesh + "/topologies/mesh/coordset",
           coords, coords + "/type", coords + "/dims", kField + "/association", kField + "/topology"})
    expect("there is no ", [&](Tree& t) { t.remove(path); });
  expect("there is no cycle", [](Tree& t) { t.remove("catalyst/state/timestep"); });
  expect("timestep: expected an integer", [](Tree& t) { t.set("catalyst/state/timestep", 1.5); });
  expect("timestep: expected a number", [](Tree& t) { t.set("catalyst/state/timestep", "1"); });
  expect("grid/type: expected a text", [](Tree& t) { t.set("catalyst/channels/grid/type", 1); });
  expect("there is no coordsets/other", [](Tree& t) { t.set(kMesh + "/topologies/mesh/coordset", "other"); });
  expect("dims/j: expected 0 to 2^31 points", [&](Tree& t) { t.set(coords + "/dims/j", -1); });
  expect("dims: too many points", [&](Tree& t) {
    for (const char* axis : {"i", "j", "k"}) t.set(coords + "/dims/" + axis, 2147483647);
  });
  expect("expected a finite origin and a positive spacing",
         [&](Tree& t) { t.set(coords + "/spacing/dx", 0.); });
  expect("expected a finite origin", [&](Tree& t) { t.set(coords + "/origin/x", std::nan("")); });
  expect("other coordinates are not taken", [&](Tree& t) { t.remove(coords + "/origin/x"); });
  expect("association: found \"face\", expected \"vertex\" or \"element\"",
         [](Tree& t) { t.set(kField + "/association", "face"); });
  expect("values: expected numbers", [](Tree& t) { t.set(kField + "/values", "none"); });
  expect("fields/t/values: found 23 values, expected 24, one for each of the points",
         [](Simple& t) { t.external(kField + "/values", t.values.data(), 23); });
  expect("values: expected numbers in memory",
         [](Tree& t) { t.external(kField + "/values", static_cast<float*>(nullptr), 24); });
  expect("values: expected components of one type and length", [](Simple& t) {
    t.external(kField + "/values/u", t.values.data(), 24),
        t.external(kField + "/values/v", t.values.data(), 23);
  });
  expect("expected numbers in the byte order of this machine", [](Simple& t) {
    stand_in_set_external(t.node(), (kField + "/values").c_str(), 11, t.values.data(), 24, 0, 4, 1);
  });
  EXPECT_EQ(catalyst_execute(nullptr), kWrong);
  expectSaid("the node is NULL");
}

TEST_F(Catalyst, AGridWithoutFieldsIsLeftOut) {
  ASSERT_EQ(initialize(), 0);
  Simple tree;
  tree.grid({7, 3, 2}, {}, "catalyst/channels/bare/data"), tree.grid({4, 3, 2});
  tree.set("catalyst/channels/bare/type", "mesh");
  EXPECT_EQ(execute(tree), 0);
  expectSaid("bare/data/topologies/mesh: a grid without fields, left out");
  EXPECT_EQ(recorded().grids.size(), 1u);
  tree.remove("catalyst/channels/grid");
  ASSERT_EQ(initialize(), 0);
  EXPECT_EQ(execute(tree), 0);
  expectSaid("catalyst/channels: there is nothing that Galaxy takes");
  EXPECT_TRUE(recorded().steps.empty());
  EXPECT_EQ(recorded().skipped.size(), 1u);
}

TEST_F(Catalyst, SeveralGridsAreMeshesOfOneStream) {
  ranks(1, 2), whole({4, 3, 2});
  params_.set("catalyst/galaxy/grids/fine/size/i", 7), params_.set("catalyst/galaxy/grids/fine/size/j", 3);
  params_.set("catalyst/galaxy/grids/fine/size/k", 2);
  for (const char* axis : {"x", "y", "z"})
    params_.set(std::string("catalyst/galaxy/grids/fine/origin/") + axis, 0.);
  ASSERT_EQ(initialize(), 0);
  Simple tree;
  const std::string fine = "catalyst/channels/fine/data";
  tree.grid({7, 3, 2}, {4, -8, 0}, fine), tree.grid({4, 3, 2});
  tree.set("catalyst/channels/fine/type", "mesh");
  for (const std::string& field : {fine + "/fields/e", fine + "/fields/t"})
    tree.field("element", field), tree.external(field + "/values", tree.values.data(), 12);
  EXPECT_EQ(execute(tree), 0) << said();
  EXPECT_EQ(recorded().grids.at({"grid", 0}).of, GXY_OF_POINTS);
  EXPECT_EQ(recorded().grids.at({"fine", 0}).of, GXY_OF_CELLS);
  EXPECT_EQ(recorded().grids.at({"fine", 0}).size, (std::array<int64_t, 3>{6, 2, 1}));
  EXPECT_EQ((recorded().read[{"fine", 0, "e"}]),
            std::vector<double>(tree.values.begin(), tree.values.begin() + 12));
  EXPECT_TRUE(recorded().read.count({"fine", 0, "t"})) << "the first mesh by name";
  EXPECT_TRUE(recorded().read.count({"grid", 0, "grid.t"}));
}

/// Particles beside a grid.
struct Particles : Simple {
  explicit Particles(size_t count) : x(count, 1), y(count, 2), z(count, 3), ids(count), speed(count) {
    const std::string mesh = "catalyst/channels/atoms/data";
    std::iota(ids.begin(), ids.end(), 10);
    std::iota(speed.begin(), speed.end(), 0.5f);
    set("catalyst/channels/atoms/type", "mesh"), set(mesh + "/coordsets/coords/type", "explicit");
    external(mesh + "/coordsets/coords/values/x", x), external(mesh + "/coordsets/coords/values/y", y);
    external(mesh + "/coordsets/coords/values/z", z);
    set(mesh + "/topologies/mesh/type", "points"), set(mesh + "/topologies/mesh/coordset", "coords");
    field("vertex", mesh + "/fields/id"), external(mesh + "/fields/id/values", ids);
    field("element", mesh + "/fields/speed"), external(mesh + "/fields/speed/values", speed);
  }
  std::vector<double> x, y, z;
  std::vector<int64_t> ids;
  std::vector<float> speed;
};

TEST_F(Catalyst, ParticlesMayBeOthersInEachStep) {
  params_.set("catalyst/galaxy/ids", "id");
  for (int n = 0; n < 6; n++) params_.set("catalyst/galaxy/box/" + std::to_string(n), n);
  ASSERT_EQ(initialize(), 0);
  for (const size_t count : {3, 5, 0}) {
    Particles tree(count);
    tree.step(int(recorded().steps.size()) + 1);
    EXPECT_EQ(execute(tree), 0) << said();
    const auto& points = recorded().points.at("atoms");
    std::vector<double> at;
    for (size_t n = 0; n < count; n++) at.insert(at.end(), {1, 2, 3});
    EXPECT_EQ(points.at, at);
    EXPECT_EQ(points.numbers, std::vector<double>(tree.ids.begin(), tree.ids.end()));
    EXPECT_EQ(points.box, (std::vector<double>{0, 1, 2, 3, 4, 5}));
    EXPECT_EQ((recorded().read[{"atoms", 0, "speed"}]),
              std::vector<double>(tree.speed.begin(), tree.speed.end()));
    EXPECT_EQ(recorded().fields.size(), 2u);  // that of the grid, too
  }
  Particles tree(4);
  tree.remove("catalyst/channels/atoms");
  EXPECT_EQ(execute(tree), kWrong);
  expectSaid("the points of mesh \"atoms\": missing, expected what the first step had");
  Particles flat(4);
  flat.remove("catalyst/channels/atoms/data/coordsets/coords/values/z");
  EXPECT_EQ(execute(flat), kWrong);
  expectSaid("atoms/data/coordsets/coords/values: expected x, y and z");
  EXPECT_EQ(recorded().steps.size(), 3u);
}

TEST_F(Catalyst, CoordinatesOfParticlesAreKnownByTheirNames) {
  const std::string values = "catalyst/channels/atoms/data/coordsets/coords/values";
  Particles tree(1);
  tree.remove(values + "/x"), tree.external(values + "/x", tree.x);  // now the last child
  ASSERT_EQ(initialize(), 0);
  EXPECT_EQ(execute(tree), 0) << said();
  EXPECT_EQ(recorded().points.at("atoms").at, (std::vector<double>{1, 2, 3}));
  tree.remove(values + "/x"), tree.external(values + "/r", tree.x), tree.step(2);
  EXPECT_EQ(execute(tree), kWrong);
  expectSaid("coords/values: expected x, y and z");
}

TEST_F(Catalyst, AFieldThatIsMissingLaterIsNotReadWhereItWas) {
  ASSERT_EQ(initialize(), 0);
  Simple tree;
  EXPECT_EQ(execute(tree), 0);
  tree.step(2), tree.remove(kField);
  EXPECT_EQ(execute(tree), kWrong);
  expectSaid("field \"t\" of block 0 of mesh \"grid\": missing, expected what the first step had");
  std::vector<double> other(24);
  tree.field("vertex"), tree.external(kField + "/values", other);
  EXPECT_EQ(execute(tree), kWrong);
  expectSaid("fields/t/values: gxy_field, \"t\": a new field, type or");
}

TEST_F(Catalyst, BlocksThatChangeArePlacedAgain) {
  ASSERT_EQ(initialize(), 0);
  Simple tree;
  EXPECT_EQ(execute(tree), 0);
  const auto grid = [&]() -> const gxy_sim::Grid& { return recorded().grids.at({"grid", 0}); };
  EXPECT_EQ(grid().size, (std::array<int64_t, 3>{4, 3, 2}));
  tree.step(2), tree.grid({4, 2, 3}, {1, 0, 0});
  EXPECT_EQ(execute(tree), 0) << said();
  EXPECT_EQ(grid().size, (std::array<int64_t, 3>{4, 2, 3}));
  EXPECT_EQ(grid().origin[0], -0.75);
  EXPECT_EQ((recorded().read[{"grid", 0, "t"}].size()), 24u);
  tree.step(3), tree.grid({4, 3, 3});
  EXPECT_EQ(execute(tree), kWrong);
  expectSaid("found 24 values, expected 36");
  tree.step(4), tree.grid({4, 3, 2}), tree.set(kMesh + "/coordsets/coords/spacing/dz", 0.5);
  EXPECT_EQ(execute(tree), 0) << said();
  EXPECT_EQ(grid().size, (std::array<int64_t, 3>{4, 3, 2}));
  EXPECT_EQ(grid().spacing[2], 0.5);
  EXPECT_EQ(recorded().steps.size(), 3u);
}

TEST_F(Catalyst, WrongParametersAreTold) {
  const auto expect = [this](const std::string& what, const std::string& path, auto value) {
    Tree params;
    params.set(path, value);
    EXPECT_EQ(catalyst_initialize(params.node()), kWrong) << path;
    expectSaid(what, path);
    EXPECT_EQ(execute(Simple()), 1);
    expectSaid("catalyst_execute before catalyst_initialize");
  };
  expect("expected a JSON object", "catalyst/galaxy/options", "[]");
  expect("catalyst/galaxy/name: expected a text", "catalyst/galaxy/name", 1);
  expect("catalyst/galaxy/size: expected 3 numbers", "catalyst/galaxy/size", 4);
  expect("catalyst/galaxy/size: expected 3 numbers", "catalyst/galaxy/size/i", 4);
  expect("catalyst/galaxy/association: expected \"vertex\"", "catalyst/galaxy/association", "face");
  expect("catalyst/galaxy/rank: expected a number", "catalyst/galaxy/rank", "1e");
  expect("catalyst/galaxy/shared: expected an integer from 0 up", "catalyst/galaxy/shared", -1);
  expect("catalyst/galaxy/box: expected 6 numbers", "catalyst/galaxy/box/x", 1);
  expect("catalyst/galaxy/grids: expected an object", "catalyst/galaxy/grids", 1);
  expect("catalyst/galaxy/grids/a/origin: expected 3 numbers", "catalyst/galaxy/grids/a/origin", "0");
  expect("catalyst/galaxy: expected an object", "catalyst/galaxy", 1);
  whole({0, 3, 2});
  EXPECT_EQ(initialize(), kWrong);
  expectSaid("catalyst/galaxy/size: expected 1 to 2^31 points by axis");
  whole({4, 3, 2}), params_.set("catalyst/galaxy/size/i", 4.5);
  EXPECT_EQ(initialize(), kWrong);
  expectSaid("catalyst/galaxy/size: expected 1 to 2^31 points by axis");
}

TEST_F(Catalyst, ALostConnectionIsSaidOnceAndIsNoError) {
  ASSERT_EQ(initialize(), 0);
  Simple tree;
  recorded().published = GXY_LOST;
  EXPECT_EQ(execute(tree), 0);
  expectSaid("there is no connection");
  tree.step(2);
  EXPECT_EQ(execute(tree), 0);
  EXPECT_EQ(said(), "");
}

TEST_F(Catalyst, WhereItIsOffNothingIsLookedAt) {
  params_.set("catalyst/galaxy/options", R"({"to": "off"})");
  ASSERT_EQ(initialize(), 0);
  EXPECT_EQ(execute(Tree()), 0);
  EXPECT_EQ(execute(Simple()), 0);
  EXPECT_EQ(execute(Tree()), 0);
  EXPECT_EQ(said(), "");
}

// Nodes are removed, get another type, or another text of the Blueprint's; sizes stay true, since nobody can see that a size is a lie.
TEST_F(Catalyst, NoTreeEndsTheSimulation) {
  std::mt19937 random(1);
  const auto below = [&](size_t n) { return size_t(random() % n); };
  std::vector<std::string> paths;
  for (const char* path : {"type", "coordset", "elements/origin/i0", "elements/origin"})
    paths.push_back(kMesh + "/topologies/mesh/" + path);
  for (const char* path : {"type", "dims", "dims/i", "dims/k", "origin", "origin/y", "spacing", "spacing/dz",
                           "values/x", "values"})
    paths.push_back(kMesh + "/coordsets/coords/" + path);
  const std::string atoms = "catalyst/channels/atoms/data";
  for (const char* path :
       {"topologies/mesh/type", "coordsets/coords/type", "coordsets/coords/values",
        "coordsets/coords/values/z", "fields/id/values", "fields/speed/association", "fields/speed/values"})
    paths.push_back(atoms + "/" + path);
  for (const char* field : {"t", "ascent_ghosts", "u"})
    for (const char* path : {"", "/association", "/topology", "/values", "/values/u", "/values/v", "/basis"})
      paths.push_back(kMesh + "/fields/" + field + path);
  for (const char* path : {"catalyst/channels/grid/type", "catalyst/channels/grid", "catalyst/state/time",
                           "catalyst/galaxy/last"})
    paths.push_back(path);
  const char* texts[] = {"mesh",    "multimesh", "uniform", "explicit", "points", "vertex",
                         "element", "coords",    "",        "..",       "a/b"};
  const auto values = numbered(1000);
  size_t published = 0;
  for (int round = 0; round < test::sweep(20000); round++) {
    if (round % 50 == 0) {
      published += recorded().steps.size();
      whole({4, 3, 2}), ranks(0, 1 + round / 50 % 2), params_.set("catalyst/galaxy/ids", "id");
      ASSERT_EQ(initialize(), 0);
    }
    Particles tree(5);
    if (below(2) != 0) tree.remove("catalyst/channels/atoms");
    tree.step(round + 1);
    for (size_t changes = below(4); changes > 0; changes--) {
      const std::string& path = paths[below(paths.size())];
      switch (below(6)) {
        case 0:
          tree.set(path, texts[below(std::size(texts))]);
          break;
        case 1:
          tree.set(path, int(below(6)) - 1);
          break;
        case 2:
          tree.set(path, below(2) ? 0.25 * double(below(9)) : std::numeric_limits<double>::infinity());
          break;
        case 3:
          tree.external(path, values.data(), int64_t(below(30)), int64_t(4 * below(20)),
                        int64_t(4 * below(20)));
          break;
        case 4:
          tree.external(path, reinterpret_cast<const uint8_t*>(values.data()), 24 >> below(3),
                        int64_t(below(3)));
          break;
        default:
          tree.set(path, 1), tree.remove(path);
      }
    }
    const int status = execute(tree);
    ASSERT_TRUE(status == 0 || status == kWrong) << status;
  }
  EXPECT_GT(published, size_t(test::sweep(1000)));
}

}  // namespace
}  // namespace gxy::test
