// SPDX-License-Identifier: Apache-2.0
// Verb `export`: what a file has is what the dataset has, and a file is complete or not there.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/io/write_geometry.h"
#include "core/io/write_volume.h"
#include "tests/multiserver/datasets_on_ranks.h"

namespace gxy::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct ExportServer : TestServer {
  static ServerSetup setup(int ranks, int64_t memory) {
    ServerSetup setup;
    setup.ranks = ranks;
    setup.modules = GALAXY_MODULES;
    if (memory > 0) setup.serverRank.tenantMemory = memory;
    return setup;
  }
  explicit ExportServer(int ranks, int64_t memory = 0)
      : TestServer(setup(ranks, memory)), client(TestServer::client()) {
    client->expect("load data");
  }

  std::string import(const std::string& name, const std::string& file, const std::string& type) {
    return "import new " + json{{"Datasets", {{{"name", name}, {"filename", file}, {"type", type}}}}}.dump();
  }
  /// Imports the file that a dataset is exported to, and compares the two.
  void expectSameVolume(const std::string& name) {
    SCOPED_TRACE(name);
    client->expect("export " + name + " copy.vti");
    client->expect(import("copy", "copy.vti", "Volume"));
    for (int rank = 0; rank < serverRank().ranks(); rank++)
      expectSame(*datasetOn(*this, rank, "copy")->volume, *datasetOn(*this, rank, name)->volume);
    EXPECT_EQ(datasetOn(*this, 0, "copy")->volume->name, "copy:field of it");
  }
  std::string path(const std::string& name) const { return (folder().path() / name).string(); }
  int files() const {
    return int(std::distance(fs::directory_iterator(folder().path()), fs::directory_iterator()));
  }

  std::unique_ptr<Client> client;
};

template <class T>
void writeField(const std::string& path, const Grid& grid, ScalarType type, int components) {
  Index3 n = grid.points;
  if (grid.rim)
    for (int64_t& points : n) points -= 2;
  std::vector<T> values(size_t(n[0] * n[1] * n[2] * components));
  for (size_t i = 0; i < values.size(); i++) values[i] = T(double(i * 7919 % 1009) / 3 - 11);
  VolumeWriter(path, grid, {{"field of it", type, components, {}, grid.rim}})
      .write(0, 0, std::as_bytes(std::span(values)));
}

TEST(Export, FilesHaveTheValuesOfTheVolume) {
  for (const int ranks : {1, 3}) {
    ExportServer server(ranks);
    Grid grid;
    grid.points = {9, 12, 21};
    grid.origin = {-1, 2, 0.1};
    grid.spacing = {0.5, 0.25, 0.3};
    writeField<float>(server.path("floats.vti"), grid, ScalarType::Float32, 1);
    writeField<int16_t>(server.path("shorts.vti"), grid, ScalarType::Int16, 3);
    writeField<double>(server.path("doubles.vti"), grid, ScalarType::Float64, 2);
    grid.rim = true;
    writeField<float>(server.path("cells.vti"), grid, ScalarType::Float32, 1);
    for (const std::string name : {"floats", "shorts", "doubles", "cells"}) {
      server.client->expect(server.import(name, name + ".vti", "Volume"));
      server.expectSameVolume(name);
    }
  }
}

TEST(Export, FilesHaveThePrimitivesAndTheirValues) {
  GeometryBlock points, lines, triangles;
  for (int i = 0; i < 50; i++) {
    points.points.push_back({0.1 * i, i * i % 7 / 3.0, i % 5});
    points.values.push_back(float(i) / 3);
    points.ids.push_back(uint64_t(i));
  }
  lines.points = points.points;
  lines.values = points.values;
  triangles = lines;
  triangles.values.clear();
  for (const glm::dvec3& p : triangles.points) triangles.colors.push_back({float(p.y) / 4, 0.1F, 1});
  for (uint32_t i = 0; i + 1 < 50; i++)
    if (i % 10 != 9) {
      lines.segments.push_back({i, i + 1});
      lines.neighbours.push_back({i % 10 == 0 ? i : i - 1, i % 10 == 8 ? i + 1 : i + 2});
      lines.ids.push_back(lines.ids.size());
    }
  for (uint32_t i = 0; i + 2 < 50; i++) {
    triangles.triangles.push_back({i, i + 1, i + 2});
    triangles.ids.push_back(i);
  }
  ExportServer server(3);
  const auto compare = [&](const GeometryBlock& block, GeometryKind kind, const std::string& type,
                           const std::vector<std::string>& extensions) {
    writeGeometry(server.path("in.vtp"), block, kind, "how much");
    server.client->expect(server.import("in", "in.vtp", type));
    for (const std::string& extension : extensions) {
      SCOPED_TRACE(type + " " + extension);
      server.client->expect("export in out" + extension);
      server.client->expect(server.import("out", "out" + extension, type));
      EXPECT_EQ(gathered(server, "in"), gathered(server, "out"));
      EXPECT_EQ(datasetOn(server, 0, "in")->array, datasetOn(server, 0, "out")->array);
    }
    server.client->expect("drop in");
  };
  compare(points, GeometryKind::Particles, "Particles", {".vtp", ".vtu", ".csv"});
  compare(lines, GeometryKind::PathLines, "PathLines", {".vtp", ".vtu"});
  compare(triangles, GeometryKind::Triangles, "Triangles", {".vtp", ".vtu"});
}

