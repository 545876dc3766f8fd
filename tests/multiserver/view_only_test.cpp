// SPDX-License-Identifier: Apache-2.0
// Who comes with a view-only token sees everything of the tenant, and changes nothing.
#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <set>

#include "core/comm/error.h"
#include "tests/multiserver/test_server.h"

namespace gxy::test {
namespace {

/// A server with one tenant, and clients with its two tokens.
struct Viewed {
  Viewed() {
    ServerSetup setup;
    setup.modules = GALAXY_MODULES;
    setup.tokens = {{"owners", "ann"}};
    server = std::make_unique<TestServer>(std::move(setup));
    server->serverRank().tenants.add("viewers", {"ann", false, true});
    owner = enter("owners");
    viewer = enter("viewers");
  }
  std::unique_ptr<Client> enter(const std::string& token) {
    Client::Options options = server->options();
    options.tokenFile = (server->folder().path() / token).string();
    std::ofstream(options.tokenFile) << token << '\n';
    options.onPixels = [this](const auto& header, auto data) { screen.take(header, data); };
    auto client = std::make_unique<Client>(options);
    for (const char* module : {"data", "viewer", "graph", "analysis", "insitu", "example"})
      client->expect(std::string("load ") + module);
    return client;
  }

  Screen screen;
  std::unique_ptr<TestServer> server;
  std::unique_ptr<Client> owner, viewer;
};

TEST(ViewOnly, EveryVerbThatChangesSomethingIsRefused) {
  Viewed v;
  const std::set<std::string> looks{
      "help",       "load",      "modules", "stat",     "cancel",    "echo",         "ticket",
      "list",       "info",      "fetch",   "files",    "histogram", "range",        "wait",
      "observe",    "unobserve", "window",  "set",      "render",    "pick",         "cancel_frame",
      "close",      "windows",   "state",   "camera",   "scene",     "show",         "colormaps",
      "graph.list", "get",       "numbers", "watch",    "unwatch",   "graph.wait",   "check",
      "types",      "filters",   "streams", "triggers", "listen",    "example.range"};
  std::set<std::string> allowed;
  const auto help = v.viewer->expect("help");
  EXPECT_GT(help.at("verbs").size(), 55u);
  for (const auto& verb : help.at("verbs")) {
    const std::string name = verb.at("verb");
    const Reply reply = v.viewer->request(name);
    if (reply.error.find("view-only") == std::string::npos) allowed.insert(name);
  }
  EXPECT_EQ(allowed, looks);
}

TEST(ViewOnly, PicturesAreSeenButNothingIsImportedForThem) {
  Viewed v;
  v.owner->expect(importBall("ball"));
  v.viewer->expect("window 1 {\"size\": [96, 80]}");
  v.viewer->expect("set 1 " + stateOf("ball"));
  const uint64_t frame = v.viewer->expect("render 1").at("frame");
  EXPECT_EQ(v.screen.waitFor(1, frame).status, "complete");
  auto withFile = nlohmann::json::parse(stateOf("ball"));
  withFile["Datasets"] = {{"name", "ball"}, {"filename", "ball.vol"}, {"type", "Volume"}};
  v.viewer->expect("set 1 " + withFile.dump());
  withFile["Datasets"]["name"] = "another";
  EXPECT_NE(v.viewer->request("set 1 " + withFile.dump()).error.find("view-only"), std::string::npos);
  EXPECT_EQ(v.owner->expect("list").at("datasets").size(), 1u);
}

TEST(ViewOnly, ATicketOfAViewerIsAViewers) {
  Viewed v;
  EXPECT_TRUE(v.viewer->request("drop ball").error.starts_with("drop: it changes something"));
  const std::string ticket = v.viewer->expect("ticket").at("ticket");
  EXPECT_EQ(v.server->serverRank().tickets.redeem(ticket), "viewers");
}

}  // namespace
}  // namespace gxy::test
