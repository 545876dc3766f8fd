// SPDX-License-Identifier: Apache-2.0
// The filter StreamTracer on a server: seeds, lines, what it refuses, and what is left of a cancelled one.
#include <gtest/gtest.h>

#include <fstream>
#include <future>
#include <mutex>

#include "core/data/geometry.h"
#include "multiserver/server/datasets.h"
#include "tests/multiserver/viewer_client.h"
#include "tests/support/cell_meshes.h"
#include "tests/support/mesh_files.h"

namespace gxy::test {
namespace {

using nlohmann::json;

std::string make(const std::string& filter, const std::string& name, const json& inputs, json properties) {
  properties.update({{"name", name}, {"filter", filter}, {"inputs", inputs}});
  return "make " + properties.dump();
}

/// What the one filter of a `make` tells.
json told(Client& client, const std::string& request) { return client.expect(request).at("results").at(0); }

/// A server with a flow about the axis z, and seeds on the axis x: two of them are outside.
class LinesServer {
 public:
  explicit LinesServer(int ranks) {
    ServerSetup setup;
    setup.ranks = ranks;
    setup.modules = GALAXY_MODULES;
    server = std::make_unique<TestServer>(std::move(setup));
  }
  void prepare(Client& client) {
    for (const char* module : {"data", "analysis"}) client.expect(std::string("load ") + module);
    client.expect(importBall("ball"));
    client.expect(make("Derive", "turn", {{"f", "ball"}}, {{"expression", "[0 - y, x, 0 * f]"}}));
    client.expect(
        make("Seeds", "seeds", {{"domain", "ball"}},
             {{"shape", "line"}, {"from", {0.05, 0.01, 0}}, {"to", {1.15, 0.01, 0}}, {"count", 12}}));
  }
  /// All segments of a dataset, by their ids.
  GeometryBlock segments(const std::string& name) {
    const auto found = server->serverRank(0).datasets->get("user", name);
    std::vector<GeometryBlock> blocks;
    for (int r = 0; r < server->serverRank(0).ranks(); r++)
      blocks.push_back(
          server->serverRank(r).objects.pin(found.key, found.generation).get<Dataset>()->geometry->block);
    return merged(GeometryKind::PathLines, blocks);
  }

