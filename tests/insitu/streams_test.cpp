// SPDX-License-Identifier: Apache-2.0
// Simulations that publish to a server: what arrives is what an import of the same step would give.
#include <set>

#include "tests/insitu/pairwise.h"
#include "tests/insitu/published.h"
#include "tests/insitu/random_blocks.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

using nlohmann::json;

/// The blocks of `ranks` slabs along z.
std::vector<insitu::Block> slabs(const Grid& grid, int ranks) {
  std::vector<insitu::Block> blocks;
  for (int r = 0; r < ranks; r++) {
    const int64_t n = grid.points[2], first = n * r / ranks, last = n * (r + 1) / ranks;
    blocks.push_back({r, 0, {{0, 0, first}, {grid.points[0], grid.points[1], last - first}}});
  }
  return blocks;
}

TEST(Streams, RunsOfAMatrixHaveAllPairs) {
  const std::vector<int> values{5, 4, 2, 10, 3};
  const auto runs = pairwise(values, 7);
  EXPECT_LT(runs.size(), 80u) << "of 1200";
  EXPECT_GE(runs.size(), 50u);
  for (size_t a = 0; a < values.size(); a++)
    for (size_t b = a + 1; b < values.size(); b++) {
      std::set<std::pair<int, int>> pairs;
      for (const auto& run : runs) pairs.emplace(run.at(a), run.at(b));
      EXPECT_EQ(pairs.size(), size_t(values[a] * values[b]));
    }
}

TEST(Streams, WhatIsPublishedEqualsTheImportOfTheSameStep) {
  const std::vector<int> simulationRanks{1, 2, 3, 4, 8}, serverRanks{1, 2, 3, 4}, components{1, 2, 3};
  uint64_t seed = 0;
  auto runs = pairwise({5, 4, 10, 3, std::size(kLayouts), 2, 2, 2}, 35);
  runs.resize(size_t(sweep(int(runs.size()))));
  for (const auto& run : runs) {
    std::string name = "matrix";
    for (const int value : run) name += " " + std::to_string(value);
    SCOPED_TRACE(name);
    Random random(++seed);
    ServerSetup setup;
    setup.ranks = serverRanks.at(size_t(run[1]));
    setup.modules = GALAXY_MODULES;
    TestServer server(std::move(setup));
    const auto client = server.client();
    client->expect("load data");
    client->expect("load insitu");
    Grid grid =
        gridOf({5 + int64_t(random.below(20)), 5 + int64_t(random.below(20)), 5 + int64_t(random.below(20))});
    const int of = run[5] ? GXY_OF_CELLS : GXY_OF_POINTS;
    if (of == GXY_OF_CELLS) grid.spacing = {0.125, 0.25, 0.5};  // and half of it is no less exact
    const int ranks = simulationRanks.at(size_t(run[0]));
    std::vector<MiniField> fields{{"a", ScalarType(run[2]), components.at(size_t(run[3]))}};
    if (run[6]) fields.push_back({"b", ScalarType(random.below(10)), 1 + int(random.below(3))});
    {
      json options = json::parse(to(server));
      if (run[7]) options["partition"] = "simulation";
      MiniSimulation simulation("heat", grid, insitu::randomBlocks(random, grid.points, ranks), ranks, fields,
                                kLayouts[run[4]], options.dump(), of);
      ASSERT_EQ(simulation.results(), 0) << gxy_message(simulation.rank(0));
      client->expect("observe");
      test::run(simulation, [&] { return simulation.published() >= 2; });
    }
    until([&] { return client->expect("insitu.streams").at("streams").empty(); }, "the end of the stream");
    expectEqualsImport(server, *client, grid, of, fields);
  }
}

TEST(Streams, AWindowThatFollowsShowsStepAfterStep) {
  const auto server = serve();
  Viewer viewer(*server);
  viewer.client->expect("load insitu");
  const Grid grid = gridOf({16, 16, 16});
  {
    MiniSimulation simulation("heat", grid, slabs(grid, 3), 3, {{"t"}}, Layout::Ghosts, to(*server));
    run(simulation, [&] { return simulation.published() >= 1; });
    viewer.makeWindow("2", R"({"size": [48, 40], "follow": true})", "heat.t");
    viewer.client->expect("render 2");
    run(simulation, [&] { return viewer.newestFrame(2) >= 4; });
  }
  until([&] { return viewer.client->expect("insitu.streams").at("streams").empty(); },
        "the end of the stream");
  const json generation = viewer.client->expect("info heat.t").at("datasets").at(0).at("generation");
  until(
      [&] {
        const auto end = viewer.screen.waitFor(2, viewer.newestFrame(2));
        return end.status == "complete" && end.json.at("generations").at("heat.t") == generation;
      },
      "a picture of the last step");
}

