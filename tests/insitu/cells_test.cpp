// SPDX-License-Identifier: Apache-2.0
// Simulations that publish lines and triangles: what arrives is what an import of the same step would give.
#include "tests/insitu/mini_mesh.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

using nlohmann::json;

/// Compares a dataset with an import of a file that has the same step.
void expectEqualsImport(TestServer& server, Viewer& viewer, const MiniMesh& mesh, const std::string& name) {
  const auto published = datasetOn(server, 0, name);
  const OwnedGeometry& a = *published->geometry;
  const int64_t step = published->origins.at(0).step;
  EXPECT_EQ(published->time, 0.5 * double(step));
  const std::string type = a.kind == GeometryKind::PathLines ? "PathLines" : "Triangles";
  if (a.primitives + a.droppedPrimitives == 0) return;  // A file without any is refused.
  mesh.write(server.folder().path().string() + "/file.vtu", step);
  json file{{"name", "file"}, {"filename", "file.vtu"}, {"type", type}};
  if (!published->array.empty()) file["array"] = published->array;
  viewer.client->expect("import like " + name + " " + json{{"Datasets", {file}}}.dump());
  const OwnedGeometry& b = *datasetOn(server, 0, "file")->geometry;
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.box, b.box);
  EXPECT_EQ(a.middle, b.middle);
  EXPECT_EQ(a.spacing, b.spacing);
  EXPECT_EQ(a.range, b.range);
  EXPECT_EQ(a.colored, b.colored);
  EXPECT_EQ(a.primitives, b.primitives);
  EXPECT_EQ(a.droppedPrimitives, b.droppedPrimitives);
  const GeometryBlock found = gathered(server, name);
  EXPECT_EQ(found, gathered(server, "file")) << name;
  EXPECT_EQ(found.ids.size(), a.primitives);
  const auto picture = [&](const std::string& dataset) {
    json vis{{"type", type}, {"dataset", dataset}, {"data range", "data"}};
    if (type == "PathLines") vis["radius"] = 0.01;
    viewer.client->expect(
        "set 1 " + json{{"Visualization", {{"operators", {vis}}}}, {"Camera", {{"fit", true}}}}.dump());
    return viewer.frame().rgba;
  };
  const auto ours = picture(name), theirs = picture("file");
  EXPECT_TRUE(ours == theirs) << "the pictures of " << name << " differ";
  const auto drawn = std::count_if(ours.begin(), ours.end(), [](uint8_t v) { return v > 60 && v < 255; });
  EXPECT_GE(drawn, a.primitives > 10 ? 100 : 0);
}

MiniMesh::Settings settingsOf(Random& random, uint64_t seed) {
  MiniMesh::Settings s;
  s.ranks = 1 + int(random.below(5));
  s.lines = seed % 3 == 0;
  const std::vector<std::vector<int>> lines{{GXY_LINE}, {GXY_POLY_LINE}, {GXY_LINE, GXY_POLY_LINE}},
      faces{{GXY_TRIANGLE},
            {GXY_QUAD},
            {GXY_POLYGON},
            {GXY_TRIANGLE, GXY_TRIANGLE_STRIP, GXY_POLYGON, GXY_PIXEL, GXY_QUAD},
            {GXY_TRIANGLE, GXY_QUAD}};
  s.types = s.lines ? lines[seed / 3 % lines.size()] : faces[seed % faces.size()];
  s.floats = random.oneIn(2);
  s.shortIndices = random.oneIn(2);
  s.fields = seed % 4 != 0;
  s.normals = seed % 7 == 0 || random.oneIn(2);
  s.zeroNormals = seed % 7 == 0;
  s.flat = seed % 5 == 0;
  return s;
}

TEST(Cells, ThatArePublishedEqualTheImportOfTheSameStep) {
  for (uint64_t seed = 1; seed <= uint64_t(sweep(15)); seed++) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const auto server = serve(1 + int(random.below(3)));
    Viewer viewer(*server);
    viewer.client->expect("load insitu");
    const MiniMesh::Settings settings = settingsOf(random, seed);
    MiniMesh mesh(to(*server), settings, seed);
    viewer.client->expect("observe");
    run(mesh, [&] { return mesh.published() >= 2; });
    mesh.publishLastAndClose(20);
    until([&] { return viewer.client->expect("insitu.streams").at("streams").empty(); },
          "the end of the stream");
    if (!settings.fields) {
      expectEqualsImport(*server, viewer, mesh, "sea.surface");
      EXPECT_EQ(datasetOn(*server, 0, "sea.surface")->origins.at(0).step, mesh.step());
      continue;
    }
    for (const char* field : {"sea.height", "sea.flow", "sea.paint", "sea.region"}) {
      expectEqualsImport(*server, viewer, mesh, field);
      EXPECT_EQ(datasetOn(*server, 0, field)->origins.at(0).step, mesh.step());
    }
  }
}

