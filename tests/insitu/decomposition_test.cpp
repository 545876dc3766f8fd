// SPDX-License-Identifier: Apache-2.0
// Simulations whose ranks have other blocks, or another grid, after some steps.
#include "tests/insitu/published.h"
#include "tests/insitu/random_blocks.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

using nlohmann::json;

const std::vector<MiniField> kFields{{"a", ScalarType::Float32, 1}, {"b", ScalarType::Float64, 1}};

Grid randomGrid(Random& random) {
  Grid grid =
      gridOf({5 + int64_t(random.below(16)), 5 + int64_t(random.below(16)), 5 + int64_t(random.below(16))});
  grid.spacing = {0.125, 0.25, 0.5};  // and half of it is no less exact, for cells
  grid.origin.x = double(random.below(8));
  return grid;
}

/// A server and a client that looks at all datasets.
struct Observed {
  explicit Observed(int ranks) {
    ServerSetup setup;
    setup.ranks = ranks;
    setup.modules = GALAXY_MODULES;
    server = std::make_unique<TestServer>(std::move(setup));
    client = server->client();
    client->expect("load data");
    client->expect("load insitu");
    client->expect("observe");
  }
  json stream() const { return client->expect("insitu.streams").at("streams").at(0); }
  void awaitEnd() const {
    until([&] { return client->expect("insitu.streams").at("streams").empty(); }, "the end of the stream");
  }
  std::unique_ptr<TestServer> server;
  std::unique_ptr<Client> client;
};

/// Publishes until a step after `before` is there on all ranks.
void runBeyond(MiniSimulation& simulation, Observed& observed, int64_t before) {
  run(simulation, [&] {
    const json found = observed.client->expect("info heat.a").at("datasets").at(0);
    return found.at("origins").at(0).at("step").get<int64_t>() > before;
  });
}

TEST(Decompositions, ChangeWhileStepsAreSkipped) {
  for (uint64_t seed = 1; seed <= uint64_t(sweep(12)); seed++) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    Observed observed(1 + int(random.below(3)));
    Grid grid = randomGrid(random);
    const int ranks = 1 + int(random.below(6));
    const int of = random.oneIn(2) ? GXY_OF_CELLS : GXY_OF_POINTS;
    const auto blocks = [&] { return insitu::randomBlocks(random, grid.points, ranks); };
    json options = json::parse(to(*observed.server));
    if (random.oneIn(2)) options["partition"] = "simulation";
    {
      MiniSimulation simulation("heat", grid, blocks(), ranks, kFields, kLayouts[random.below(5)],
                                options.dump(), of);
      run(simulation, [&] { return simulation.published() >= 1; });
      for (uint64_t changes = 1 + random.below(3); changes > 0; changes--) {
        if (random.oneIn(2)) grid = randomGrid(random);
        simulation.decompose(grid, blocks());
        ASSERT_EQ(simulation.results(), 0);
        runBeyond(simulation, observed, simulation.step());
      }
    }
    observed.awaitEnd();
    expectEqualsImport(*observed.server, *observed.client, grid, of, kFields);
  }
}

TEST(Decompositions, ChangeOnSomeRanksOnly) {
  Observed observed(2);
  const Grid grid = gridOf({8, 9, 12});
  const auto slab = [](int64_t first, int64_t end) { return Extent{{0, 0, first}, {8, 9, end - first}}; };
  std::vector<insitu::Block> blocks{{0, 0, slab(0, 3)}, {1, 0, slab(3, 6)}, {2, 0, slab(6, 12)}};
  {
    MiniSimulation simulation("heat", grid, blocks, 3, kFields, Layout::Together, to(*observed.server));
    run(simulation, [&] { return simulation.published() >= 1; });
    blocks[0].extent = slab(0, 4);  // and rank 1 gives what rank 0 gets
    blocks[1].extent = slab(4, 6);
    simulation.decompose(grid, blocks, {0, 1});
    runBeyond(simulation, observed, simulation.step());
    blocks[1].extent = slab(4, 5);
    blocks[2].extent = slab(5, 12);
    simulation.decompose(grid, blocks, {1, 2});
    runBeyond(simulation, observed, simulation.step());
  }
  observed.awaitEnd();
  expectEqualsImport(*observed.server, *observed.client, grid, GXY_OF_POINTS, kFields);
}

