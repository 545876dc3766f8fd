// SPDX-License-Identifier: Apache-2.0
// Simulations that publish lines and triangles: what arrives is what an import of the same step would give.
#include "tests/insitu/mini_mesh.h"

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
    viewer.client->expect("set 1 " + json{{"Visualization", {{"operators", {vis}}}}, {"Camera", {{"fit", true}}}}.dump());
    return viewer.frame().rgba;
  };
  const auto ours = picture(name), theirs = picture("file");
  EXPECT_TRUE(ours == theirs) << "the pictures of " << name << " differ";
  const auto drawn = std::count_if(ours.begin(), ours.end(), [](uint8_t v) { return v > 60 && v < 255; });
  EXPECT_GT(drawn, a.primitives > 10 ? 100 : 0);
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
  s.normals = random.oneIn(2);
  return s;
}

TEST(Cells, ThatArePublishedEqualTheImportOfTheSameStep) {
  for (uint64_t seed = 1; seed <= 15; seed++) {
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

}  // namespace
}  // namespace gxy::test