TEST(Cells, MayComeAndGoAlsoWhereNoRankHasAnyAtFirst) {
  const auto server = serve(2);
  const auto client = server->client();
  client->expect("load data");
  client->expect("observe");
  MiniMesh mesh(to(*server), {}, 1);
  uint64_t triangles = 0;
  mesh.change = [&](std::vector<RankMesh>& ranks) {
    for (RankMesh& m : ranks) m = {};
    for (uint64_t i = 0; i < triangles; i++) {
      RankMesh& m = ranks[i % ranks.size()];
      for (int64_t p = 0; p < 3; p++) {
        m.connectivity.push_back(int64_t(m.points.size()));
        m.points.push_back({double(i), double(p), double(p * p), 0});
      }
      m.offsets.push_back(int64_t(m.connectivity.size()));
      m.types.push_back(GXY_TRIANGLE);
      m.height.resize(m.points.size());
      m.flow.resize(m.points.size());
      m.paint.resize(m.points.size());
      m.region.push_back(5);
    }
  };
  for (const uint64_t count : {0, 1, 5000, 2, 0, 3}) {
    triangles = count;
    const int64_t before = mesh.published();
    run(mesh, [&] { return mesh.published() >= before + 2; });
    for (const char* field : {"sea.height", "sea.region"}) {
      const auto d = datasetOn(*server, 0, field);
      EXPECT_EQ(d->geometry->kind, GeometryKind::Triangles);
      EXPECT_EQ(d->geometry->primitives, count);
    }
  }
}

TEST(Cells, ThatAreWrongAreLeftOutAndTold) {
  const auto server = serve(3);
  const auto client = server->client();
  client->expect("load data");
  client->expect("load insitu");
  client->expect("observe");
  MiniMesh::Settings settings;
  settings.types = {GXY_TRIANGLE, GXY_QUAD};
  settings.ranks = 3;
  MiniMesh mesh(to(*server), settings, 1);
  settings.name = "calm";
  MiniMesh other(to(*server), settings, 2);
  const auto hasCells = [](RankMesh& m) { return m.types.size() > 4; };
  run(mesh, [&] { return mesh.published() >= 1; });
  const auto expectProblem = [&](const std::function<void(RankMesh&)>& change, const std::string& why) {
    mesh.change = [&](std::vector<RankMesh>& ranks) {
      for (RankMesh& m : ranks)
        if (hasCells(m)) change(m);
    };
    const auto problemOf = [&](const std::string& stream) {
      const json streams = client->expect("insitu.streams").at("streams");
      for (const json& one : streams)
        if (one.at("name") == stream) return one.value("problem", "");
      return std::string("no stream");
    };
    const int64_t otherBefore = other.published();
    run(mesh, [&] {
      other.publish();
      return problemOf("sea").find(why) != std::string::npos && other.published() >= otherBefore + 2;
    });
    EXPECT_NE(problemOf("sea").find("cells \"surface\", rank "), std::string::npos) << problemOf("sea");
    EXPECT_EQ(problemOf("calm"), "");
    mesh.change = [](auto&) {};
    const int64_t before = mesh.published();
    run(mesh, [&] { return mesh.published() > before; });
  };
  expectProblem([](RankMesh& m) { m.types[2] = 24; },
                "cell 2: cells of type 24 (quadratic tetrahedra) are not supported, expected lines");
  expectProblem([](RankMesh& m) { m.types[2] = 12; },
                "cell 2: type 12, of cells with a volume, in a mesh of triangles");
  expectProblem([](RankMesh& m) { m.types[3] = GXY_POLY_LINE; },
                "cell 3: type 4, of lines, in a mesh of triangles");
  expectProblem([](RankMesh& m) { m.offsets[2] = 1; }, "cell 1: its offsets do not ascend");
  expectProblem([](RankMesh& m) { m.offsets[0] = -1; }, "cell 0: its offsets do not ascend, or are negative");
  expectProblem([](RankMesh& m) { m.connectivity[1] = -7; }, "cell 0: its point 1 is negative");
  expectProblem([](RankMesh& m) { m.connectivity[0] = int64_t(m.points.size()); }, "expected one of the ");
  expectProblem([](RankMesh& m) { m.points[size_t(m.connectivity[0])][2] = INFINITY; }, "are not finite");
}

