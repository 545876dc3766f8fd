// SPDX-License-Identifier: Apache-2.0
// Unstructured volumes in the data space.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <tuple>

#include "multiserver/protocol/json.h"
#include "tests/multiserver/datasets_on_ranks.h"
#include "tests/multiserver/test_server.h"
#include "tests/support/mesh_files.h"
#include "tests/support/meshes.h"
#include "tests/support/mixed_meshes.h"

namespace gxy::test {
namespace {

using nlohmann::json;

MeshPiece cubeWithValues() {
  return cubeOfTets(
      4, [](const glm::dvec3& p) { return 0.02 * glm::dvec3(p.y, p.z, p.x); },
      [](const glm::dvec3& p) { return p.x + p.y + p.z; });
}

/// A server with cube.vtu, and the same as pieces in cube.pvtu, of which the second has one cell of the first, too.
class MeshServer : public TestServer {
 public:
  explicit MeshServer(int ranks, int64_t tenantMemory = 0) : TestServer(setup(ranks, tenantMemory)) {
    const MeshPiece mesh = cubeWithValues();
    write("cube.vtu", gridOf(mesh, 0, 384).vtu());
    write("a.vtu", gridOf(mesh, 0, 201).vtu());
    write("b.vtu", gridOf(mesh, 200, 384).vtu());
    write("cube.pvtu", pvtu({"a.vtu", "b.vtu"}, "value"));
    client = TestServer::client();
    for (const char* module : {"data", "analysis"}) client->expect(std::string("load ") + module);
  }

  void write(const std::string& name, const std::string& text) {
    std::ofstream(folder() / name, std::ios::binary) << text;
  }

  static std::string import(const std::string& name, const std::string& file, const std::string& more = "") {
    return R"(import {"Datasets": [{"name": ")" + name + R"(", "filename": ")" + file +
           R"(", "type": "Volume")" + more + "}]}";
  }

  void expectError(const std::string& statement, const std::string& part) {
    const Reply reply = client->request(statement);
    EXPECT_FALSE(reply.ok) << statement;
    EXPECT_NE(reply.error.find(part), std::string::npos) << statement << ": " << reply.error;
  }

  void expectNoMemory(int ranks) {
    for (int rank = 0; rank < ranks; rank++) EXPECT_EQ(serverRank(rank).ledger.total("user"), 0) << rank;
  }

  std::unique_ptr<Client> client;

 private:
  static ServerSetup setup(int ranks, int64_t tenantMemory) {
    ServerSetup setup;
    setup.ranks = ranks;
    setup.modules = GALAXY_MODULES;
    if (tenantMemory > 0) setup.serverRank.tenantMemory = tenantMemory;
    return setup;
  }
};

TEST(MeshData, AFileOfTetrahedraIsAVolumeOnAnyNumberOfRanks) {
  json expected;
  for (const int ranks : {1, 3}) {
    MeshServer server(ranks);
    const json reply = server.client->expect(MeshServer::import("m", "cube.vtu"));
    EXPECT_FALSE(reply.contains("warnings") && !reply.at("warnings").empty()) << reply;
    EXPECT_EQ(server.client->expect("list").at("datasets").at(0).at("type"), "Volume");
    json info = server.client->expect("info m").at("datasets").at(0);
    EXPECT_EQ(info.at("mesh"), (json{{"cells", 384}, {"tetrahedra", 384}, {"points", 125}}));
    EXPECT_EQ(info.at("components"), 1);
    EXPECT_EQ(info.at("partitions"), ranks);
    EXPECT_GT(info.at("bytes").get<int64_t>(), 384 * 32);
    if (expected.is_null()) expected = info;
    for (const char* key : {"range", "box", "mesh"}) EXPECT_EQ(info.at(key), expected.at(key)) << key;
    int64_t bytes = 0;
    for (int rank = 0; rank < ranks; rank++) {
      const auto dataset = datasetOn(server, rank, "m");
      ASSERT_TRUE(dataset->mesh);
      EXPECT_FALSE(dataset->volume || dataset->geometry);
      EXPECT_EQ(dataset->bytes, bytesOf(*dataset->mesh));
      EXPECT_EQ(server.serverRank(rank).ledger.total("user"), dataset->bytes);
      for (const auto& line : server.serverRank(rank).ledger.snapshot()) {
        if (line.tenant == "user") {
          EXPECT_EQ(line.purpose, "volume");
        }
      }
      bytes += dataset->bytes;
    }
    EXPECT_EQ(info.at("bytes"), bytes);
    server.client->expect("drop m");
    server.expectNoMemory(ranks);
  }
}