TEST(Streams, NoStepIsTakenWhileNobodyLooks) {
  const auto server = serve();
  const auto client = server->client();
  client->expect("load data");
  client->expect("load insitu");
  const Grid grid = gridOf({8, 8, 8});
  MiniSimulation simulation("heat", grid, slabs(grid, 2), 2, {{"t"}}, Layout::Together, to(*server));
  run(simulation, [&] { return simulation.published() >= 1; });
  for (int i = 0; i < 1000; i++) EXPECT_EQ(simulation.publish(), 0);
  EXPECT_EQ(client->expect("insitu.streams").at("streams").at(0).at("published"), 1);
  client->expect("observe heat.t");
  run(simulation, [&] { return simulation.published() >= 3; });
}

TEST(Streams, OnlyStepsThatTheOptionsLetThroughAreOffered) {
  const auto server = serve();
  const auto client = server->client();
  client->expect("load data");
  client->expect("observe");
  const Grid grid = gridOf({8, 8, 8});
  json options = json::parse(to(*server));
  options.update({{"every", 5}, {"between", {50, 1e6}}});  // times are half the step
  MiniSimulation simulation("heat", grid, slabs(grid, 2), 2, {{"t"}}, Layout::Together, options.dump());
  for (int64_t n = 1; n <= 3; n++) {
    run(simulation, [&] { return simulation.published() >= n; });
    const int64_t step = client->expect("info heat.t").at("datasets").at(0).at("origins").at(0).at("step");
    EXPECT_EQ(step % 5, 1);
    EXPECT_GE(step, 100);
  }
}

TEST(Streams, EveryStepIsPublishedWhereTheSimulationWaitsAlthoughNobodyLooks) {
  for (const int ranks : {1, 3}) {
    const auto server = serve();
    const auto client = server->client();
    client->expect("load data");
    client->expect("load insitu");
    const Grid grid = gridOf({8, 8, 8});
    MiniSimulation simulation("heat", grid, slabs(grid, ranks), ranks, {{"t"}}, Layout::Together,
                              waiting(*server, nullptr));
    for (int step = 1; step <= 20; step++) EXPECT_EQ(simulation.publishTogether(), ranks) << step;
    until([&] { return simulation.published() == 20; }, "the last step");
    const json stream = client->expect("insitu.streams").at("streams").at(0);
    EXPECT_EQ(stream.at("published"), 20);
    EXPECT_EQ(stream.at("missed"), 0);
    EXPECT_EQ(client->expect("info heat.t").at("datasets").at(0).at("generation"), 20);
  }
}

TEST(Streams, SecondsOfTheStagesAddUpToNoMoreThanHasPassed) {
  const auto server = serve();
  const auto client = server->client();
  client->expect("load insitu");
  const Grid grid = gridOf({32, 24, 16});
  const auto begin = std::chrono::steady_clock::now();
  MiniSimulation simulation("heat", grid, slabs(grid, 2), 2, {{"t"}}, Layout::Together,
                            waiting(*server, nullptr));
  double before = 0;
  for (const int64_t steps : {3, 6}) {
    while (simulation.step() < steps) EXPECT_EQ(simulation.publishTogether(), 2);
    until([&] { return simulation.published() == steps; }, "the last step");
    const json stream = client->expect("insitu.streams").at("streams").at(0), &seconds = stream.at("seconds");
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
    double sum = 0;
    for (const char* stage : {"reserve", "collect", "complete"}) {
      EXPECT_GT(seconds.at(stage), 0) << stage;
      sum += seconds.at(stage).get<double>();
    }
    EXPECT_GT(sum, before);
    EXPECT_LE(sum, passed.count());
    EXPECT_GE(stream.at("late"), 0);
    EXPECT_LT(stream.at("late"), 2);
    before = sum;
  }
}

