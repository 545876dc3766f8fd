// SPDX-License-Identifier: Apache-2.0
// Verb `fetch`: the client gets the arrays of a dataset, to the bit, and a client that goes away disturbs nobody.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <future>
#include <map>
#include <mutex>

#include "core/data/mesh_defects.h"
#include "core/data/mesh_kinds.h"
#include "core/io/write_geometry.h"
#include "core/io/write_volume.h"
#include "tests/multiserver/datasets_on_ranks.h"
#include "tests/support/mesh_files.h"
#include "tests/support/mixed_meshes.h"

namespace gxy::test {
namespace {

using FetchJson = nlohmann::json;

/// Puts the parts of arrays together, by name.
class FetchedArrays {
 public:
  void take(const FetchJson& header, std::span<const std::byte> content) {
    const std::lock_guard lock(mutex_);
    const std::string name = header.contains("field") ? "field " + header["field"].get<std::string>()
                                                      : header["structure"].get<std::string>();
    auto& [about, bytes] = arrays_[name];
    const size_t tuple = content.size() / std::max<size_t>(header["count"].get<size_t>(), 1);
    EXPECT_EQ(content.size(), tuple * header["count"].get<size_t>()) << name;
    EXPECT_EQ(bytes.size(), tuple * header["first"].get<size_t>()) << name << ": parts come in order";
    bytes.insert(bytes.end(), content.begin(), content.end());
    about = header;
    parts_++;
  }
  void clear() { arrays_.clear(); }
  size_t count() const { return arrays_.size(); }
  int parts() const { return parts_; }
  bool has(const std::string& name) const { return arrays_.count(name) > 0; }
  template <class T>
  std::vector<T> of(const std::string& name, const std::string& type, int components) const {
    const auto& [about, bytes] = arrays_.at(name);
    EXPECT_EQ(about.at("type"), type);
    EXPECT_EQ(about.at("components"), components);
    std::vector<T> values(bytes.size() / sizeof(T));
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
    EXPECT_EQ(about.at("of"), bytes.size() / sizeof(T) / (sizeof(T) > 8 ? 1 : size_t(components)));
    return values;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::pair<FetchJson, std::vector<std::byte>>> arrays_;
  int parts_ = 0;
};

struct FetchServer : TestServer {
  static ServerSetup setup(int ranks, int64_t memory) {
    ServerSetup setup;
    setup.ranks = ranks;
    setup.modules = GALAXY_MODULES;
    if (memory > 0) setup.serverRank.tenantMemory = memory;
    return setup;
  }
  explicit FetchServer(int ranks, int64_t memory = 0) : TestServer(setup(ranks, memory)) {
    Client::Options options = TestServer::options();
    options.onFile = [this](uint32_t, const FetchJson& header, std::span<const std::byte> content) {
      arrays.take(header, content);
    };
    client = std::make_unique<Client>(options);
    client->expect("load data");
  }
  std::string import(const std::string& name, const std::string& file, const std::string& type) {
    return "import new " +
           FetchJson{{"Datasets", {{{"name", name}, {"filename", file}, {"type", type}}}}}.dump();
  }
  std::string path(const std::string& name) const { return (folder().path() / name).string(); }

