// SPDX-License-Identifier: Apache-2.0
// Simulations that publish cells with a volume: what arrives is what an import of the same step would give.
#include <fstream>

#include "tests/insitu/mini_volume.h"
#include "tests/insitu/published.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

using nlohmann::json;

bool areSame(const std::vector<float>& a, const std::vector<float>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); });
}

void expectSame(const Mesh& found, const Mesh& expected) {
  EXPECT_EQ(found.ofCells, expected.ofCells);
  EXPECT_EQ(found.components, expected.components);
  EXPECT_EQ(found.shift, expected.shift);
  EXPECT_EQ(found.scale, expected.scale);
  EXPECT_EQ(found.ranges, expected.ranges);
  EXPECT_EQ(found.box, expected.box);
  EXPECT_EQ(found.report, expected.report);
  ASSERT_EQ(found.blocks.size(), expected.blocks.size());
  for (const auto& [partition, block] : found.blocks) {
    const MeshBlock& other = expected.blocks.at(partition);
    EXPECT_TRUE(block.points == other.points) << partition;
    EXPECT_TRUE(areSame(block.values, other.values)) << partition;
    EXPECT_TRUE(areSame(block.cellValues, other.cellValues)) << partition;
    EXPECT_TRUE(block.cells.points == other.cells.points) << partition;
    EXPECT_TRUE(block.neighbours == other.neighbours && block.shell == other.shell) << partition;
  }
}

void writeFile(const TestServer& server, const GridFile& grid) {
  std::ofstream(server.folder() / "file.vtu", std::ios::binary) << grid.vtu();
}

/// Compares a field on all ranks with an import of a file that has the same step. Returns the step.
int64_t expectEqualsImport(TestServer& server, Viewer& viewer, const MiniVolume& volume,
                           const std::string& field) {
  const std::string name = "sea." + field;
  const auto published = datasetOn(server, 0, name);
  const int64_t step = published->origins.at(0).step;
  EXPECT_EQ(published->time, 0.5 * double(step));
  EXPECT_EQ(published->stream, "sea");
  EXPECT_EQ(published->array, field);
  writeFile(server, volume.fileOf(step));
  const json file{{"name", "file"}, {"filename", "file.vtu"}, {"type", "Volume"}, {"array", field}};
  viewer.client->expect("import like " + name + " " + json{{"Datasets", {file}}}.dump());
  for (int r = 0; r < server.serverRank().ranks(); r++) {
    const auto found = datasetOn(server, r, name), expected = datasetOn(server, r, "file");
    EXPECT_EQ(found->bytes, expected->bytes);
    EXPECT_EQ(found->memory.bytes() + found->sharedMemory->bytes(), expected->memory.bytes());
    EXPECT_EQ(*found->partitioning, *expected->partitioning);
    expectSame(*found->mesh, *expected->mesh);
  }
  const auto picture = [&](const std::string& dataset, const char* cells) {
    const Range range = published->range();
    json vis{{"type", "Volume"},         {"dataset", dataset},           {"data range", "data"},
             {"volume rendering", true}, {"slices", {{1, 0.3, 0, 0.4}}}, {"cells", cells}};
    if (std::string(cells) == "smooth") vis["isovalues"] = {0.5 * (range.min + range.max)};
    viewer.client->expect(
        "set 1 " + json{{"Visualization", {{"operators", {vis}}}}, {"Camera", {{"fit", true}}}}.dump());
    return viewer.frame().rgba;
  };
  for (const char* cells : {"smooth", "flat"}) {
    if (!published->mesh->ofCells && std::string(cells) == "flat") continue;
    const auto ours = picture(name, cells), theirs = picture("file", cells);
    EXPECT_TRUE(ours == theirs) << "the pictures of " << name << " differ, " << cells;
    const auto drawn = std::count_if(ours.begin(), ours.end(), [](uint8_t v) { return v > 30 && v < 255; });
    EXPECT_GE(drawn, 100) << name;
  }
  return step;
}