TEST(Streams, AStepThatOneRankDoesNotWaitForIsLeftOutOnAll) {
  const auto server = serve();
  Events events("heat.t");
  const auto client = events.client(*server);
  client->expect("load data");
  client->expect("observe");
  const Grid grid = gridOf({8, 8, 8});
  MiniSimulation simulation("heat", grid, slabs(grid, 2), 2, {{"t"}}, Layout::Together,
                            waiting(*server, 3));  // far longer than a step takes to be published
  const auto publish = [&](int rank, int64_t step) { return gxy_publish(simulation.rank(rank), step, 0); };
  until([&] { return simulation.publishTogether() == 2; }, "both ranks");
  const int64_t first = simulation.step(), gap = first + 2;
  EXPECT_EQ(publish(0, first + 1), GXY_TAKEN);
  EXPECT_EQ(publish(0, gap), GXY_NOT_TAKEN) << "the step before it waits for rank 1";
  EXPECT_EQ(publish(1, first + 1), GXY_TAKEN);
  EXPECT_EQ(publish(1, gap), GXY_NOT_TAKEN);
  int64_t step = gap;
  until(
      [&] {
        step++;
        std::thread other([&] { publish(1, step); });
        publish(0, step);
        other.join();
        const std::vector<json> all = events.all();
        return !all.empty() && all.back().at("step") > gap;
      },
      "a step after the gap");
  const std::vector<json> all = events.all();
  const auto has = [&](int64_t wanted) {
    return std::any_of(all.begin(), all.end(), [&](const json& e) { return e.at("step") == wanted; });
  };
  EXPECT_TRUE(has(first + 1));
  EXPECT_FALSE(has(gap));
}

TEST(Streams, AStepThatOneRankSkipsIsLeftOutAndTheOthersAreNot) {
  const auto server = serve();
  Events events("heat.t");
  const auto client = events.client(*server);
  client->expect("load data");
  client->expect("observe");
  const Grid grid = gridOf({8, 8, 8});
  MiniSimulation simulation("heat", grid, slabs(grid, 2), 2, {{"t"}}, Layout::Together, to(*server));
  int64_t step = 0;
  const auto offer = [&](bool skips) {
    step++;
    EXPECT_NE(gxy_publish(simulation.rank(0), step, 0), GXY_WRONG);
    EXPECT_NE((skips ? gxy_skip : gxy_publish)(simulation.rank(1), step, 0), GXY_WRONG);
  };
  for (int i = 0; i < 5; i++) offer(true);  // before its first step, too
  until(
      [&] {
        offer(step % 3 == 0);
        return events.count("updated") >= 4;
      },
      "steps");
  for (const json& e : events.all())
    EXPECT_NE(e.at("step").get<int64_t>() % 3, 1) << "the rank has skipped it";
  EXPECT_EQ(gxy_skip(simulation.rank(1), step, 0), GXY_WRONG) << "steps ascend";
}

std::string steerable(const TestServer& server, bool waits) {
  json options = json::parse(waits ? waiting(server, nullptr) : to(server));
  options["steerable"] = {{{"name", "dt"}, {"least", 0}, {"largest", 1}},
                          {{"name", "gas"}, {"least", -1}, {"largest", 1}}};
  return options.dump();
}

TEST(Streams, AllRanksThatWaitAreSteeredAtTheSameStep) {
  const auto server = serve();
  const auto client = server->client();
  client->expect("load insitu");
  const Grid grid = gridOf({8, 8, 8});
  MiniSimulation simulation("heat", grid, slabs(grid, 3), 3, {{"t"}}, Layout::Together,
                            steerable(*server, true));
  EXPECT_EQ(simulation.publishTogether(), 3);
  double value = -5;
  EXPECT_EQ(gxy_steered(simulation.rank(0), "dt", &value), 0);
  EXPECT_EQ(value, -5);
  for (const double wanted : {0.25, 0.5, 0.5, 1.0}) {
    client->expect("insitu.steer heat dt " + std::to_string(wanted));
    const bool isNew = value != wanted;
    int64_t steps = 0;
    for (int changed = 0; changed == 0 && steps < 50; steps++) {
      EXPECT_EQ(simulation.publishTogether(), 3);
      for (int r = 0; r < 3; r++) changed += gxy_steered(simulation.rank(r), "dt", &value);
      EXPECT_TRUE(changed == 0 || changed == 3) << "at the same step";
    }
    if (isNew) {
      EXPECT_LT(steps, 4) << "with the step after the one that was under way, at the latest";
    }
    EXPECT_EQ(value, wanted);
    EXPECT_EQ(gxy_steered(simulation.rank(0), "gas", &value), 0) << "the other has not changed";
  }
  const json known = client->expect("insitu.streams").at("streams").at(0).at("steerable");
  EXPECT_EQ(known.at("dt").at("value"), 1.0);
  EXPECT_FALSE(known.at("gas").contains("value"));
}