TEST(Decompositions, ChangeWithoutAStepThatIsLeftOutWhereRanksWait) {
  for (uint64_t seed = 1; seed <= 4; seed++) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    Observed observed(1 + int(random.below(3)));
    Grid grid = randomGrid(random);
    const int ranks = 1 + int(random.below(4));
    const auto blocks = [&] { return insitu::randomBlocks(random, grid.points, ranks); };
    std::vector<insitu::Block> now = blocks();
    MiniSimulation simulation("heat", grid, now, ranks, kFields, Layout::Together,
                              waiting(*observed.server, nullptr));
    for (int step = 1; step <= 20; step++) {
      ASSERT_EQ(simulation.results(), 0);
      ASSERT_EQ(simulation.publishTogether(), ranks) << step << ": " << gxy_message(simulation.rank(0));
      until([&] { return simulation.published() == step; }, "each step");
      if (random.oneIn(2)) continue;
      expectEqualsImport(*observed.server, *observed.client, grid, GXY_OF_POINTS, kFields);
      if (random.oneIn(2)) grid = randomGrid(random), now = blocks();
      if (random.oneIn(2)) now = blocks();
      simulation.decompose(grid, now);  // perhaps the same as before
    }
    EXPECT_EQ(observed.stream().at("abandoned"), 0);
  }
}

TEST(Decompositions, OfPublishesThatAreNotOfferedAreNotMixed) {
  for (const bool all : {true, false}) {
    Observed observed(2);
    Grid grid = gridOf({9, 8, 7});
    Random random(3);
    const auto blocks = [&] { return insitu::randomBlocks(random, grid.points, 3); };
    json options = json::parse(waiting(*observed.server, nullptr));
    options["every"] = 3;
    MiniSimulation simulation("heat", grid, blocks(), 3, kFields, Layout::Together, options.dump());
    for (int step = 1; step <= 10; step++) {
      const bool isOffered = step % 3 == 1;
      ASSERT_EQ(simulation.publishTogether(), isOffered ? 3 : 0) << step;
      if (isOffered) {
        until([&] { return simulation.published() == 1 + step / 3; }, "each step");
        expectEqualsImport(*observed.server, *observed.client, grid, GXY_OF_POINTS, kFields);
      }
      if (all) grid.points[1] = 5 + step;
      simulation.decompose(grid, blocks());
      ASSERT_EQ(simulation.results(), 0);
    }
  }
}

TEST(Decompositions, ChangeInAStepThatOneRankSkips) {
  Observed observed(2);
  Grid grid = gridOf({9, 8, 7});
  Random random(5);
  const auto blocks = [&] { return insitu::randomBlocks(random, grid.points, 2); };
  {
    MiniSimulation simulation("heat", grid, blocks(), 2, kFields, Layout::Together, to(*observed.server));
    run(simulation, [&] { return simulation.published() >= 1; });
    const json stream = observed.stream().at("stream");
    for (int change = 0; change < 10; change++) {
      grid.points[0] = 5 + change;
      simulation.decompose(grid, blocks());
      const int64_t step = simulation.next();
      gxy_publish(simulation.rank(0), step, 0.5 * double(step));
      gxy_skip(simulation.rank(1), step, 0.5 * double(step));
      runBeyond(simulation, observed, step);
      EXPECT_EQ(observed.stream().at("stream"), stream) << "it has not ended meanwhile";
    }
  }
  observed.awaitEnd();
  expectEqualsImport(*observed.server, *observed.client, grid, GXY_OF_POINTS, kFields);
}

TEST(Decompositions, WhereOnlyTheRanksWithOtherBlocksTellThemNobodyHangs) {
  Observed observed(2);
  const Grid grid = gridOf({8, 9, 12});
  const auto slab = [](int64_t first, int64_t end) { return Extent{{0, 0, first}, {8, 9, end - first}}; };
  MiniSimulation simulation("heat", grid, {{0, 0, slab(0, 3)}, {1, 0, slab(3, 6)}, {2, 0, slab(6, 12)}}, 3,
                            kFields, Layout::Together, waiting(*observed.server, nullptr));
  for (int64_t i = 1; i <= 30; i++) {
    simulation.publishTogether();
    const int64_t cut = 1 + i % 5;
    if (i % 3 == 0)  // while rank 2 may be a step ahead
      simulation.decompose(grid, {{0, 0, slab(0, cut)}, {1, 0, slab(cut, 6)}}, {0, 1});
  }
  EXPECT_GT(simulation.published(), 1) << "steps with other blocks may be left out, but not all";
}