TEST(VolumeCells, ThatArePublishedEqualTheImportOfTheSameStep) {
  for (uint64_t seed = 1; seed <= uint64_t(sweep(6)); seed++) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const auto server = serve(1 + int(seed % 3));
    Viewer viewer(*server);
    viewer.client->expect("load insitu");
    viewer.client->expect("observe");
    MiniVolume::Settings settings;
    settings.ranks = 1 + int(random.below(4));
    settings.cubes = 2 + uint32_t(random.below(3));
    settings.differ = seed % 3 == 2;
    settings.seed = seed;
    MiniVolume volume(to(*server), settings);
    run(volume, [&] { return volume.published() >= 2; });
    if (seed % 2 == 0) volume.moved = 0.2;
    volume.publishLastAndClose(20);
    until([&] { return viewer.client->expect("insitu.streams").at("streams").empty(); },
          "the end of the stream");
    for (const char* field : {"heat", "flow", "level"})
      EXPECT_EQ(expectEqualsImport(*server, viewer, volume, field), volume.step());
    if (settings.differ && settings.ranks > 1 && settings.ranks != 4) {
      EXPECT_GT(datasetOn(*server, 0, "sea.heat")->mesh->report.differingPoints, 0u);
    }
  }
}

TEST(VolumeCells, WithFieldsOfCellsAndGhostsEqualTheImportOfTheSameStep) {
  for (uint64_t seed = 1; seed <= uint64_t(sweep(6)); seed++) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const auto server = serve(1 + int(seed % 3));
    Viewer viewer(*server);
    viewer.client->expect("load insitu");
    viewer.client->expect("observe");
    MiniVolume::Settings settings;
    settings.ranks = 1 + int((seed + 1) % 4);
    settings.cubes = 3;
    settings.ofCells = true;
    settings.ofPoints = seed % 3 != 0;
    settings.ghosts = seed % 2 == 0;
    settings.differ = seed % 4 == 0;
    settings.seed = seed;
    MiniVolume volume(to(*server), settings);
    run(volume, [&] { return volume.published() >= 1; });
    if (seed % 2 == 0) volume.moved = 0.2;
    run(volume, [&] { return volume.published() >= 4; });
    EXPECT_GE(viewer.client->expect("insitu.streams").at("streams").at(0).at("same cells"), 1);
    volume.publishLastAndClose(20);
    until([&] { return viewer.client->expect("insitu.streams").at("streams").empty(); },
          "the end of the stream");
    for (const char* field : {"load", "pull"})
      EXPECT_EQ(expectEqualsImport(*server, viewer, volume, field), volume.step());
    for (const char* field : {"heat", "flow"})
      if (settings.ofPoints) expectEqualsImport(*server, viewer, volume, field);
    const json all = viewer.client->expect("data.info").at("datasets");
    for (const json& one : all)
      EXPECT_EQ(one.at("name").get<std::string>().find("vtkGhostType"), std::string::npos);
    const MeshReport& report = datasetOn(*server, 0, "sea.load")->mesh->report;
    EXPECT_GT(report.noDataCells, 0u);
    EXPECT_EQ(report.ghostCells > 0, settings.ghosts);
  }
}

using OnRanks = std::vector<std::shared_ptr<const Dataset>>;

OnRanks onRanks(TestServer& server, const std::string& name) {
  OnRanks all;
  for (int r = 0; r < server.serverRank().ranks(); r++) all.push_back(datasetOn(server, r, name));
  return all;
}

/// Whether all but the values is the same in memory.
bool isShared(const OnRanks& some, const OnRanks& others) {
  bool all = true;
  for (size_t r = 0; r < some.size(); r++)
    for (const auto& [partition, block] : some[r]->mesh->blocks) {
      const MeshBlock& other = others[r]->mesh->blocks.at(partition);
      all = all && block.points.sharesWith(other.points) && block.shell.sharesWith(other.shell);
      for (size_t type = 0; type < kCellTypes; type++)
        all = all && block.cells.points[type].sharesWith(other.cells.points[type]) &&
              block.neighbours[type].sharesWith(other.neighbours[type]);
    }
  return all;
}

TEST(VolumeCells, ThatStayAreSharedByAllFieldsAndSteps) {
  for (const bool moves : {false, true}) {
    const auto server = serve(3);
    Viewer viewer(*server);
    viewer.client->expect("load insitu");
    viewer.client->expect("observe");
    MiniVolume::Settings settings;
    settings.ranks = 3;
    settings.differ = moves;
    MiniVolume volume(to(*server), settings);
    const auto sameCells = [&] {
      return viewer.client->expect("insitu.streams").at("streams").at(0).value("same cells", int64_t(0));
    };
    run(volume, [&] { return volume.published() >= 1; });
    const OnRanks first = onRanks(*server, "sea.heat");
    run(volume, [&] { return volume.published() >= 4; });
    EXPECT_GE(sameCells(), 2);
    EXPECT_TRUE(isShared(first, onRanks(*server, "sea.heat")));
    EXPECT_GT(datasetOn(*server, 0, "sea.heat")->origins, first[0]->origins);
    if (moves) {  // One point moves on one rank, by a bit; and then nothing does.
      volume.change = [](std::vector<RankVolume>& ranks) {
        double& x = ranks[1].points[size_t(ranks[1].connectivity[0])][0];
        x = std::nextafter(x, 0.5);
      };
      run(volume, [&] { return !isShared(first, onRanks(*server, "sea.heat")); });
      const int64_t before = sameCells(), published = volume.published();
      run(volume, [&] { return volume.published() >= published + 3; });
      EXPECT_GT(sameCells(), before);
    }
    volume.publishLastAndClose(20);
    until([&] { return viewer.client->expect("insitu.streams").at("streams").empty(); },
          "the end of the stream");
    const OnRanks last = onRanks(*server, "sea.heat");
    EXPECT_EQ(isShared(first, last), !moves);
    for (const char* field : {"heat", "flow", "level"}) {
      EXPECT_TRUE(isShared(last, onRanks(*server, std::string("sea.") + field))) << field;
      EXPECT_EQ(expectEqualsImport(*server, viewer, volume, field), volume.step());
    }
  }
}