TEST(Streams, ASimulationThatNobodyWatchesIsSteered) {
  const auto server = serve();
  const auto client = server->client();
  client->expect("load insitu");
  const Grid grid = gridOf({8, 8, 8});
  MiniSimulation simulation("heat", grid, slabs(grid, 1), 1, {{"t"}}, Layout::Together,
                            steerable(*server, false));
  run(simulation, [&] { return simulation.published() >= 1; });
  client->expect("insitu.steer heat gas -0.5");
  double value = 0;
  run(simulation, [&] { return gxy_steered(simulation.rank(0), "gas", &value) == 1; });
  EXPECT_EQ(value, -0.5);
  client->expect(
      R"(insitu.trigger heat {"name": "slower", "when": {"above": {"t": 0}}, "do": "steer", "steer": {"dt": 0.125}})");
  run(simulation, [&] { return gxy_steered(simulation.rank(0), "dt", &value) == 1; });
  EXPECT_EQ(value, 0.125);
}

TEST(Streams, OnlyWhatIsDeclaredIsSteered) {
  const auto server = serve();
  const auto client = server->client();
  client->expect("load insitu");
  const Grid grid = gridOf({8, 8, 8});
  MiniSimulation simulation("heat", grid, slabs(grid, 1), 1, {{"t"}}, Layout::Together,
                            steerable(*server, false));
  run(simulation, [&] { return simulation.published() >= 1; });
  const auto expectRefused = [&](const std::string& arguments, const std::string& why) {
    const auto reply = client->request("insitu.steer " + arguments);
    EXPECT_FALSE(reply.ok);
    EXPECT_NE(reply.error.find(why), std::string::npos) << reply.error;
  };
  expectRefused("heat dx 0.5", "cannot be steered");
  expectRefused("heat dt 1.5", "expected 0.000000 to 1.000000");
  expectRefused("heat dt nan", "");
  expectRefused("heat dt", "");
  expectRefused("cold dt 0.5", "there is no stream");
  double value = 0;
  EXPECT_EQ(gxy_steered(simulation.rank(0), "dx", &value), GXY_WRONG);
  EXPECT_EQ(gxy_steered(simulation.rank(0), "dt", nullptr), GXY_WRONG);
}

TEST(Streams, ASimulationComputesOnlyWhatIsWanted) {
  const auto server = serve();
  const auto client = server->client();
  client->expect("load data");
  const Grid grid = gridOf({8, 8, 8});
  MiniSimulation simulation("heat", grid, slabs(grid, 2), 2, {{"t"}}, Layout::Together, to(*server));
  run(simulation, [&] { return simulation.published() >= 1; });
  int64_t step = simulation.step(), computed = 0, offered = 0;
  const auto offer = [&](bool together) {  // returns whether all ranks have taken it
    step++;
    offered++;
    int wanted[2], taken = 0;
    for (int r = 0; r < 2; r++) wanted[r] = gxy_wanted(simulation.rank(r), step, 0);
    const bool any = wanted[0] == 1 || wanted[1] == 1;
    computed += any;
    for (int r = 0; r < 2; r++) {
      if (together) {
        EXPECT_EQ(gxy_wanted_settle(simulation.rank(r), step, any), GXY_TAKEN);
      }
      const int result = gxy_publish(simulation.rank(r), step, 0);
      taken += result == GXY_TAKEN;
      if (!(together ? any : wanted[r] == 1)) {
        EXPECT_NE(result, GXY_TAKEN) << "it was not wanted";
      }
    }
    return taken == 2;
  };
  for (int i = 0; i < 300; i++) offer(true);
  EXPECT_EQ(computed, 0) << "nobody looks";
  client->expect("observe");
  for (const bool together : {true, false}) {
    const int64_t before = simulation.published();
    until(
        [&] {
          offer(together);
          return simulation.published() >= before + 3;
        },
        "steps that are wanted");
  }
  EXPECT_LT(computed, offered - 300);
}

