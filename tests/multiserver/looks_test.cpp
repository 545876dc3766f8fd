// SPDX-License-Identifier: Apache-2.0
// Module viewer: data that no state describes, and what states ask of the data.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <future>
#include <map>
#include <set>

#include "core/scene/resolve.h"
#include "core/scene/state_file.h"
#include "tests/multiserver/viewer_client.h"
#include "tests/support/mesh_files.h"
#include "tests/support/meshes.h"

namespace gxy::test {
namespace {

using nlohmann::json;

TEST(ViewerLooks, AMeshsPictureIsTheSameToTheBitForAnyNumberOfRanks) {
  const MeshPiece mesh = cubeOfTets(
      5, [](const glm::dvec3& p) { return 0.05 * glm::dvec3(p.y, p.z * p.x, p.x); },
      [](const glm::dvec3& p) { return std::sin(5 * p.x) * std::cos(4 * p.y) + p.z; });
  std::vector<uint8_t> expected;
  json scene;
  for (const int ranks : {1, 3}) {
    const auto server = serve(ranks);
    std::ofstream(server->folder() / "cube.vtu")
        << gridOf(mesh, 0, mesh.cells.size(CellType::Tetrahedron)).vtu();
    Viewer viewer(*server);
    viewer.client->expect(R"(import {"Datasets": {"name": "m", "filename": "cube.vtu", "type": "Volume"}})");
    json state = viewer.client->expect("scene m").at("state");
    EXPECT_EQ(state["Datasets"][0]["type"], "Volume");
    state.erase("Datasets");  // the server's folder
    if (scene.is_null()) scene = state;
    EXPECT_EQ(state, scene) << ranks;
    viewer.client->expect("set 1 " + state.dump());
    const Screen::Picture picture = viewer.frame();
    if (expected.empty()) expected = picture.rgba;
    EXPECT_EQ(picture.rgba, expected) << ranks;
  }
  EXPECT_GT(std::set<uint8_t>(expected.begin(), expected.end()).size(), 50u) << "there is something to see";
}

TEST(ViewerLooks, AScenesPictureIsTheSameToTheBitForAnyNumberOfRanks) {
  std::vector<uint8_t> expected;
  json scene;
  for (const int ranks : {1, 3}) {
    const auto server = serve(ranks);
    Viewer viewer(*server);
    json state = viewer.client->expect("scene ball").at("state");
    state.erase("Datasets");  // the server's folder
    if (scene.is_null()) scene = state;
    EXPECT_EQ(state, scene) << ranks;
    viewer.client->expect("set 1 " + state.dump());
    const Screen::Picture picture = viewer.frame();
    if (expected.empty()) expected = picture.rgba;
    EXPECT_EQ(picture.rgba, expected) << ranks;
  }
  EXPECT_GT(std::set<uint8_t>(expected.begin(), expected.end()).size(), 50u) << "there is something to see";
  EXPECT_EQ(scene["Visualizations"][0]["operators"][0]["data range"], "data");
  EXPECT_EQ(scene["Cameras"][0]["fit"], true);
}

TEST(ViewerLooks, AFileIsShownAsTheDatasetOfItIs) {
  const auto server = serve();
  Viewer viewer(*server);
  const json of_dataset = viewer.client->expect("scene ball").at("state");
  EXPECT_EQ(viewer.client->expect("scene ball.vol").at("state"), of_dataset) << "it is not read again";
  viewer.client->expect("drop ball");
  writeBall(server->folder().path().string(), "other", 4);
  viewer.client->expect(importBall("ball", "other.vol"));
  json of_file = viewer.client->expect("scene ball.vol").at("state");
  EXPECT_EQ(of_file["Datasets"][0]["name"], "ball-2") << "the name ball means something else now";
  of_file["Datasets"][0]["name"] = of_file["Visualizations"][0]["operators"][0]["dataset"] = "ball";
  EXPECT_EQ(of_file, of_dataset);
  EXPECT_EQ(viewer.client->expect("scene *.vol").at("state")["Datasets"][0]["filename"],
            of_dataset["Datasets"][0]["filename"]);
  for (const char* name : {"nothing", "/etc/passwd", "/etc/*", "../*"}) {
    const Reply reply = viewer.client->request("scene " + std::string(name));
    EXPECT_FALSE(reply.ok) << name;
    EXPECT_NE(reply.error.find(name), std::string::npos) << reply.error;
  }
}

TEST(ViewerLooks, WhatAScannerLeavesInAPlyIsNotShownUnlessItIsNamed) {
  const auto server = serve();
  Viewer viewer(*server);
  std::ofstream(server->folder().path() / "m.ply")
      << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
         "property float confidence\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0 0.1\n1 0 0 0.5\n0 1 0 0.9\n3 0 1 2\n";
  const auto colors = [](const json& state) {
    return state.at("Visualizations").at(0).at("operators").at(0).at("colormap").size();
  };
  const json of_file = viewer.client->expect("scene m.ply").at("state");
  EXPECT_EQ(colors(of_file), 1u);
  EXPECT_GT(colors(viewer.client->expect(R"(scene m.ply {"array": "confidence"})").at("state")), 1u);
  viewer.client->expect(R"(import {"Datasets": {"name": "m", "filename": "m.ply", "type": "Triangles"}})");
  EXPECT_EQ(viewer.client->expect("scene m").at("state"), of_file);
}

TEST(ViewerLooks, ACollectionShowsItsFirstTimeOfFilesThatMayBeRead) {
  const auto server = serve();
  Viewer viewer(*server);
  const auto write = [&](const std::string& name, const std::string& dataSets) {
    std::ofstream(server->folder().path() / name)
        << "<VTKFile type=\"Collection\"><Collection>" << dataSets << "</Collection></VTKFile>";
  };
  const auto path = [&](const char* name) {
    return (std::filesystem::canonical(server->folder().path()) / name).string();
  };
  write("run.pvd", R"(<DataSet timestep="2" file="later.vol"/><DataSet timestep="1" file="ball.vol"/>)");
  EXPECT_EQ(viewer.client->expect("scene run.pvd").at("state"),
            viewer.client->expect("scene ball.vol").at("state"));
  EXPECT_EQ(viewer.client->expect("scene run.pvd").at("steps"),
            json::parse(R"([{"time": 1, "files": {"ball": ")" + path("ball.vol") + R"("}},
                            {"time": 2, "files": {"ball": ")" +
                        path("later.vol") + R"("}}])"));
  write("out.pvd", R"(<DataSet file="../../secret.vol"/>)");
  const Reply reply = viewer.client->request("scene out.pvd");
  EXPECT_FALSE(reply.ok);
  EXPECT_NE(reply.error.find("secret.vol"), std::string::npos) << reply.error;
}

TEST(ViewerLooks, StepsHaveEquallyManyFilesAndAnAnswerHasAnEnd) {
  const auto server = serve();
  Viewer viewer(*server);
  const std::filesystem::path folder = server->folder().path();
  const auto collection = [&](const char* name, int times, int parts) {
    std::ofstream out(folder / name);
    out << "<VTKFile type=\"Collection\"><Collection>";
    for (int time = 0; time < times; time++)
      for (int part = 0; part < parts; part++)
        out << "<DataSet timestep=\"" << time << "\" file=\"ball.vol\"/>";
    out << "</Collection></VTKFile>";
  };
  collection("a.pvd", 2, 1);
  collection("b.pvd", 1, 300);
  const auto refused = [&](const std::string& statement) { return viewer.client->request(statement).error; };
  EXPECT_NE(refused("scene *.pvd").find("expected equally many"), std::string::npos);
  EXPECT_NE(refused("show *.pvd").find("expected equally many"), std::string::npos);
  std::filesystem::remove(folder / "a.pvd");
  collection("c.pvd", 2, 1);
  EXPECT_NE(refused("scene *.pvd").find("expected equally many"), std::string::npos) << "the other order";
  std::string many = "scene";
  for (int i = 0; i < 65; i++) many += " ball.vol";
  EXPECT_EQ(refused(many), "there are 65 names, expected at most 64");
  collection("long.pvd", 100001, 1);
  EXPECT_NE(refused("scene long.pvd").find("100001 files in all steps, expected at most 100000"),
            std::string::npos);
}

TEST(ViewerLooks, ASeriesIsNamedWithTheFilesOfEachStep) {
  const auto server = serve();
  Viewer viewer(*server);
  const std::filesystem::path folder = std::filesystem::canonical(server->folder().path());
  for (const char* name : {"s_1", "s_2", "s_10", "t_1", "t_2"}) writeBall(folder, name, 4);
  const json look = viewer.client->expect("scene s_*.vol ball");
  const json& steps = look.at("steps");
  ASSERT_EQ(steps.size(), 3u);
  EXPECT_EQ(steps[0].at("files"), json({{"s_1", (folder / "s_1.vol").string()}}));
  EXPECT_EQ(steps[2].at("files"), json({{"s_1", (folder / "s_10.vol").string()}}));
  EXPECT_TRUE(steps[2].at("time").is_null());
  EXPECT_EQ(look.at("state").at("Datasets").size(), 2u);
  EXPECT_FALSE(viewer.client->expect("scene ball").contains("steps"));
  const Reply reply = viewer.client->request("scene s_*.vol t_*.vol");
  EXPECT_EQ(reply.error, "t_*.vol: it has 2 steps, but s_*.vol has 3; expected equally many");
  // What comes of a later step that may not be read is seen when it is imported.
  std::filesystem::create_symlink("/etc/passwd", folder / "s_3.vol");
  EXPECT_EQ(viewer.client->expect("scene s_*.vol").at("steps").size(), 4u);
  EXPECT_FALSE(viewer.client->request(importBall("s_1", (folder / "s_3.vol").string())).ok);
}

TEST(ViewerLooks, FilesAreReadWithinTheMemoryOfTheTenant) {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  setup.serverRank.tenantMemory = 1000;  // the ball's samples are more
  TestServer server(std::move(setup));
  const auto client = server.client();
  client->expect("load viewer");
  const Reply reply = client->request("scene ball.vol");
  EXPECT_FALSE(reply.ok);
  EXPECT_EQ(reply.error.find("memory: 16384 bytes are needed, but of tenant user's 1000 bytes"), 0u)
      << reply.error;
}

TEST(ViewerLooks, ASceneIsCancelledWithinAFile) {
  const auto server = serve();
  std::ofstream(server->folder() / "large.vol") << "uchar\n0 0 0\n4096 4096 256\n1 1 1\nlarge.raw\n";
  std::ofstream(server->folder() / "large.raw").put('\0');
  std::filesystem::resize_file(server->folder() / "large.raw", uint64_t(1) << 32);  // zeros
  const auto client = server->client();
  client->expect("load viewer");
  std::promise<Reply> ended;
  const uint32_t id = client->send("scene large.vol", [&](const Reply& r) { ended.set_value(r); });
  until([&] { return server->serverRank().ledger.total("user") > 0; }, "it is read");
  client->expect("cancel " + std::to_string(id));
  EXPECT_EQ(ended.get_future().get().error, "cancelled");
}

TEST(ViewerLooks, ShowSendsAPictureAndSaysHowToTurnIt) {
  const auto server = serve();
  auto options = server->options();
  std::map<std::string, size_t> files;
  options.onFile = [&](uint32_t, const json& header, std::span<const std::byte> content) {
    files[header.at("name")] = content.size();
  };
  Client client(options);
  client.expect("load viewer");
  const json shown = client.expect(R"(show ball.vol {"isovalues": "auto", "size": [40, 30]})");
  EXPECT_EQ(shown.at("pictures"), json({"ball_00000.png"}));
  EXPECT_NE(shown.at("text").get<std::string>().find("gxyviewer ball.vol"), std::string::npos);
  EXPECT_GT(files["ball_00000.png"], 100u);
  EXPECT_EQ(shown.at("state").at("Visualizations").at(0).at("operators").at(0).at("isovalues").size(), 1u);
}

TEST(ViewerLooks, CamerasAreFittedToTheDataAndKeptAsTheyWereWritten) {
  const auto server = serve();
  Viewer viewer(*server);
  viewer.client->expect(R"(set 1 {"Camera": {"fit": true, "viewdirection": [0, 0, -1], "aov": 40}})");
  const json state = viewer.client->expect("state 1").at("state");
  EXPECT_EQ(state.at("Cameras").at(0).at("fit"), true);
  const json camera = viewer.client->expect("camera 1").at("Camera");
  Camera asked;
  asked.fit = true;
  asked.aov = 40;
  asked.dimensions = {96, 80};
  const Camera expected = fitted(asked, Box{{-1, -1, -1}, {1, 1, 1}});
  EXPECT_FALSE(camera.contains("fit"));
  for (int a = 0; a < 3; a++)
    EXPECT_NEAR(camera.at("viewpoint").at(size_t(a)).get<double>(), expected.viewpoint[a], 1e-3);
  // A frame of it is one of that camera.
  const Screen::Picture fit = viewer.frame(), given = viewer.frame(json{{"Camera", camera}}.dump());
  EXPECT_EQ(fit.rgba, given.rgba);
  const json again = viewer.client->expect("camera 1");
  EXPECT_EQ(again.at("Camera"), camera);
  for (size_t a = 0; a < 3; a++) {
    EXPECT_EQ(again.at("box").at(0).at(a), -1);
    EXPECT_NEAR(again.at("box").at(1).at(a).get<double>(), 1, 1e-5);
  }
  ASSERT_EQ(again.at("ranges").size(), 1u);
  EXPECT_LT(again.at("ranges").at(0).at(0).get<double>(), again.at("ranges").at(0).at(1).get<double>());
}

TEST(ViewerLooks, ABatchNeedsNoCamera) {
  const auto server = serve();
  Viewer viewer(*server);
  json state = json::parse(stateOf("ball"));
  state.erase("Camera");
  EXPECT_EQ(viewer.client->expect(json{{"state", state}}.dump().insert(0, "batch ")).at("pictures").size(),
            1u);
}

}  // namespace
}  // namespace gxy::test