  FetchedArrays arrays;
  std::unique_ptr<Client> client;
};

TEST(Fetch, AVolumeComesAsItIsStored) {
  for (const bool rim : {false, true})
    for (const int ranks : {1, 3}) {
      FetchServer server(ranks);
      Grid grid;
      const Index3 n{200, 110, 150};  // 20 MB in 3 parts or more
      grid.points = n;
      grid.origin = {-1, 2, 0.1};
      grid.spacing = {0.5, 0.25, 0.3};
      grid.rim = rim;
      if (rim) grid.points = {n[0] + 2, n[1] + 2, n[2] + 2};
      std::vector<int16_t> values(size_t(n[0] * n[1] * n[2] * 3));
      for (size_t i = 0; i < values.size(); i++) values[i] = int16_t(i * 7919 % 60013);
      VolumeWriter(server.path("a.vti"), grid, {{"field of it", ScalarType::Int16, 3, {}, rim}})
          .write(0, 0, std::as_bytes(std::span(values)));
      server.client->expect(server.import("a", "a.vti", "Volume"));
      const FetchJson reply = server.client->expect("fetch a");
      EXPECT_EQ(server.arrays.count(), 1u);
      EXPECT_GE(server.arrays.parts(), 3);
      EXPECT_EQ(server.arrays.of<int16_t>("field field of it", "int16", 3), values);
      EXPECT_EQ(reply["type"], "Volume");
      EXPECT_EQ(reply["dimensions"], FetchJson({200, 110, 150}));
      EXPECT_EQ(reply["centers of cells"], rim);
      EXPECT_EQ(reply["bytes"], values.size() * sizeof(int16_t));
      const glm::dvec3 first = grid.origin + (rim ? grid.spacing : glm::dvec3(0));
      EXPECT_EQ(reply["origin"], FetchJson({first.x, first.y, first.z}));
      EXPECT_EQ(reply["spacing"], FetchJson({0.5, 0.25, 0.3}));
    }
}

TEST(Fetch, AnUnstructuredVolumeComesWithEachCellOnce) {
  const MeshPiece mesh = cubeOfMixedCells(
      4, [](const glm::dvec3& p) { return 0.02 * glm::dvec3(p.y, p.z, p.x); },
      [](const glm::dvec3& p) { return p.x + p.y * p.z; });
  const auto placesOf = [](const auto& points, const auto& corners) {
    std::vector<std::array<double, 3>> places;
    for (const auto p : corners) places.push_back({points[p].x, points[p].y, points[p].z});
    std::sort(places.begin(), places.end());
    return places;
  };
  std::map<std::vector<std::array<double, 3>>, double> loads;
  GridFile grid = gridOf(mesh, 0, mesh.cells.size());
  grid.cellArrays.push_back({"load", "Float64", 1, {}});
  for (const auto& [type, corners] : grid.cells) {
    loads[placesOf(grid.points, corners)] = double(grid.cellArrays[0].values.size());
    grid.cellArrays[0].values.push_back(double(grid.cellArrays[0].values.size()));
  }
  for (const int ranks : {1, 3}) {
    FetchServer server(ranks);
    std::ofstream(server.path("all.vtu"), std::ios::binary) << grid.vtu();
    for (const std::string array : {"value", "load"}) {
      server.client->expect(
          "import new " +
          FetchJson{
              {"Datasets", {{{"name", "m"}, {"filename", "all.vtu"}, {"type", "Volume"}, {"array", array}}}}}
              .dump());
      server.arrays.clear();
      const FetchJson reply = server.client->expect("fetch m");
      EXPECT_EQ(reply.at("cells"), mesh.cells.size());
      EXPECT_EQ(reply.at("points"), mesh.points.size());
      EXPECT_EQ(reply.at("values"), array == "load" ? "cells" : "points");
      EXPECT_EQ(server.arrays.count(), 5u);
      const auto points = server.arrays.of<glm::dvec3>("points", "float64", 3);
      const auto types = server.arrays.of<uint8_t>("types", "uint8", 1);
      const auto offsets = server.arrays.of<uint64_t>("offsets", "uint64", 1);
      const auto corners = server.arrays.of<uint32_t>("connectivity", "uint32", 1);
      const auto values = server.arrays.of<float>("field " + array, "float32", 1);
      ASSERT_EQ(points.size(), mesh.points.size());
      ASSERT_EQ(types.size(), mesh.cells.size());
      ASSERT_EQ(offsets.size(), types.size() + 1);
      ASSERT_EQ(offsets.back(), corners.size());
      ASSERT_EQ(values.size(), array == "load" ? types.size() : points.size());
      for (size_t p = 0; p < points.size() && array == "value"; p++) {
        const auto found = std::find(grid.points.begin(), grid.points.end(), points[p]);
        ASSERT_NE(found, grid.points.end());
        EXPECT_EQ(double(values[p]), grid.pointArrays[0].values[size_t(found - grid.points.begin())]);
      }
      std::map<std::vector<std::array<double, 3>>, int> times;
      for (size_t c = 0; c < types.size(); c++) {
        const auto own = std::span(corners).subspan(offsets[c], offsets[c + 1] - offsets[c]);
        const auto places = placesOf(points, own);
        EXPECT_EQ(times[places]++, 0);
        ASSERT_EQ(loads.count(places), 1u);
        EXPECT_EQ(double(array == "load" ? values[c] : float(loads.at(places))), loads.at(places));
        const CellType type = *meshCellOf(types[c]);
        ASSERT_EQ(own.size(), shapeOf(type).points);
        EXPECT_FALSE(isInverted(points, type, own));
      }
      EXPECT_EQ(times.size(), loads.size());
      server.client->expect("drop m");
    }
    for (int rank = 0; rank < ranks; rank++) EXPECT_EQ(server.serverRank(rank).ledger.total("user"), 0);
  }
}

TEST(Fetch, GeometryComesByAscendingIds) {
  GeometryBlock triangles;
  for (int i = 0; i < 50; i++) {
    triangles.points.push_back({0.1 * i, i * i % 7 / 3.0, i % 5});
    triangles.values.push_back(float(i) / 3);
  }
  for (uint32_t i = 0; i + 2 < 50; i++) {
    triangles.triangles.push_back({i, i + 1, i + 2});
    triangles.ids.push_back(i);
  }
  for (const int ranks : {1, 3}) {
    FetchServer server(ranks);
    writeGeometry(server.path("in.vtp"), triangles, GeometryKind::Triangles, "how much");
    server.client->expect(
        R"(import new {"Datasets": [{"name": "in", "filename": "in.vtp", "type": "Triangles", "array": "how much"}]})");
    const FetchJson reply = server.client->expect("fetch in");
    const GeometryBlock all = gathered(server, "in");
    EXPECT_EQ(reply["primitives"], all.ids.size());
    EXPECT_EQ(server.arrays.count(), 4u);
    EXPECT_EQ(server.arrays.of<glm::dvec3>("points", "float64", 3), all.points);
    EXPECT_EQ((server.arrays.of<std::array<uint32_t, 3>>("triangles", "uint32", 3)), all.triangles);
    EXPECT_EQ(server.arrays.of<uint64_t>("ids", "uint64", 1), all.ids);
    EXPECT_EQ(server.arrays.of<float>("field how much", "float32", 1), all.values);
  }
}

TEST(Fetch, AllFieldsOfPointsCome) {
  GeometryBlock points;
  points.fields = {{"velocity", 3, {}}, {"age", 1, {}}};
  for (int i = 0; i < 20; i++) {
    points.points.push_back({i, 0.5 * i, 1});
    points.values.push_back(float(2 * i));
    points.fields[0].values.insert(points.fields[0].values.end(), {float(i), 1, 2});
    points.fields[1].values.push_back(float(-i));
    points.ids.push_back(uint64_t(i));
  }
  FetchServer server(3);
  writeGeometry(server.path("in.vtp"), points, GeometryKind::Particles, "how much");
  server.client->expect(
      R"(import new {"Datasets": [{"name": "in", "filename": "in.vtp", "type": "Particles", "array": "how much",
         "fields": ["velocity", "age", "how much"]}]})");
  const FetchJson reply = server.client->expect("fetch in");
  EXPECT_EQ(server.arrays.count(), 5u) << "what is shown comes once";
  EXPECT_EQ(server.arrays.of<float>("field how much", "float32", 1), points.values);
  EXPECT_EQ(server.arrays.of<float>("field velocity", "float32", 3), points.fields[0].values);
  EXPECT_EQ(server.arrays.of<float>("field age", "float32", 1), points.fields[1].values);
}