TEST(Streams, WaitingEndsWhereTheStreamDoes) {
  for (const std::string how : {"close", "rank", "server"}) {
    SCOPED_TRACE(how);
    auto server = serve();
    const auto client = server->client();
    client->expect("load insitu");
    const Grid grid = gridOf({8, 8, 8});
    json options = json::parse(waiting(*server, nullptr));
    options["reconnect"] = 0;
    MiniSimulation simulation("heat", grid, slabs(grid, 2), 2, {{"t"}}, Layout::Together, options.dump());
    EXPECT_EQ(simulation.publishTogether(), 2);
    const int64_t next = simulation.step() + 1;
    EXPECT_EQ(gxy_publish(simulation.rank(0), next, 0), GXY_TAKEN) << "of which rank 1 publishes nothing";
    int result = GXY_TAKEN;
    std::thread waits([&] { result = gxy_publish(simulation.rank(0), next + 1, 0); });
    if (how == "close")
      client->expect("insitu.close heat");
    else if (how == "rank")
      simulation.closeRank(1);
    else
      server->stop();
    waits.join();
    EXPECT_EQ(result, GXY_LOST);
  }
}

TEST(Streams, TheLastStepIsPublishedAlthoughNobodyLooks) {
  for (const int of : {GXY_OF_POINTS, GXY_OF_CELLS}) {
    const auto server = serve();
    const auto client = server->client();
    client->expect("load data");
    client->expect("load insitu");
    Grid grid = gridOf({12, 9, 10});
    grid.spacing = {0.125, 0.25, 0.5};
    const std::vector<MiniField> fields{{"t", ScalarType::Float64, 1}, {"v", ScalarType::Float32, 3}};
    MiniSimulation simulation("heat", grid, slabs(grid, 3), 3, fields, Layout::Ghosts, to(*server), of);
    run(simulation, [&] { return simulation.published() >= 1; });
    for (int i = 0; i < 10; i++) simulation.publish();
    simulation.publishLastAndClose(8);  // sooner than a step that nobody wants
    EXPECT_EQ(simulation.results(), 0);
    until([&] { return client->expect("insitu.streams").at("streams").empty(); }, "the end of the stream");
    EXPECT_EQ(datasetOn(*server, 0, "heat.t")->origins.at(0).step, simulation.step());
    expectEqualsImport(*server, *client, grid, of, fields);
  }
}

TEST(Streams, EventsAndInfoSayOfWhichStepDataAre) {
  const auto server = serve();
  Events events("heat.t");
  const auto client = events.client(*server);
  client->expect("load data");
  client->expect("observe");
  const Grid grid = gridOf({8, 8, 8});
  MiniSimulation simulation("heat", grid, slabs(grid, 2), 2, {{"t"}}, Layout::Together, to(*server));
  run(simulation, [&] { return simulation.published() >= 2; });
  until([&] { return events.count("added") + events.count("updated") >= 2; }, "events");
  const json info = client->expect("info heat.t").at("datasets").at(0);
  EXPECT_EQ(info.at("stream"), "heat");
  EXPECT_EQ(info.at("time"), 0.5 * info.at("origins").at(0).at("step").get<double>());
  const std::vector<json> all = events.all();
  EXPECT_EQ(all[0].at("event"), "added");
  EXPECT_EQ(all[1].at("event"), "updated");
  for (const json& e : all) {
    EXPECT_EQ(e.at("stream"), "heat");
    EXPECT_EQ(e.at("time"), 0.5 * e.at("step").get<double>());
  }
  EXPECT_LT(all[0].at("step"), all[1].at("step"));
}

TEST(Streams, BlocksThatLeaveAHoleAreToldToTheSimulation) {
  const auto server = serve();
  const Grid grid = gridOf({8, 8, 8});
  auto blocks = slabs(grid, 2);
  blocks[1].extent.first[2]++;
  blocks[1].extent.points[2]--;
  MiniSimulation simulation("heat", grid, blocks, 2, {{"t"}}, Layout::Together, to(*server));
  run(simulation, [&] {
    return std::string(gxy_message(simulation.rank(0))).find("a hole of 8 x 8 x 1 points") !=
           std::string::npos;
  });
}