TEST(VolumeCells, MayComeAndGo) {
  const auto server = serve(2);
  Viewer viewer(*server);
  viewer.client->expect("load insitu");
  viewer.client->expect("observe");
  MiniVolume volume(to(*server), {});
  run(volume, [&] { return volume.published() >= 1; });
  const auto none = [](std::vector<RankVolume>& ranks) {
    for (RankVolume& m : ranks) m = {};
  };
  for (const bool some : {false, true, false}) {
    if (some)
      volume.change = [](auto&) {};
    else
      volume.change = none;
    const int64_t before = volume.published();
    run(volume, [&] { return volume.published() >= before + 2; });
    const auto d = datasetOn(*server, 1, "sea.flow");
    EXPECT_EQ(d->mesh->report.points > 0, some);
    EXPECT_EQ(d->mesh->box.empty(), !some);
    viewer.client->expect("set 1 " + stateOf("sea.heat"));
    EXPECT_FALSE(viewer.frame().rgba.empty());
  }
}

TEST(VolumeCells, ThatAreWrongAreLeftOutAndToldToTheirStreamOnly) {
  const auto server = serve(3);
  const auto client = server->client();
  client->expect("load data");
  client->expect("load insitu");
  client->expect("observe");
  MiniVolume volume(to(*server), {});
  MiniVolume::Settings settings;
  settings.name = "calm";
  settings.cubes = 2;
  MiniVolume other(to(*server), settings);
  run(volume, [&] { return volume.published() >= 1; });
  const auto problemOf = [&](const std::string& stream) {
    const json streams = client->expect("insitu.streams").at("streams");
    for (const json& one : streams)
      if (one.at("name") == stream) return one.value("problem", "");
    return std::string("no stream");
  };
  const auto expectProblem = [&](const std::function<void(RankVolume&)>& wrong, const std::string& why) {
    const auto before = datasetOn(*server, 0, "sea.heat");
    volume.change = [&](std::vector<RankVolume>& ranks) { wrong(ranks[1]); };
    const int64_t otherBefore = other.published();
    run(volume, [&] {
      other.publish();
      return problemOf("sea").find(why) != std::string::npos && other.published() >= otherBefore + 2;
    });
    EXPECT_NE(problemOf("sea").find("cells \"block\", rank 1 of the simulation"), std::string::npos)
        << problemOf("sea");
    EXPECT_EQ(problemOf("calm"), "");
    volume.change = [](auto&) {};
    const int64_t published = volume.published();
    run(volume, [&] { return volume.published() > published; });
    EXPECT_GT(datasetOn(*server, 0, "sea.heat")->origins.at(0).step, before->origins.at(0).step);
  };
  expectProblem([](RankVolume& m) { m.types[2] = 25; },
                "cell 2: cells of type 25 (quadratic hexahedra) are not supported, expected lines");
  expectProblem([](RankVolume& m) { m.types[3] = GXY_TRIANGLE; },
                "cell 3: type 5, of triangles, in a mesh of cells with a volume");
  expectProblem([](RankVolume& m) { m.offsets[2] = m.offsets[1] + 2; }, "cell 1: 2 points, expected ");
  expectProblem([](RankVolume& m) { m.offsets[2] = 1; }, "cell 1: its offsets do not ascend");
  expectProblem([](RankVolume& m) { m.connectivity[2] = int64_t(m.points.size()); },
                "cell 0: its point 2 is ");
  expectProblem([](RankVolume& m) { m.points[size_t(m.connectivity[0])][2] = INFINITY; }, "are not finite");
}