TEST(Decompositions, TheLastStepIsPublishedAlthoughOneRankChangesBeforeThereIsAPlan) {
  Observed observed(2);
  const Grid grid = gridOf({8, 9, 12});
  const auto slab = [](int64_t first, int64_t end) { return Extent{{0, 0, first}, {8, 9, end - first}}; };
  MiniSimulation simulation("heat", grid, {{0, 0, slab(0, 6)}, {1, 0, slab(6, 12)}}, 2, kFields,
                            Layout::Together, to(*observed.server));
  simulation.publish();
  simulation.decompose(grid, {{0, 0, slab(0, 6)}, {0, 1, slab(6, 7)}}, {0});
  simulation.decompose(grid, {{1, 0, slab(7, 12)}}, {1});
  simulation.publishLastAndClose(60);
  observed.awaitEnd();
  expectEqualsImport(*observed.server, *observed.client, grid, GXY_OF_POINTS, kFields);
}

TEST(Decompositions, ChangeUnderAWindowThatFollows) {
  const auto server = serve();
  Viewer viewer(*server);
  viewer.client->expect("load insitu");
  Grid grid = gridOf({16, 12, 8});
  const auto blocks = [&] {
    Random random(uint64_t(grid.points[0]));
    return insitu::randomBlocks(random, grid.points, 3);
  };
  {
    MiniSimulation simulation("heat", grid, blocks(), 3, kFields, Layout::Together, to(*server));
    run(simulation, [&] { return simulation.published() >= 1; });
    viewer.makeWindow("2", R"({"size": [48, 40], "follow": true})", "heat.a");
    viewer.client->expect("render 2");
    for (const int64_t points : {10, 20}) {
      grid.points[0] = points;
      grid.origin.y -= 2;
      simulation.decompose(grid, blocks());
      const int64_t published = simulation.published();
      run(simulation, [&] { return simulation.published() >= published + 3; });
    }
  }
  until([&] { return viewer.client->expect("insitu.streams").at("streams").empty(); },
        "the end of the stream");
  const json generation = viewer.client->expect("info heat.a").at("datasets").at(0).at("generation");
  until(
      [&] {
        const auto end = viewer.screen.waitFor(2, viewer.newestFrame(2));
        return end.status == "complete" && end.json.at("generations").at("heat.a") == generation;
      },
      "a picture of the last step");
}

TEST(Decompositions, WithAHoleEndTheStreamWithItsName) {
  Observed observed(2);
  const Grid grid = gridOf({8, 8, 8});
  std::vector<insitu::Block> blocks{{0, 0, {{0, 0, 0}, {8, 8, 4}}}, {1, 0, {{0, 0, 4}, {8, 8, 4}}}};
  MiniSimulation simulation("heat", grid, blocks, 2, kFields, Layout::Together, to(*observed.server, 0));
  run(simulation, [&] { return simulation.published() >= 1; });
  blocks[0].extent.points[2] = 3;
  simulation.decompose(grid, blocks);
  run(simulation, [&] {
    return std::string(gxy_message(simulation.rank(0))).find("leave a hole of 8 x 8 x 1 points") !=
           std::string::npos;
  });
  observed.awaitEnd();
}

TEST(Decompositions, WithAnotherGridOnOneRankEndTheStream) {
  Observed observed(1);
  Grid grid = gridOf({8, 8, 8});
  const std::vector<insitu::Block> blocks{{0, 0, {{0, 0, 0}, {8, 8, 4}}}, {1, 0, {{0, 0, 4}, {8, 8, 4}}}};
  MiniSimulation simulation("heat", grid, blocks, 2, kFields, Layout::Together, to(*observed.server, 0));
  run(simulation, [&] { return simulation.published() >= 1; });
  grid.origin.x = 3;
  simulation.decompose(grid, blocks, {1});
  run(simulation, [&] {
    return std::string(gxy_message(simulation.rank(0))).find("rank 1 has other meshes") != std::string::npos;
  });
}

}  // namespace
}  // namespace gxy::test