TEST(Streams, RanksThatDisagreeAreToldSo) {
  const auto server = serve();
  const Grid grid = gridOf({8, 8, 8});
  MiniSimulation simulation("heat", grid, slabs(grid, 2), 2, {{"t"}}, Layout::Together, to(*server));
  simulation.publish();
  const auto client = server->client();
  client->expect("load data");
  client->expect("observe");
  until(
      [&] {  // rank 1 publishes other steps
        simulation.publish();
        gxy_publish(simulation.rank(0), simulation.step() + 1000000, 0);
        gxy_publish(simulation.rank(1), simulation.step() + 2000000, 0);
        return std::string(gxy_message(simulation.rank(0))).find("same steps in the same order") !=
                   std::string::npos ||
               std::string(gxy_message(simulation.rank(1))).find("same steps in the same order") !=
                   std::string::npos;
      },
      "the error");
}

TEST(Streams, ASecondSimulationOfTheSameNameIsRefused) {
  const auto server = serve();
  const Grid grid = gridOf({8, 8, 8});
  MiniSimulation first("heat", grid, slabs(grid, 1), 1, {{"t"}}, Layout::Together, to(*server));
  run(first, [&] { return first.published() >= 1; });
  MiniSimulation second("heat", grid, slabs(grid, 1), 1, {{"t"}}, Layout::Together, to(*server));
  run(second, [&] {
    return std::string(gxy_message(second.rank(0))).find("two simulations cannot have one name") !=
           std::string::npos;
  });
  first.closeRank(0);
  run(second, [&] { return second.published() >= 1; });
}

TEST(Streams, ARankThatGoesEndsTheStreamAndItsDataStay) {
  const auto server = serve();
  const auto client = server->client();
  client->expect("load data");
  client->expect("load insitu");
  const Grid grid = gridOf({8, 8, 8});
  MiniSimulation simulation("heat", grid, slabs(grid, 2), 2, {{"t"}}, Layout::Together, to(*server, 0));
  run(simulation, [&] { return simulation.published() >= 1; });
  simulation.closeRank(1);
  until([&] { return client->expect("insitu.streams").at("streams").empty(); }, "the end of the stream");
  EXPECT_EQ(client->expect("info heat.t").at("datasets").size(), 1u);
}

TEST(Streams, ASimulationThatBeginsAgainUpdatesItsDatasets) {
  const auto server = serve();
  const auto client = server->client();
  client->expect("load data");
  const Grid grid = gridOf({8, 8, 8});
  for (int run_ = 1; run_ <= 3; run_++) {
    MiniSimulation simulation("heat", grid, slabs(grid, 2), 2, {{"t"}}, Layout::Together, to(*server));
    run(simulation, [&] { return simulation.published() >= 1; });
  }
  EXPECT_GE(client->expect("info heat.t").at("datasets").at(0).at("generation"), 3);
}

TEST(Streams, EndWithTheServerAndTheSimulationGoesOn) {
  auto server = serve();
  const Grid grid = gridOf({8, 8, 8});
  MiniSimulation simulation("heat", grid, slabs(grid, 2), 2, {{"t"}}, Layout::Together, to(*server));
  run(simulation, [&] { return simulation.published() >= 1; });
  server->stop();
  run(simulation,
      [&] { return gxy_publish(simulation.rank(0), 1000000 + simulation.step(), 0) == GXY_LOST; });
}

TEST(Streams, ATenantThatHasNoRoomForAStepIsToldAndTheServerGoesOn) {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  setup.serverRank.tenantMemory = 900000;  // room for one step of two
  TestServer server(std::move(setup));
  const auto client = server.client();
  client->expect("load data");
  client->expect("load insitu");
  client->expect("observe");
  const Grid grid = gridOf({64, 64, 64});
  MiniSimulation simulation("heat", grid, slabs(grid, 2), 2, {{"t"}}, Layout::Together, to(server));
  run(simulation, [&] {
    const json streams = client->expect("insitu.streams").at("streams");
    return !streams.empty() &&
           streams.at(0).value("problem", "").find("bytes are needed") != std::string::npos;
  });
  EXPECT_EQ(client->expect("echo here").at("text"), "here");
}

TEST(Streams, ADroppedDatasetComesBackWithTheNextStep) {
  const auto server = serve();
  Events events("heat.t");
  const auto client = events.client(*server);
  client->expect("load data");
  client->expect("observe");
  const Grid grid = gridOf({8, 8, 8});
  MiniSimulation simulation("heat", grid, slabs(grid, 2), 2, {{"t"}}, Layout::Together, to(*server));
  run(simulation, [&] { return simulation.published() >= 1; });
  client->expect("drop heat.t");
  run(simulation, [&] { return events.count("dropped") == 1 && events.count("added") == 2; });
}

