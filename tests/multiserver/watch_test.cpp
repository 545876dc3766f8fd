// SPDX-License-Identifier: Apache-2.0
// Verb `watch`: an event each time that a condition begins to hold.
#include <gtest/gtest.h>

#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include "tests/multiserver/test_server.h"

namespace gxy::test {
namespace {

using WatchJson = nlohmann::json;

/// A server with a client that keeps the events `watch`.
struct WatchServer : TestServer {
  static ServerSetup setup(int ranks) {
    ServerSetup setup;
    setup.ranks = ranks;
    setup.modules = GALAXY_MODULES;
    return setup;
  }
  explicit WatchServer(int ranks) : TestServer(setup(ranks)) {
    Client::Options options = TestServer::options();
    options.onEvent = [this](const WatchJson& event) {
      if (event.at("event") != "watch") return;
      const std::lock_guard lock(mutex);
      events.push_back(event);
      came.notify_all();
    };
    client = std::make_unique<Client>(options);
    client->expect("load data");
    client->expect("load analysis");
  }
  /// Makes the next generation of the ball, whose largest value is scale * 3^(1/2).
  void publish(float scale) {
    writeBall(folder().path().string(), "ball", 16, scale);
    client->expect(importBall("ball"));
  }
  WatchJson next() {
    std::unique_lock lock(mutex);
    if (!came.wait_for(lock, std::chrono::minutes(1), [&] { return !events.empty(); })) return "no event";
    WatchJson event = events.front();
    events.pop_front();
    return event;
  }
  std::string error(const std::string& statement) { return client->request(statement).error; }

  std::mutex mutex;
  std::condition_variable came;
  std::deque<WatchJson> events;
  std::unique_ptr<Client> client;
};

TEST(Watch, TellsEachTimeThatAConditionBeginsToHold) {
  for (const int ranks : {1, 3}) {
    WatchServer server(ranks);
    server.publish(1);
    EXPECT_EQ(
        server.client->expect(
            R"json(watch {"expression": "max(b) > 3", "inputs": {"b": "ball"}, "name": "hot"})json")["value"],
        false);
    EXPECT_EQ(server.client->expect(R"json(watch {"expression": "max(ball) < 3"})json"),
              (WatchJson{{"watch", "max(ball) < 3"}, {"value", true}, {"text", "max(ball) < 3: true"}}));
    const WatchJson hot{
        {"event", "watch"}, {"watch", "hot"}, {"value", true}, {"generations", {{"ball", 2}}}};
    server.publish(2);
    EXPECT_EQ(server.next(), hot);
    server.publish(3);  // It holds still.
    server.publish(1);
    EXPECT_EQ(server.next()["watch"], "max(ball) < 3");
    server.publish(2);
    WatchJson again = hot;
    again["generations"]["ball"] = 5;
    EXPECT_EQ(server.next(), again);
    server.client->expect("unwatch hot");
    server.publish(1);
    EXPECT_EQ(server.next()["watch"], "max(ball) < 3");
    server.publish(2);
    EXPECT_EQ(
        server.client->expect(R"json(watch {"expression": "max(ball) > 3", "name": "hot"})json")["value"],
        true);
    EXPECT_TRUE(server.events.empty());
  }
}

TEST(Watch, SaysOnceThatTheDataAreGoneAndGoesOnWithNewOnes) {
  WatchServer server(2);
  server.publish(2);
  EXPECT_EQ(server.client->expect(R"json(watch {"expression": "max(ball) > 3"})json")["value"], true);
  server.client->expect("drop ball");
  const WatchJson gone = server.next();
  EXPECT_NE(gone["error"].get<std::string>().find("ball"), std::string::npos) << gone;
  server.publish(2);
  EXPECT_EQ(server.next()["value"], true);
}

TEST(Watch, RefusesWhatItCannotWatch) {
  WatchServer server(2);
  server.publish(1);
  server.client->expect(R"json(make {"name": "seeds", "filter": "Seeds", "inputs": {"domain": "ball"}})json");
  const auto expectError = [&](const std::string& what, const std::string& part) {
    const std::string error = server.error("watch " + what);
    EXPECT_NE(error.find(part), std::string::npos) << what << ": " << error;
  };
  expectError(R"json({"expression": "max(ball)"})json", "is a number, expected a condition");
  expectError(R"json({"expression": "ball > 3"})json", "the result is a logical field, expected a number");
  expectError(R"json({"expression": "max(ball) >"})json", "line 1, column");
  expectError(R"json({"expression": "max(nothing) > 3"})json", "nothing");
  expectError(R"json({"expression": "max(seeds) > 3"})json", "\"seeds\" is Particles, expected a Volume");
  expectError(R"json({"expression": "1 > 0"})json", "names no dataset");
  expectError(R"json({"expression": 3})json", "expected a text, found 3");
  expectError(R"json({"expression": "max(ball) > 3", "inputs": {"b": "ball"}})json", "has no name `b`");
  expectError(R"json({"expression": "max(ball) > 3", "every": 3})json", "unknown key `every`");
  expectError("{}", "there is no `expression`");
  EXPECT_NE(server.error("unwatch hot").find("there is no watch \"hot\""), std::string::npos);
  for (int i = 0; i < 64; i++)
    server.client->expect(R"json(watch {"expression": "max(ball) > 3", "name": "w)json" + std::to_string(i) +
                          "\"}");
  expectError(R"json({"expression": "max(ball) > 3"})json", "64 watches");
  server.publish(2);
  for (int i = 0; i < 64; i++) EXPECT_EQ(server.next()["value"], true);
}

TEST(Watch, EndsWithItsClient) {
  WatchServer server(2);
  server.publish(1);
  server.client->expect(R"json(watch {"expression": "max(ball) > 3 and mean(ball) > 0"})json");
  const auto other = server.TestServer::client();
  other->expect("load data");
  writeBall(server.folder().path().string(), "ball", 64, 2);
  other->expect(importBall("ball"));  // while it evaluates, or before
  server.client.reset();
  other->expect("drop ball");
  // The server learns of the end of a connection a moment later.
  const auto used = [&] {
    return server.serverRank(0).ledger.total("user") + server.serverRank(1).ledger.total("user");
  };
  const auto latest = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (used() > 0 && std::chrono::steady_clock::now() < latest)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(used(), 0);
}

}  // namespace
}  // namespace gxy::test