TEST(Cells, OfOneMeshAreLinesOrTriangles) {
  const auto server = serve(1);
  const auto client = server->client();
  client->expect("load insitu");
  const std::string options = to(*server, 0);
  const double points[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const int32_t corners[3] = {0, 1, 2};
  std::vector<gxy_sim*> sims;
  for (int r = 0; r < 3; r++) {
    sims.push_back(gxy_open("sea", r, 3, options.c_str()));
    const int type = r == 2 ? GXY_LINE : GXY_TRIANGLE;
    EXPECT_EQ(gxy_cells(sims.back(), "surface", 3, {points, GXY_FLOAT64, 3, {24, 0, 0}, 0, 0}, 1,
                        {&type, GXY_INT32, 1, {0, 0, 0}, 0, 0}, {}, {corners, GXY_INT32, 1, {4, 0, 0}, 0, 0}),
              GXY_TAKEN);
  }
  int64_t step = 0;
  until(
      [&] {
        step++;
        for (gxy_sim* s : sims) gxy_publish(s, step, 0);
        return std::any_of(sims.begin(), sims.end(), [](gxy_sim* s) {
          return std::string(gxy_message(s)).find("expected the same on all ranks") != std::string::npos;
        });
      },
      "the reason");
  for (gxy_sim* s : sims) gxy_close(s, 0);
}

TEST(Cells, ForWhichThereIsNoRoomAreLeftOutAndTheServerGoesOn) {
  ServerSetup setup;
  setup.ranks = 2;
  setup.modules = GALAXY_MODULES;
  setup.serverRank.tenantMemory = 1 << 20;
  TestServer server(std::move(setup));
  const auto client = server.client();
  client->expect("load data");
  client->expect("load insitu");
  client->expect("observe");
  MiniMesh::Settings settings;
  settings.fields = false;
  MiniMesh mesh(to(server), settings, 1);
  run(mesh, [&] { return mesh.published() >= 1; });
  mesh.change = [](std::vector<RankMesh>& ranks) {
    RankMesh& m = ranks[0];
    m = {};
    m.points.resize(3);
    m.points[1][0] = m.points[2][1] = 1;
    for (int c = 0; c < 50000; c++) {
      for (int64_t p = 0; p < 3; p++) m.connectivity.push_back(p);
      m.offsets.push_back(int64_t(m.connectivity.size()));
      m.types.push_back(GXY_TRIANGLE);
    }
  };
  expectTooLittleRoomAndThenSteps(mesh, *client);
}

TEST(Cells, AreShownTogetherWithAGridAndParticlesOfTheirSimulation) {
  for (const bool lines : {false, true}) {
    const auto server = serve(3);
    Viewer viewer(*server);
    viewer.client->expect("load insitu");
    viewer.client->expect("observe");
    const Grid grid = gridOf({9, 10, 11});
    MiniMesh::Settings settings;
    settings.lines = lines;
    settings.types = {lines ? GXY_POLY_LINE : GXY_TRIANGLE};
    MiniMesh mesh(to(*server), settings, 7);
    std::vector<std::unique_ptr<MiniArray>> arrays;
    const Extent halves[2] = {{{0, 0, 0}, {9, 10, 5}}, {{0, 0, 5}, {9, 10, 6}}};
    for (const Extent& half : halves)
      arrays.push_back(std::make_unique<MiniArray>(MiniField{"t"}, half, Layout::Ghosts));
    const float atoms[6] = {0, 0.5F, 3, -0.5F, 0.5F, 3};
    mesh.beside = [&](gxy_sim* sim, int rank, int64_t step) {
      const Extent& half = halves[rank];
      MiniArray& t = *arrays[size_t(rank)];
      t.fill(grid, step, 0);
      if (step == 1) {
        EXPECT_EQ(gxy_grid(sim, "grid", 0, GXY_OF_POINTS, grid.points.data(), half.first.data(),
                           half.points.data(), &grid.origin[0], &grid.spacing[0]),
                  GXY_TAKEN);
        EXPECT_EQ(gxy_field(sim, "grid", 0, "t", GXY_OF_POINTS, t.array()), GXY_TAKEN);
      }
      EXPECT_EQ(
          gxy_points(sim, "atoms", 1, {atoms + 3 * rank, GXY_FLOAT32, 3, {12, 0, 0}, 0, 0}, {}, nullptr),
          GXY_TAKEN);
    };
    mesh.change = [](std::vector<RankMesh>& ranks) {  // inside the grid, so that a file can share its domain
      for (RankMesh& m : ranks)
        for (auto& p : m.points) p = {0.4 * p[0] - 0.5, 0.3 * p[1] + 0.7, p[2] + 3, 0};
    };
    run(mesh, [&] { return mesh.published() >= 3; });
    mesh.publishLastAndClose(20);
    const auto field = datasetOn(*server, 0, "sea.t"), surface = datasetOn(*server, 0, "sea.height");
    EXPECT_EQ(field->origins, surface->origins);
    EXPECT_EQ(field->origins, datasetOn(*server, 0, "sea.atoms")->origins);
    EXPECT_EQ(*field->partitioning, *surface->partitioning);
    expectEqualsImport(*server, viewer, mesh, "sea.height");
    expectEqualsImport(*server, viewer, mesh, "sea.region");
    viewer.client->expect(
        "set 1 " + json{{"Visualization",
                         {{"operators",
                           {{{"type", "Volume"}, {"dataset", "sea.t"}},
                            {{"type", lines ? "PathLines" : "Triangles"}, {"dataset", "sea.height"}}}}}},
                        {"Camera", {{"fit", true}}}}
                       .dump());
    EXPECT_FALSE(viewer.frame().rgba.empty());
  }
}

}  // namespace
}  // namespace gxy::test