TEST(Streams, AnImportUnderAStreamsNameIsNotHeldUp) {
  const auto server = serve();
  const auto client = server->client();
  client->expect("load data");
  const Grid grid = gridOf({8, 8, 8});
  MiniSimulation simulation("heat", grid, slabs(grid, 1), 1, {{"t"}}, Layout::Together, to(*server));
  run(simulation, [&] { return simulation.published() >= 1; });
  client->expect("observe");  // The next step is asked for, and the simulation computes for long.
  until([&] { return client->request("load insitu").ok; }, "the module");
  client->expect(importBall("heat.t"));
  EXPECT_TRUE(client->expect("info heat.t").at("datasets").at(0).contains("file"));
}

TEST(Streams, WhatDoesNotFitIsRefusedBeforeAnythingIsMadeOfIt) {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  setup.serverRank.tenantMemory = 1 << 20;
  TestServer server(std::move(setup));
  const Grid grid = gridOf({int64_t(1) << 15, int64_t(1) << 15, int64_t(1) << 15});
  float value = 0;  // It is never read.
  gxy_sim* sim = gxy_open("large", 0, 1, to(server).c_str());
  const int64_t first[3] = {0, 0, 0};
  EXPECT_EQ(gxy_grid(sim, "grid", 0, GXY_OF_POINTS, grid.points.data(), first, grid.points.data(),
                     &grid.origin[0], &grid.spacing[0]),
            GXY_TAKEN);
  EXPECT_EQ(gxy_field(sim, "grid", 0, "t", GXY_OF_POINTS, {&value, GXY_FLOAT32, 1, {4, 4, 4}, 0, 0}),
            GXY_TAKEN);
  int64_t step = 0;
  until(
      [&] {
        gxy_publish(sim, ++step, 0);
        return std::string(gxy_message(sim)).find("bytes of a step, but has room for 1048576 bytes") !=
               std::string::npos;
      },
      "the reason");
  gxy_close(sim, 0);
}

TEST(Streams, RanksOfASimulationThatHasEndedDoNotComeAgain) {
  const auto server = serve();
  const auto client = server->client();
  client->expect("load insitu");
  const Grid grid = gridOf({8, 8, 8});
  MiniSimulation simulation("heat", grid, slabs(grid, 2), 2, {{"t"}}, Layout::Together, to(*server));
  run(simulation, [&] { return simulation.published() >= 1; });
  simulation.closeRank(1);
  until([&] { return std::string(gxy_message(simulation.rank(0))).find("closed by rank 1") == 0; },
        "the word");
  until([&] { return client->expect("insitu.streams").at("streams").empty(); }, "the end of the stream");
  std::this_thread::sleep_for(std::chrono::milliseconds(200));  // four times its pause between attempts
  EXPECT_TRUE(client->expect("insitu.streams").at("streams").empty());
  EXPECT_EQ(gxy_publish(simulation.rank(0), 1000000, 0), GXY_LOST);
}

TEST(Streams, AreToldByStat) {
  const auto server = serve();
  const auto client = server->client();
  const Grid grid = gridOf({8, 8, 8});
  MiniSimulation simulation("heat", grid, slabs(grid, 2), 2, {{"t"}}, Layout::Together,
                            waiting(*server, nullptr));
  for (int step = 1; step <= 3; step++) EXPECT_EQ(simulation.publishTogether(), 2);
  until([&] { return simulation.published() == 3; }, "the last step");
  const json stat = client->expect("stat"), stream = stat.at("streams").at(0);
  EXPECT_EQ(stream.at("name"), "heat");
  EXPECT_EQ(stream.at("tenant"), "user");
  EXPECT_EQ(stream.at("ranks"), 2);
  EXPECT_EQ(stream.at("published"), 3);
  EXPECT_EQ(stream.at("bytes"), 3 * 8 * 8 * 8 * sizeof(float));
  for (const char* member : {"step", "missed", "abandoned", "margin", "seconds", "late"})
    EXPECT_TRUE(stream.contains(member)) << member;
  EXPECT_NE(stat.at("text").get<std::string>().find("stream heat of user: 2 of 2 ranks, 3 steps published"),
            std::string::npos);
}

}  // namespace
}  // namespace gxy::test