TEST(Export, FilesHaveAllFieldsOfPoints) {
  GeometryBlock points;
  points.fields = {{"velocity", 3, {}}, {"age", 1, {}}};
  for (int i = 0; i < 40; i++) {
    points.points.push_back({0.1 * i, i * i % 7 / 3.0, i % 5});
    points.values.push_back(float(i) / 3);
    points.fields[0].values.insert(points.fields[0].values.end(), {float(i), -1, 0.5F});
    points.fields[1].values.push_back(float(-i));
    points.ids.push_back(uint64_t(i));
  }
  ExportServer server(3);
  writeGeometry(server.path("in.vtp"), points, GeometryKind::Particles, "how much");
  const auto import = [&](const std::string& name, const std::string& file) {
    const json entry{{"name", name},
                     {"filename", file},
                     {"type", "Particles"},
                     {"array", "how much"},
                     {"fields", {"velocity", "age"}}};
    server.client->expect("import new " + json{{"Datasets", {entry}}}.dump());
  };
  import("in", "in.vtp");
  EXPECT_EQ(gathered(server, "in"), points);
  const json info = server.client->expect("info in").at("datasets").at(0);
  EXPECT_EQ(info.at("fields").at(1), (json{{"name", "age"}, {"components", 1}, {"range", {-39.0, 0.0}}}));
  EXPECT_EQ(info.at("fields").at(0).at("components"), 3);
  for (const std::string extension : {".vtp", ".vtu", ".csv"}) {
    server.client->expect("export in out" + extension);
    import("out", "out" + extension);
    EXPECT_EQ(gathered(server, "out"), points) << extension;
  }
  const std::string error =
      server.client
          ->request(
              "import new " +
              json{{"Datasets",
                    {{{"name", "bad"}, {"filename", "in.vtp"}, {"type", "Particles"}, {"fields", "speed"}}}}}
                  .dump())
          .error;
  EXPECT_NE(error.find("no array 'speed' of points for `fields`"), std::string::npos) << error;
}

TEST(Export, WhatCannotBeWrittenIsAnErrorAndLeavesNoFile) {
  ExportServer server(2, 300 << 10);
  writeBall(server.folder().path().string(), "ball", 32);  // 128 KiB, of which a rank has half with its rim
  server.client->expect(importBall("ball"));
  const int before = server.files();
  const auto expectError = [&](const std::string& statement, const std::string& part) {
    const std::string error = server.client->request(statement).error;
    EXPECT_NE(error.find(part), std::string::npos) << statement << ": " << error;
    EXPECT_EQ(server.files(), before) << statement;
  };
  expectError("export nothing a.vti", "nothing");
  expectError(
      "export ball a.vtp",
      "file \"a.vtp\" for dataset \"ball\", which is Volume: expected a name that ends with one of .vti");
  expectError("export ball .vti", "expected a name that ends with one of .vti");
  expectError("export ball ../a.vti", "it cannot be written");
  expectError("export ball none/a.vti", "it cannot be written");
  expectError("export ball", "export NAME FILE");
  expectError("export ball a.vti", "memory");  // of the tenant
  server.client->expect("drop ball");
  for (int rank = 0; rank < 2; rank++) EXPECT_EQ(server.serverRank(rank).ledger.total("user"), 0);
}

TEST(Export, ReplacesAFileAndTellsWhatItWrote) {
  ExportServer server(2);
  server.client->expect(importBall("ball"));
  std::ofstream(server.path("a.vti")) << "what was there before";
  const json reply = server.client->expect("export ball a.vti");
  EXPECT_EQ(reply.at("file"), server.path("a.vti"));
  EXPECT_EQ(reply.at("generation"), 1);
  EXPECT_EQ(reply.at("bytes"), fs::file_size(server.path("a.vti")));
  server.client->expect(server.import("copy", "a.vti", "Volume"));
}

}  // namespace
}  // namespace gxy::test