TEST(MeshData, ListsOfPiecesAndOneFileBecomeTheSame) {
  MeshServer server(3);
  server.client->expect(MeshServer::import("one", "cube.vtu"));
  const json warnings = server.client->expect(MeshServer::import("list", "cube.pvtu")).at("warnings");
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings.at(0).get<std::string>().find("1 cell left out: another cell has the same points"),
            std::string::npos)
      << warnings;
  EXPECT_EQ(server.client->expect("info list").at("datasets").at(0).at("mesh").at("repeated cells"), 1);
  for (int rank = 0; rank < 3; rank++) {
    const auto one = datasetOn(server, rank, "one"), list = datasetOn(server, rank, "list");
    ASSERT_EQ(one->mesh->blocks.size(), list->mesh->blocks.size());
    for (const auto& [partition, block] : one->mesh->blocks) {
      const MeshBlock& other = list->mesh->blocks.at(partition);
      EXPECT_TRUE(block.points == other.points && block.values == other.values &&
                  block.cells.points == other.cells.points);
    }
  }
}

TEST(MeshData, MeshesAreCutAsWhatTheyAreImportedWith) {
  MeshServer server(2);
  server.client->expect(
      R"(import {"Datasets": [{"name": "ball", "filename": "ball.vol", "type": "Volume"},
         {"name": "m", "filename": "cube.vtu", "type": "Volume", "array": "value"}]})");
  for (int rank = 0; rank < 2; rank++)
    EXPECT_EQ(datasetOn(server, rank, "m")->partitioning, datasetOn(server, rank, "ball")->partitioning);
  server.client->expect(MeshServer::import("m", "cube.pvtu"));
  EXPECT_EQ(server.client->expect("info m").at("datasets").at(0).at("generation"), 2);
}

TEST(MeshData, CellsOfAllTypesAreCountedByType) {
  const MeshPiece mesh = cubeOfMixedCells(
      3, [](const glm::dvec3&) { return glm::dvec3(0); }, [](const glm::dvec3& p) { return p.x; });
  for (const int ranks : {1, 3}) {
    MeshServer server(ranks);
    server.write("all.vtu", gridOf(mesh, 0, mesh.cells.size()).vtu());
    server.client->expect(MeshServer::import("m", "all.vtu"));
    const json info = server.client->expect("info m");
    json expected{{"cells", mesh.cells.size()}, {"points", mesh.points.size()}};
    for (const CellType type : kAllCellTypes) expected[pluralOf(type)] = mesh.cells.size(type);
    EXPECT_EQ(info.at("datasets").at(0).at("mesh"), expected);
    EXPECT_NE(info.at("text").get<std::string>().find("\"hexahedra\":" +
                                                      std::to_string(mesh.cells.size(CellType::Hexahedron))),
              std::string::npos)
        << info.at("text");
  }
}

/// A grid of 3 x 3 x 3 points from x = `from` on.
std::string curvedGrid(int from) {
  std::string points, values;
  for (int k = 0; k < 3; k++)
    for (int j = 0; j < 3; j++)
      for (int i = from; i < from + 3; i++) {
        points += std::to_string(i + 0.25 * j * k) + " " + std::to_string(j + 0.125 * i) + " " +
                  std::to_string(k) + " ";
        values += std::to_string(i + j + k) + " ";
      }
  const std::string extent =
      "Extent=\"" + std::to_string(from) + " " + std::to_string(from + 2) + " 0 2 0 2\">";
  return "<VTKFile type=\"StructuredGrid\"><StructuredGrid Whole" + extent + "<Piece " + extent +
         "<PointData><DataArray type=\"Float32\" Name=\"heat\" format=\"ascii\">" + values +
         "</DataArray></PointData><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" "
         "format=\"ascii\">" +
         points + "</DataArray></Points></Piece></StructuredGrid></VTKFile>";
}