TEST(Fetch, ErrorsAreOneAnswerAndLeaveNothing) {
  FetchServer server(2, 300 << 10);
  writeBall(server.folder().path().string(), "ball", 32);  // 128 KiB, of which a rank has half with its rim
  server.client->expect(importBall("ball"));
  const auto error = [&](const std::string& statement) { return server.client->request(statement).error; };
  EXPECT_NE(error("fetch nothing").find("nothing"), std::string::npos);
  EXPECT_NE(error("fetch").find("fetch NAME"), std::string::npos);
  EXPECT_NE(error("fetch ball").find("memory"), std::string::npos);
  EXPECT_EQ(server.arrays.parts(), 0);
  server.client->expect("drop ball");
  for (int rank = 0; rank < 2; rank++) EXPECT_EQ(server.serverRank(rank).ledger.total("user"), 0);
}

TEST(Fetch, AClientThatReadsNothingIsLeftWithoutHarm) {
  FetchServer server(2);
  writeBall(server.folder().path().string(), "large", 320);  // 131 MB: more than waits to be sent
  server.client->expect(importBall("large", "large.vol"));
  std::promise<void> stopped, goOn;
  std::shared_future<void> mayGoOn = goOn.get_future().share();
  Client::Options options = server.TestServer::options();
  std::atomic<bool> first = true;
  options.onFile = [&](uint32_t, const FetchJson&, std::span<const std::byte>) {
    if (first.exchange(false)) stopped.set_value();
    mayGoOn.wait();  // its socket fills up
  };
  Client slow(options);
  slow.expect("load data");
  std::promise<Reply> answered;
  const uint32_t id = slow.send("fetch large", [&](const Reply& r) { answered.set_value(r); });
  stopped.get_future().wait();
  writeBall(server.folder().path().string(), "small", 8);
  server.client->expect(importBall("small", "small.vol"));
  EXPECT_EQ(server.client->expect("fetch small")["bytes"], 8 * 8 * 8 * 4);  // others are served
  slow.send("cancel " + std::to_string(id), [](const Reply&) {});
  goOn.set_value();
  const Reply reply = answered.get_future().get();
  EXPECT_FALSE(reply.ok);
  EXPECT_NE(reply.error.find("cancelled"), std::string::npos) << reply.error;
  server.client->expect("drop large");
}

}  // namespace
}  // namespace gxy::test
