// SPDX-License-Identifier: Apache-2.0
// Verbs `histogram` and `files` of module data.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/multiserver/test_server.h"

namespace gxy::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A server on three ranks with a ball, and a client.
struct DataServer : TestServer {
  static ServerSetup setup() {
    ServerSetup setup;
    setup.ranks = 3;
    setup.modules = GALAXY_MODULES;
    return setup;
  }
  DataServer() : TestServer(setup()), client(TestServer::client()) {
    client->expect("load data");
    client->expect("load analysis");
  }
  std::string errorOf(const std::string& statement) const { return client->request(statement).error; }

  std::unique_ptr<Client> client;
};

TEST(Histogram, IsThatOfStatisticsOfEachGeneration) {
  DataServer server;
  server.client->expect(importBall("ball"));
  const auto statistics = [&](int bins) {
    return server.client
        ->expect("make " +
                 json{{"filter", "Statistics"}, {"inputs", {{"field", "ball"}}}, {"histogram", bins}}.dump())
        .at("results")
        .at(0)
        .at("histogram");
  };
  const json usual = server.client->expect("histogram ball");
  EXPECT_EQ(usual.at("counts").size(), 256u);
  EXPECT_EQ(usual.at("count"), 16 * 16 * 16);
  EXPECT_EQ(usual.at("generation"), 1);
  int64_t sum = 0;
  for (const int64_t count : usual.at("counts")) sum += count;
  EXPECT_EQ(sum, 16 * 16 * 16);
  EXPECT_EQ(usual.at("range"), server.client->expect("range ball").at("range"));
  EXPECT_EQ(usual.at("counts"), statistics(256).at("counts"));
  const json seven = server.client->expect("histogram ball 7");
  EXPECT_EQ(seven.at("counts"), statistics(7).at("counts"));
  EXPECT_EQ(server.client->expect("histogram ball 7"), seven) << "what is kept";

  writeBall(server.folder().path().string(), "large", 16, 2);
  server.client->expect(importBall("ball", "large.vol"));
  const json next = server.client->expect("histogram ball 7");
  EXPECT_EQ(next.at("generation"), 2);
  EXPECT_EQ(next.at("counts"), seven.at("counts"));
  EXPECT_EQ(next.at("range").at(1), 2 * seven.at("range").at(1).get<double>());
}

TEST(Histogram, OfWhatIsNotThereOrNotAskedRightIsAnError) {
  DataServer server;
  server.client->expect(importBall("ball"));
  EXPECT_NE(server.errorOf("histogram nothing").find("there is none that you see"), std::string::npos);
  for (const char* wrong : {"0", "4097", "2.5", "-1", "x", "16 -1", "16 1.5", "16 0 0"})
    EXPECT_FALSE(server.client->request(std::string("histogram ball ") + wrong).ok) << wrong;
  EXPECT_FALSE(server.client->request("histogram ball 16 7").ok) << "a component that is not there";
}

TEST(Files, AreThoseThatCanBeOpenedAndNoOthers) {
  DataServer server;
  const fs::path folder = server.folder().path();
  fs::create_directories(folder / "runs/deep");
  for (const char* name : {"runs/a.vti", "runs/B.VTU", "runs/scene.json", "runs/c.nii.gz", "runs/d.pvd",
                           "runs/notes.txt", "runs/x.gz", "runs/.hidden.vti", "runs/none"})
    std::ofstream(folder / name) << "12345";
  fs::create_symlink("/etc/hostname", folder / "runs/outside.vti");
  fs::create_symlink("/etc", folder / "runs/etc");
  fs::create_symlink(folder / "ball.vol", folder / "runs/inside.vol");
  const json top = server.client->expect("files");
  EXPECT_EQ(top.at("folders"), json::array({"runs"}));
  EXPECT_EQ(top.at("files").at(0).at("name"), "ball.vol");
  const json runs = server.client->expect("files runs");
  EXPECT_EQ(runs.at("folders"), json::array({"deep"}));
  std::vector<std::string> names;
  for (const json& file : runs.at("files")) names.push_back(file.at("name"));
  EXPECT_EQ(names,
            (std::vector<std::string>{"B.VTU", "a.vti", "c.nii.gz", "d.pvd", "inside.vol", "scene.json"}));
  EXPECT_EQ(runs.at("files").at(0).at("bytes"), 5);
  EXPECT_EQ(runs.at("more"), false);
  EXPECT_EQ(server.client->expect("files " + (folder / "runs").string()).at("files"), runs.at("files"));
  EXPECT_EQ(server.client->expect("files runs/deep").at("files"), json::array());
  for (const char* outside : {"/etc", "..", "runs/../..", "runs/etc", "nowhere", "ball.vol"})
    EXPECT_NE(server.errorOf(std::string("files ") + outside).find("no such folder that may be read"),
              std::string::npos)
        << outside;
}

}  // namespace
}  // namespace gxy::test