TEST(VolumeCells, OutsideOfTheDomainAreLeftOutAndTold) {
  const auto server = serve(2);
  const auto client = server->client();
  client->expect("load data");
  client->expect("load insitu");
  client->expect("observe");
  MiniVolume volume(to(*server), {});
  run(volume, [&] { return volume.published() >= 1; });
  volume.change = [](std::vector<RankVolume>& ranks) {
    for (RankVolume& m : ranks)
      for (auto& p : m.points) p[1] *= 1.5;
  };
  run(volume, [&] {
    const std::string problem = client->expect("insitu.streams").at("streams").at(0).value("problem", "");
    return problem.find(
               "cells \"block\": they fill (0.000000, 0.000000, 0.000000) to (1.000000, 1.500000, "
               "1.000000), expected them inside the stream's domain, which is (-0.050000, -0.050000, "
               "-0.050000) to (1.050000, 1.050000, 1.050000)") != std::string::npos;
  });
  volume.change = [](std::vector<RankVolume>& ranks) {
    for (RankVolume& m : ranks)
      for (auto& p : m.points) p[1] *= 1.04;
  };
  const int64_t before = volume.published();
  run(volume, [&] { return volume.published() > before; });
}

TEST(VolumeCells, ForWhichThereIsNoRoomAreLeftOutAndTheServerGoesOn) {
  ServerSetup setup;
  setup.ranks = 2;
  setup.modules = GALAXY_MODULES;
  setup.serverRank.tenantMemory = 1 << 20;
  TestServer server(std::move(setup));
  const auto client = server.client();
  client->expect("load data");
  client->expect("load insitu");
  client->expect("observe");
  MiniVolume::Settings settings;
  settings.cubes = 2;
  MiniVolume volume(to(server), settings);
  run(volume, [&] { return volume.published() >= 1; });
  volume.change = [](std::vector<RankVolume>& ranks) {
    RankVolume& m = ranks[0];
    m = {};
    m.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    m.heat.resize(4);
    m.flow.resize(4);
    m.level.resize(4);
    for (int c = 0; c < 50000; c++) {
      for (int64_t p = 0; p < 4; p++) m.connectivity.push_back(p);
      m.offsets.push_back(int64_t(m.connectivity.size()));
      m.types.push_back(GXY_TETRAHEDRON);
    }
  };
  expectTooLittleRoomAndThenSteps(volume, *client);
  volume.publishLastAndClose(20);
  until([&] { return client->expect("insitu.streams").at("streams").empty(); }, "the end of the stream");
  for (const char* field : {"heat", "flow", "level"}) client->expect(std::string("drop sea.") + field);
  for (int r = 0; r < 2; r++) EXPECT_EQ(server.serverRank(r).ledger.total("user"), 0) << r;
}

TEST(VolumeCells, NeedAFieldAndGhostsThatAreBytes) {
  const auto server = serve(1);
  const auto client = server->client();
  client->expect("load insitu");
  const std::string options = to(*server, 0);
  const double points[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const int32_t corners[4] = {0, 1, 2, 3}, ends[2] = {0, 4};
  const int type = GXY_TETRAHEDRON;
  const auto expectWrong = [&](gxy_array ghosts, const std::string& why) {
    gxy_sim* sim = gxy_open("sea", 0, 1, options.c_str());
    EXPECT_EQ(gxy_cells(sim, "block", 4, {points, GXY_FLOAT64, 3, {24, 0, 0}, 0, 0}, 1,
                        {&type, GXY_INT32, 1, {4, 0, 0}, 0, 0}, {ends, GXY_INT32, 1, {4, 0, 0}, 0, 0},
                        {corners, GXY_INT32, 1, {4, 0, 0}, 0, 0}),
              GXY_TAKEN);
    EXPECT_EQ(gxy_field(sim, "block", 0, "vtkGhostType", GXY_OF_CELLS, ghosts), GXY_TAKEN);
    EXPECT_EQ(gxy_publish(sim, 1, 0), GXY_WRONG);
    EXPECT_NE(std::string(gxy_message(sim)).find(why), std::string::npos) << gxy_message(sim);
    gxy_close(sim, 0);
  };
  expectWrong({corners, GXY_INT32, 1, {4, 0, 0}, 0, 0},
              "field \"vtkGhostType\" has type 4 and 1 components, expected one uint8 (1)");
  expectWrong({corners, GXY_UINT8, 1, {1, 0, 0}, 0, 0},
              "cells with a volume without a field, expected one or more fields of points or cells");
}

}  // namespace
}  // namespace gxy::test