TEST(MeshData, CurvilinearGridsAndListsOfThemAreVolumes) {
  MeshServer server(2);
  server.write("left.vts", curvedGrid(0));
  server.write("right.vts", curvedGrid(2));
  server.write("both.pvts",
               "<VTKFile type=\"PStructuredGrid\"><PStructuredGrid WholeExtent=\"0 4 0 2 0 2\">"
               "<Piece Extent=\"0 2 0 2 0 2\" Source=\"left.vts\"/><Piece Extent=\"2 4 0 2 0 2\" "
               "Source=\"right.vts\"/></PStructuredGrid></VTKFile>");
  server.write("outside.pvts",
               "<VTKFile type=\"PStructuredGrid\"><PStructuredGrid WholeExtent=\"0 2 0 2 0 2\">"
               "<Piece Extent=\"0 2 0 2 0 2\" Source=\"/etc/left.vts\"/></PStructuredGrid></VTKFile>");
  server.client->expect(MeshServer::import("both", "both.pvts"));
  EXPECT_EQ(server.client->expect("info both").at("datasets").at(0).at("mesh"),
            (json{{"cells", 16}, {"hexahedra", 16}, {"points", 45}, {"merged points", 9}}));
  server.expectError(MeshServer::import("m", "outside.pvts"), "/etc/left.vts");
  server.client->expect("drop both");
  server.expectNoMemory(2);
}

bool areSame(const std::vector<float>& a, const std::vector<float>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); });
}

/// Two pieces that have cells in common, of all types, with values of points and cells, some of which are none.
void writeOverlapping(MeshServer& server) {
  const MeshPiece mesh = cubeOfMixedCells(
      3, [](const glm::dvec3& p) { return 0.02 * glm::dvec3(p.y, p.z, p.x); },
      [](const glm::dvec3& p) { return p.x * p.y + p.z; });
  const size_t n = mesh.cells.size();
  for (const auto& [name, first, last] : {std::tuple("l.vtu", size_t(0), n / 2 + 9), {"r.vtu", n / 2, n}}) {
    GridFile grid = gridOf(mesh, first, last);
    GridFile::Array heat{"heat", "Float64", 1, {}}, pull{"pull", "Float32", 2, {}};
    for (const glm::dvec3& p : grid.points)
      heat.values.push_back(p.x > 0.9 && p.y > 0.9 ? double(NAN) : 101325 + 0.01 * p.x * p.y);
    for (size_t c = first; c < last; c++)
      pull.values.insert(pull.values.end(),
                         {c % 11 == 3 ? double(NAN) : double(c % 7), 0.25 * double(c % 5)});
    grid.pointArrays.push_back(heat);
    grid.cellArrays.push_back(pull);
    server.write(name, grid.vtu());
  }
  server.write("lr.pvtu", pvtu({"l.vtu", "r.vtu"}, ""));
}

TEST(MeshData, AnExportedMeshIsTheSameWhenItIsImported) {
  std::map<std::string, std::string> files;  // by array
  for (const int ranks : {1, 3}) {
    MeshServer server(ranks);
    writeOverlapping(server);
    for (const std::string array : {"value", "heat", "pull"}) {
      SCOPED_TRACE(array + " on " + std::to_string(ranks));
      server.client->expect(MeshServer::import("m", "lr.pvtu", R"(, "array": ")" + array + "\""));
      const json reply = server.client->expect("export m out.vtu");
      std::ifstream in(server.folder() / "out.vtu", std::ios::binary);
      const std::string text((std::istreambuf_iterator<char>(in)), {});
      EXPECT_EQ(reply.at("bytes"), text.size());
      EXPECT_EQ(files.try_emplace(array, text).first->second, text) << "on other ranks it is another file";
      EXPECT_NE(text.find("Name=\"" + array + "\""), std::string::npos);
      std::string import = MeshServer::import("again", "out.vtu");
      server.client->expect("import like m" + import.substr(std::string("import").size()));
      for (int rank = 0; rank < ranks; rank++) {
        const Mesh &one = *datasetOn(server, rank, "m")->mesh,
                   &again = *datasetOn(server, rank, "again")->mesh;
        EXPECT_EQ(again.ofCells, array == "pull");
        EXPECT_EQ(std::tuple(one.components, one.shift, one.scale, one.ofCells),
                  std::tuple(again.components, again.shift, again.scale, again.ofCells));
        EXPECT_EQ(one.box, again.box);
        EXPECT_EQ(one.report.cells, again.report.cells);
        EXPECT_EQ(one.report.points, again.report.points);
        EXPECT_EQ(again.report.repeatedCells + again.report.mergedPoints + again.report.invertedCells, 0u);
        EXPECT_GT(one.report.repeatedCells, 0u);
        EXPECT_EQ(one.report.noDataCells + one.report.noDataPoints,
                  again.report.noDataCells + again.report.noDataPoints);
        ASSERT_EQ(one.blocks.size(), again.blocks.size());
        for (const auto& [partition, block] : one.blocks) {
          const MeshBlock& other = again.blocks.at(partition);
          EXPECT_TRUE(block.points == other.points && block.cells.points == other.cells.points);
          EXPECT_TRUE(block.neighbours == other.neighbours && block.shell == other.shell);
          EXPECT_TRUE(areSame(block.values, other.values) && areSame(block.cellValues, other.cellValues));
        }
      }
      server.client->expect("drop m");
      server.client->expect("drop again");
      server.expectNoMemory(ranks);
    }
  }
}

