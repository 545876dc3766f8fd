// SPDX-License-Identifier: Apache-2.0
// A rank that does not answer: who is told, and what goes on meanwhile.
#include <gtest/gtest.h>

#include <future>

#include "core/comm/presence.h"
#include "tests/multiserver/hang.h"
#include "tests/multiserver/test_server.h"
#include "tests/multiserver/viewer_client.h"

namespace gxy::test {
namespace {

using nlohmann::json;

std::unique_ptr<TestServer> impatient() {
  ServerSetup setup;
  setup.ranks = 4;  // rank 3 gets broadcasts from rank 1
  setup.modules = GALAXY_MODULES;
  setup.serverRank.rankPatience = std::chrono::milliseconds(100);
  return std::make_unique<TestServer>(std::move(setup));
}

json ranksOf(const json& list) {
  json ranks = json::array();
  for (const json& entry : list) ranks.push_back(entry.at("rank"));
  return ranks;
}

// Other ranks may be missing for a moment where the machine is busy.
void waitForStat(Client& client, const json& answering, const json& missing) {
  until(
      [&] {
        const json stat = client.expect("stat");
        return ranksOf(stat.at("ranks")) == answering && ranksOf(stat.at("missing")) == missing;
      },
      "stat");
}

/// The `waiting` events of a client.
class Waits {
 public:
  void take(const json& event) {
    if (event.at("event") != "waiting") return;
    const std::lock_guard lock(mutex_);
    events_.push_back(event);
  }
  /// Waits for one of these ranks and, if it is not 0, this request; its text.
  std::string textOf(const json& ranks, uint32_t request) const {
    std::string text;
    until(
        [&] {
          const std::lock_guard lock(mutex_);
          for (const json& event : events_) {
            const json& requests = event.at("requests");
            const bool has = std::find(requests.begin(), requests.end(), request) != requests.end();
            if (event.at("ranks") == ranks && (has || request == 0)) text = event.at("text");
          }
          return !text.empty();
        },
        "event waiting");
    return text;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<json> events_;
};

TEST(MissingRanks, AreNamedByStatAndToldToThoseWhoWaitAndAllGoesOnWithThem) {
  const auto server = impatient();
  Waits waits;
  auto options = server->options();
  options.onEvent = [&](const json& event) { waits.take(event); };
  Client client(options);
  const auto other = server->client();
  client.expect("load data");
  waitForStat(*other, {0, 1, 2, 3}, json::array());
  auto hang = std::make_unique<Hang>(*server, 1);
  waitForStat(*other, {0, 2, 3}, {1});
  std::promise<Reply> imported;
  const uint32_t id = client.send(importBall("late"), [&](const Reply& r) { imported.set_value(r); });
  EXPECT_EQ(waits.textOf({1}, id).substr(0, 7), "rank 1 ");
  EXPECT_EQ(client.expect("echo here").at("text"), "here") << "what needs no other rank is answered";
  hang.reset();
  const Reply reply = imported.get_future().get();
  EXPECT_TRUE(reply.ok) << reply.error;
  EXPECT_EQ(waits.textOf(json::array(), 0), "all ranks answer again");
  waitForStat(*other, {0, 1, 2, 3}, json::array());
}

TEST(MissingRanks, AreNamedInTheByeOfAServerThatCanBeStoppedWithoutThem) {
  const auto server = impatient();
  std::promise<std::string> end;
  auto options = server->options();
  options.onEnd = [&](const std::string& reason) { end.set_value(reason); };
  Client client(options);
  const auto other = server->client();
  auto hang = std::make_unique<Hang>(*server, 2);
  waitForStat(*other, {0, 1, 3}, {2});  // Before that rank 2 may still answer what it was asked earlier.
  client.expect("quit");
  EXPECT_TRUE(server->waitForStop());
  const auto stopped = std::async(std::launch::async, [&] { server->stop(); });
  const std::string reason = end.get_future().get();
  EXPECT_EQ(reason.substr(0, 18), "the server stops: ") << reason;
  EXPECT_NE(reason.find("rank 2 "), std::string::npos) << reason;
  hang.reset();
}

}  // namespace
}  // namespace gxy::test