  std::unique_ptr<TestServer> server;
};

TEST(Lines, OnAnyNumberOfRanksAreTheSame) {
  GeometryBlock expected;
  uint64_t points = 0;
  for (const int ranks : {1, 3}) {
    LinesServer lines(ranks);
    const auto client = lines.server->client();
    lines.prepare(*client);
    const json reply = told(*client, make("StreamTracer", "lines", {{"vectors", "turn"}, {"seeds", "seeds"}},
                                          {{"time", 6}, {"direction", "both"}}));
    EXPECT_EQ(reply.at("type"), "PathLines");
    EXPECT_EQ(reply.at("lines"), 10);
    EXPECT_EQ(reply.at("ends").at("outside"), 4) << "two seeds, in each direction";
    EXPECT_EQ(reply.at("ends").at("time"), 20);
    const json info = client->expect("info lines").at("datasets").at(0);
    EXPECT_EQ(info.at("provenance").at("filter"), "StreamTracer");
    EXPECT_EQ(info.at("provenance").at("properties").at("direction"), "both");
    const GeometryBlock all = lines.segments("lines");
    for (const glm::dvec3& p : all.points) EXPECT_NEAR(p.z, 0, 1e-7);
    if (ranks == 1) {
      expected = all;
      points = reply.at("points");
    } else {
      EXPECT_TRUE(all == expected);
      EXPECT_EQ(reply.at("points"), points);
    }
    for (const char* name : {"lines", "seeds", "turn", "ball"}) client->expect(std::string("drop ") + name);
    for (int r = 0; r < ranks; r++)  // a thread that has ended the last line may still let go of the flow
      until([&] { return lines.server->serverRank(r).ledger.total("user") == 0; }, "nothing is kept");
  }
}

TEST(Lines, HavePointsAndValuesAsTheirEntrySays) {
  LinesServer lines(2);
  const auto client = lines.server->client();
  lines.prepare(*client);
  client->expect(make("Derive", "east", {{"f", "ball"}}, {{"expression", "x + 0 * f"}}));
  const json inputs{{"vectors", "turn"}, {"seeds", "seeds"}, {"field", "east"}};
  json reply = told(
      *client, make("StreamTracer", "ends", inputs, {{"time", 1}, {"points", "ends"}, {"color by", "time"}}));
  EXPECT_EQ(reply.at("points"), 20) << "of each line two";
  GeometryBlock all = lines.segments("ends");
  for (const auto& [a, b] : all.segments) {
    EXPECT_EQ(all.values[a], 0);
    EXPECT_NEAR(all.values[b], 1, 1e-6);
  }
  reply = told(*client, make("StreamTracer", "steps", inputs,
                             {{"time", 1}, {"points", {{"dt", 0.25}}}, {"color by", "field"}}));
  EXPECT_EQ(reply.at("points"), 50);
  all = lines.segments("steps");
  for (size_t i = 0; i < all.points.size(); i++) EXPECT_NEAR(all.values[i], all.points[i].x, 1e-6);
  // Turned by 90 degrees the flow goes away from the centre.
  client->expect(make("Derive", "away", {{"f", "ball"}}, {{"expression", "[x, y, 0 * f]"}}));
  reply = told(*client,
               make("StreamTracer", "away lines",
                    {{"vectors", "away"}, {"seeds", "seeds"}, {"field", "ball"}}, {{"where", {0.7, 0.8}}}));
  EXPECT_EQ(reply.at("ends"), (json{{"condition", 8}, {"left", 2}, {"outside", 2}}));
}

TEST(Lines, HaveTheFieldsThatAreAskedForOnAnyNumberOfRanks) {
  GeometryBlock expected;
  for (const int ranks : {1, 3}) {
    LinesServer lines(ranks);
    const auto client = lines.server->client();
    lines.prepare(*client);
    client->expect(make("Derive", "east", {{"f", "ball"}}, {{"expression", "x + 0 * f"}}));
    const json reply =
        told(*client, make("StreamTracer", "lines",
                           {{"vectors", "turn"}, {"seeds", "seeds"}, {"fields", {"east", "turn"}}},
                           {{"time", 3}, {"fields", {"time", "speed", "length", "vorticity"}}}));
    ASSERT_EQ(reply.at("fields").size(), 6u);
    EXPECT_EQ(reply.at("fields").at(0).at("name"), "speed") << "the values";
    const GeometryBlock all = lines.segments("lines");
    const auto field = [&](const std::string& name) { return *findField(all.fields, name); };
    ASSERT_EQ(field("vorticity").components, 3);
    for (size_t i = 0; i < all.points.size(); i++) {
      const glm::dvec3 p = all.points[i];
      EXPECT_NEAR(field("length").values[i], all.values[i] * field("time").values[i], 1e-4);
      EXPECT_NEAR(field("east").values[i], p.x, 1e-6);
      EXPECT_NEAR(field("turn").values[3 * i], -p.y, 1e-6);
      EXPECT_NEAR(fieldValue(field("vorticity"), 2, i), 2, 1e-4);
      EXPECT_NEAR(fieldValue(field("vorticity"), 0, i), 0, 1e-4);
    }
    const json info = client->expect("info lines").at("datasets").at(0);
    EXPECT_EQ(info.at("fields").size(), 5u);
    EXPECT_EQ(info.at("fields").at(2).at("name"), "east");
    if (ranks == 1)
      expected = all;
    else
      EXPECT_TRUE(all == expected);
    for (const char* name : {"lines", "seeds", "turn", "east", "ball"})
      client->expect(std::string("drop ") + name);
    for (int r = 0; r < ranks; r++)  // a thread that has ended the last line may still let go of the flow
      until([&] { return lines.server->serverRank(r).ledger.total("user") == 0; }, "nothing is kept");
  }
}

/// Cells of all types in the unit cube, with vectors that turn about its middle, and with x.
std::string turningCells() {
  const MeshPiece cells = cubeOfAllCells(
      4, [](glm::dvec3) { return glm::dvec3(0); }, [](glm::dvec3 p) { return p.x; });
  GridFile file = gridOf(cells, 0, cells.cells.size(), "east");
  GridFile::Array turn{"turn", "Float32", 3, {}};
  for (const glm::dvec3& p : file.points)
    turn.values.insert(turn.values.end(), {-(p.y - 0.5), p.x - 0.5, 0.0});
  file.pointArrays.push_back(turn);
  return file.vtu();
}

TEST(Lines, ThroughTheCellsOfAFileAreTheSameOnAnyNumberOfRanks) {
  GeometryBlock expected;
  for (const int ranks : {1, 3}) {
    LinesServer lines(ranks);
    const auto client = lines.server->client();
    for (const char* module : {"data", "analysis"}) client->expect(std::string("load ") + module);
    std::ofstream(lines.server->folder() / "cells.vtu") << turningCells();
    for (const char* name : {"turn", "east"})
      client->expect(
          "import " +
          json{{"Datasets",
                {{{"name", name}, {"filename", "cells.vtu"}, {"type", "Volume"}, {"array", name}}}}}
              .dump());
    client->expect(
        make("Seeds", "seeds", {{"domain", "turn"}},
             {{"shape", "line"}, {"from", {0.55, 0.5, 0.3}}, {"to", {1.05, 0.5, 0.3}}, {"count", 11}}));
    const json reply =
        told(*client, make("StreamTracer", "lines",
                           {{"vectors", "turn"}, {"seeds", "seeds"}, {"field", "east"}, {"fields", {"turn"}}},
                           {{"time", 3}, {"color by", "field"}, {"fields", {"time", "vorticity"}}}));
    EXPECT_EQ(reply.at("lines"), 10);
    EXPECT_EQ(reply.at("ends"), (json{{"outside", 1}, {"time", 10}}));
    const GeometryBlock all = lines.segments("lines");
    const auto field = [&](const std::string& name) { return *findField(all.fields, name); };
    for (size_t i = 0; i < all.points.size(); i++) {
      const double radius = 20 * std::hypot(all.points[i].x - 0.5, all.points[i].y - 0.5);
      EXPECT_NEAR(radius, std::round(radius), 1e-4) << "lines are circles";
      EXPECT_NEAR(all.values[i], all.points[i].x, 1e-6);
      EXPECT_NEAR(fieldValue(field("turn"), 1, i), all.points[i].x - 0.5, 1e-6);
      EXPECT_NEAR(fieldValue(field("vorticity"), 2, i), 2, 1e-5);
    }
    if (ranks == 1)
      expected = all;
    else
      EXPECT_TRUE(all == expected);
    const auto refused = [&](const json& in, const std::string& why) {
      const std::string error = client->request(make("StreamTracer", "x", in, json::object())).error;
      EXPECT_NE(error.find(why), std::string::npos) << error;
    };
    refused({{"vectors", "east"}, {"seeds", "seeds"}}, "\"east\" has 1 components, expected 3");
    client->expect(importBall("ball"));
    refused({{"vectors", "turn"}, {"seeds", "seeds"}, {"field", "ball"}},
            "\"ball\" has other points or cells than \"turn\", expected the same");
    for (const char* name : {"lines", "seeds", "turn", "east", "ball"})
      client->expect(std::string("drop ") + name);
    for (int r = 0; r < ranks; r++)
      until([&] { return lines.server->serverRank(r).ledger.total("user") == 0; }, "nothing is kept");
  }
}

TEST(Lines, RefuseWhatCannotBe) {
  LinesServer lines(2);
  const auto client = lines.server->client();
  lines.prepare(*client);
  const json inputs{{"vectors", "turn"}, {"seeds", "seeds"}};
  const auto refused = [&](const json& in, const json& properties, const std::string& expected) {
    const std::string error = client->request(make("StreamTracer", "x", in, properties)).error;
    EXPECT_NE(error.find(expected), std::string::npos) << error;
  };
  refused({{"vectors", "ball"}, {"seeds", "seeds"}}, json::object(), "\"ball\" has 1 components, expected 3");
  refused({{"vectors", "turn"}, {"seeds", "ball"}}, json::object(), "seeds");
  refused({{"vectors", "turn"}, {"seeds", "seeds"}, {"field", "turn"}}, json::object(),
          "\"turn\" has 3 components, expected one");
  refused(inputs, {{"where", {1, 2}}}, "`where` needs the input `field`");
  refused(inputs, {{"color by", "field"}}, "`color by` needs the input `field`");
  refused(inputs, {{"where", {2, 1}}}, "[lo, hi] with lo <= hi");
  refused(inputs, {{"direction", "up"}}, "forward, backward or both");
  refused(inputs, {{"points", {{"dt", 0}}}}, "number > 0");
  refused(inputs, {{"points", {{"dx", 1}}}}, "{\"dt\": number > 0}");
  refused(inputs, {{"time", -1}}, "number >= 0");
  EXPECT_EQ(client->expect("list").at("datasets").size(), 3u);
}

// Without `time` there is no limit; a time that is none is an error.
TEST(Lines, RefuseTimesThatAreNoNumbers) {
  LinesServer lines(2);
  const auto client = lines.server->client();
  lines.prepare(*client);
  const std::string syntax = "syntax error", large = "number too large; expected a finite double",
                    kind = "`time`: expected a number >= 0, found ";
  for (const auto& [time, expected] :
       std::vector<std::pair<std::string, std::string>>{{"1e999", large},
                                                        {"-1e999", large},
                                                        {"\"inf\"", kind + "\"inf\""},
                                                        {"\"Infinity\"", kind + "\"Infinity\""},
                                                        {"Infinity", syntax},
                                                        {"NaN", syntax},
                                                        {"null", kind + "null"}}) {
    const Reply reply = client->request(
        R"(make {"filter":"StreamTracer","name":"x","inputs":{"vectors":"turn","seeds":"seeds"},"time":)" +
        time + "}");
    EXPECT_FALSE(reply.ok) << time;
    EXPECT_NE(reply.error.find(expected), std::string::npos) << time << ": " << reply.error;
    EXPECT_TRUE(reply.error.starts_with("make:1:")) << time << ": " << reply.error;
  }
  EXPECT_EQ(client->expect("list").at("datasets").size(), 3u);
  const json reply = told(*client, make("StreamTracer", "x", {{"vectors", "turn"}, {"seeds", "seeds"}},
                                        {{"time", 1e308}, {"length", 1}}));
  EXPECT_EQ(reply.at("ends").at("length"), 10);
}

// It would go round for weeks.
TEST(Lines, ThatAreCancelledLeaveNothing) {
  LinesServer lines(3);
  std::promise<void> begun;
  std::once_flag once;
  auto options = lines.server->options();
  options.onEvent = [&](const json& event) {
    if (event.at("event") == "progress" && event.at("text") == "lines")
      std::call_once(once, [&] { begun.set_value(); });
  };
  Client client(options);
  lines.prepare(client);
  std::vector<int64_t> before;
  for (int r = 0; r < 3; r++) before.push_back(lines.server->serverRank(r).ledger.total("user"));
  std::promise<Reply> made;
  const uint32_t id = client.send(make("StreamTracer", "lines", {{"vectors", "turn"}, {"seeds", "seeds"}},
                                       {{"length", 1e12}, {"points", "ends"}}),
                                  [&](const Reply& reply) { made.set_value(reply); });
  begun.get_future().get();
  client.expect("cancel " + std::to_string(id));
  EXPECT_EQ(made.get_future().get().error, "cancelled");
  EXPECT_EQ(client.expect("list").at("datasets").size(), 3u);
  for (int r = 0; r < 3; r++)
    until([&] { return lines.server->serverRank(r).ledger.total("user") == before[size_t(r)]; },
          "nothing more is kept");
  client.expect(make("StreamTracer", "lines", {{"vectors", "turn"}, {"seeds", "seeds"}}, {{"time", 1}}));
}

}  // namespace
}  // namespace gxy::test