TEST(MeshData, DerivedFieldsShareTheMeshAndAreDataLikeOthers) {
  for (const int ranks : {1, 3}) {
    MeshServer server(ranks);
    server.client->expect(MeshServer::import("m", "cube.vtu"));
    const json told = server.client->expect(
        R"json(make {"name": "d", "filter": "Derive", "inputs": {"f": "m"}, "expression": "2 * f - max(f)"})json");
    EXPECT_EQ(told.at("results").at(0).at("no data"), 0) << told;
    const json info = server.client->expect("info d").at("datasets").at(0);
    EXPECT_EQ(info.at("mesh"), (json{{"cells", 384}, {"tetrahedra", 384}, {"points", 125}}));
    const auto ofM = datasetOn(server, 0, "m")->range();
    EXPECT_NEAR(info.at("range").at(1).get<double>(), ofM.max, 1e-6);
    for (int rank = 0; rank < ranks; rank++)
      for (const auto& [partition, block] : datasetOn(server, rank, "d")->mesh->blocks)
        EXPECT_TRUE(block.points.sharesWith(datasetOn(server, rank, "m")->mesh->blocks.at(partition).points));
    server.client->expect("drop m");
    server.client->expect("export d d.vtu");
    server.client->expect("drop d");
    server.expectNoMemory(ranks);
  }
}

TEST(MeshData, WhatTakesNoMeshesSaysSo) {
  MeshServer server(2);
  server.client->expect(MeshServer::import("m", "cube.vtu"));
  server.client->expect(importBall("ball"));
  const std::string text = "\"m\" is an unstructured volume, which is not supported here yet";
  for (const char* make :
       {R"({"filter": "Statistics", "inputs": {"field": "ball", "f": "m"}, "where": "f > 1"})",
        R"({"name": "x", "filter": "Resample", "inputs": {"field": "ball", "like": "m"}})",
        R"({"name": "x", "filter": "DensitySampler", "inputs": {"field": "m"}, "count": 9})"})
    server.expectError("make " + std::string(make), text);
  server.expectError(
      R"(make {"name": "x", "filter": "Derive", "inputs": {"f": "m", "b": "ball"}, "expression": "f * b"})",
      "`f` is an unstructured volume, and another input is on a grid");
  server.expectError("export m m.vti",
                     "export: file \"m.vti\" for dataset \"m\", which is an unstructured Volume: expected a "
                     "name that ends with one of .vtu");
  server.expectError("export m m.vtp", "expected a name that ends with one of .vti, .vtu");
  server.expectError("export ball ball.vtu",
                     "which is a Volume on a uniform grid: expected a name that ends "
                     "with one of .vti");
  EXPECT_EQ(server.client->expect("list").at("datasets").size(), 2u);
  server.client->expect("drop m");
  server.client->expect("drop ball");
  server.expectNoMemory(2);
}

TEST(MeshData, ImportsThatFailLeaveNothing) {
  MeshServer server(2);
  GridFile grid = gridOf(cubeWithValues(), 0, 20);
  grid.cells.push_back({15, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}});
  server.write("prism.vtu", grid.vtu());
  grid.cells = {{5, {0, 1, 2}}};
  server.write("flat.vtu", grid.vtu());
  server.write("lattice.vts", "<VTKFile type=\"StructuredGrid\"></VTKFile>");
  server.write("surface.vtp", "<VTKFile type=\"PolyData\"></VTKFile>");
  server.expectError(MeshServer::import("m", "prism.vtu"), "pentagonal prisms (1); expected tetrahedra, ");
  server.expectError(MeshServer::import("m", "flat.vtu"), "it has no cells with a volume");
  server.expectError(MeshServer::import("m", "cube.vtu", R"(, "array": "none")"),
                     "no array 'none' of points or cells");
  server.expectError(MeshServer::import("m", "lattice.vts"), "element <StructuredGrid> is missing");
  server.expectError(MeshServer::import("m", "surface.vtp"), "this kind of file cannot be read as a volume");
  EXPECT_TRUE(server.client->expect("list").at("datasets").empty());
  server.expectNoMemory(2);

  MeshServer small(2, 20000);  // the file's text alone takes more
  small.expectError(MeshServer::import("m", "cube.vtu"), "memory");
  small.expectNoMemory(2);
}

}  // namespace
}  // namespace gxy::test
