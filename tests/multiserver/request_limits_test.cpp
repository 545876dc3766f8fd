// SPDX-License-Identifier: Apache-2.0
// What a request may have and do, and how it ends.
#include <gtest/gtest.h>

#include <future>

#include "core/comm/error.h"
#include "multiserver/server/session.h"
#include "tests/multiserver/test_server.h"
#include "tests/multiserver/viewer_client.h"

namespace gxy::test {
namespace {

using nlohmann::json;

/// A session without a socket.
struct Alone {
  explicit Alone(ServerRank& serverRank, protocol::Limits limits = {})
      : outbox(std::make_shared<Outbox>(
            Outbox::Limits{}, [] {}, serverRank.ledger.enter("ann", "to be sent", 0))),
        session(std::make_shared<Session>(serverRank, outbox, Session::Identity{1, "test", "ann", false},
                                          limits)) {}
  ~Alone() { session->end(); }
  /// Waits for the next that the session sends.
  protocol::WireMessage next() {
    std::optional<protocol::WireMessage> frame;
    until([&] { return (frame = outbox->next()).has_value(); }, "a frame");
    return *std::move(frame);
  }

  std::shared_ptr<Outbox> outbox;
  std::shared_ptr<Session> session;
};

std::unique_ptr<TestServer> withModules(ServerRankOptions serverRank = {}) {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  setup.serverRank = std::move(serverRank);
  return std::make_unique<TestServer>(std::move(setup));
}

std::future<Reply> replyTo(Client& client, const std::string& statement, uint32_t* id = nullptr) {
  const auto promise = std::make_shared<std::promise<Reply>>();
  const uint32_t number = client.send(statement, [promise](const Reply& r) { promise->set_value(r); });
  if (id) *id = number;
  return promise->get_future();
}

TEST(Requests, ThatAreCancelledAlreadyCallAtOnceWhatIsToBeCalledThen) {
  const auto server = withModules();
  Alone alone(server->serverRank());
  Request request(*alone.session, 1, protocol::bytesOf("echo"));
  int before = 0, after = 0;
  request.onCancel([&] { before++; });
  request.cancel();
  request.cancel();
  EXPECT_EQ(before, 1);
  request.onCancel([&] { after++; });
  EXPECT_EQ(after, 1);
}

TEST(Requests, TellTheirProgressTenTimesASecondButEachPhaseAndTheEndAlways) {
  const auto server = withModules();
  Alone alone(server->serverRank());
  Request request(*alone.session, 1, protocol::bytesOf("echo"));
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 1000; i++) request.progress(i, 1000, "step");
  const auto tenths = (std::chrono::steady_clock::now() - begin) / std::chrono::milliseconds(100);
  for (int i = 0; i < 3; i++) request.progress(i, 1000, "phase", true);
  request.progress(1000, 1000, "end");
  std::map<std::string, int> told;
  while (const auto frame = alone.outbox->next()) told[json::parse(frame->text()).at("text")]++;
  EXPECT_GE(told["step"], 1);
  EXPECT_LE(told["step"], 1 + tenths);
  EXPECT_EQ(told["phase"], 3);
  EXPECT_EQ(told["end"], 1);
}

TEST(Requests, ThatWaitAreAsManyAsMayBe) {
  const auto server = withModules();
  protocol::Limits limits;
  limits.requests = 3;
  Alone alone(server->serverRank(), limits);
  alone.session->submit(1, protocol::bytesOf("load data"));
  EXPECT_EQ(alone.next().text().substr(0, 2), "ok");
  for (uint32_t id = 2; id < 4; id++) alone.session->submit(id, protocol::bytesOf("wait nothing 1 1e6"));
  EXPECT_FALSE(alone.session->full());
  alone.session->submit(4, protocol::bytesOf("wait nothing 1 1e6"));
  EXPECT_TRUE(alone.session->full());
  alone.session->cancel(2);
  EXPECT_EQ(alone.next().text(), "error: cancelled");
  EXPECT_FALSE(alone.session->full());
}

TEST(Requests, ThatAreAnsweredNoLongerCountByTheirBytes) {
  const auto server = withModules();
  protocol::Limits limits;
  limits.requestBytes = 100;
  Alone alone(server->serverRank(), limits);
  for (uint32_t id = 1; id <= 10; id++) {
    alone.session->submit(id, protocol::bytesOf("echo " + std::string(55, 'x')));
    EXPECT_EQ(alone.next().text().substr(0, 2), "ok");
    EXPECT_FALSE(alone.session->full()) << id;
  }
}

TEST(Requests, OfMoreThan4096BytesNeedRoomAndShorterOnesDoNot) {
  ServerRankOptions options;
  options.tenantMemory = 1000;
  const auto server = withModules(options);
  Alone alone(server->serverRank());
  EXPECT_TRUE(alone.session->makeRoom(4096));
  EXPECT_FALSE(alone.session->makeRoom(4097));
}

TEST(Requests, BesideOthersHoldASlotOfTheirTenantUntilTheyEnd) {
  const auto server = withModules();
  Alone alone(server->serverRank());
  alone.session->submit(1, protocol::bytesOf("load data"));
  EXPECT_EQ(alone.next().text().substr(0, 2), "ok");
  alone.session->submit(2, protocol::bytesOf("wait nothing 1 1e6"));
  alone.session->submit(3, protocol::bytesOf("echo"));  // in its turn, after the one before has begun
  EXPECT_EQ(alone.next().id, 3u);
  Tenants& tenants = server->serverRank().tenants;
  std::vector<std::shared_ptr<void>> others;
  for (int i = 1; i < Tenants::kAside; i++) others.push_back(tenants.beginAside("ann"));
  EXPECT_THROW((void)tenants.beginAside("ann"), Error);
  alone.session->cancel(2);
  EXPECT_EQ(alone.next().text(), "error: cancelled");
  until(
      [&] {
        try {
          others.push_back(tenants.beginAside("ann"));
          return true;
        } catch (const Error&) {
          return false;
        }
      },
      "its slot is free");
}

TEST(Requests, BesideOthersAreEightAtOnceAndTheNextWaitsWithWhatFollows) {
  const auto server = withModules();
  const auto client = server->client();
  client->expect("load data");
  std::vector<std::future<Reply>> waits;
  std::vector<uint32_t> ids(size_t(Session::kAside) + 1);
  for (uint32_t& id : ids) waits.push_back(replyTo(*client, "wait nothing 1 1e6", &id));
  auto echo = replyTo(*client, "echo");
  EXPECT_EQ(echo.wait_for(std::chrono::milliseconds(100)), std::future_status::timeout) << "it waits";
  for (const uint32_t id : ids) client->expect("cancel " + std::to_string(id));
  EXPECT_TRUE(echo.get().ok);
  for (auto& wait : waits) EXPECT_EQ(wait.get().error, "cancelled");
}

TEST(Requests, OfAClientThatHasGoneEnd) {
  const auto server = withModules();
  {
    const auto client = server->client();
    client->expect("load data");
    client->send("wait nothing 1 1e6", [](const Reply&) {});
    client->expect("echo");
  }
  until([&] { return server->server().clients() == 0; }, "its session ends");
}

// The message that ends the parts of a work may come before they have begun: rank 0 asks by itself.
TEST(Requests, ThatAreCancelledBeforeTheirWorkHasBegunEndItNevertheless) {
  const auto server = withModules();
  ServerRank& serverRank = server->serverRank();
  std::promise<void> release;
  const std::shared_future<void> released = release.get_future().share();
  for (int rank = 0; rank < 2; rank++)
    server->serverRank(rank).work.add(
        "test.long",
        [&, rank, released](const Work::Call& call) -> json {
          released.wait();
          Exchanges::Part part = server->serverRank(rank).exchanges.join(call.parameters.at("exchange"));
          for (int item = 0; item < 3000; item++) {
            part.begin(item, 3000, "at it");
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
          }
          return nullptr;
        },
        Work::Runs::Long);
  Alone alone(serverRank);
  Request request(*alone.session, 1, protocol::bytesOf("echo"));
  const auto exchange = serverRank.exchanges.begin(request);
  auto called = std::async(std::launch::async, [&] {
    try {
      serverRank.callAll("test.long", {{"exchange", *exchange}});
      return std::string("all is done");
    } catch (const Error& e) {
      return std::string(e.what());
    }
  });
  request.cancel();
  serverRank.callAll("exchanges.cancel", {{"exchange", *exchange}});  // it has come, and found nothing
  release.set_value();
  const std::string said = called.get();
  EXPECT_EQ(said.substr(0, 17), "rank 0: cancelled") << said;
}

TEST(Pictures, TakeNoMoreThanAllTenantsMayHaveOnARank) {
  ServerRankOptions options;
  options.memory = 40 << 20;
  const auto server = withModules(options);
  const auto client = server->client();
  for (const std::string& statement :
       {std::string("load data"), std::string("load viewer"), importBall("ball"),
        std::string("window 1 {\"size\": [1024, 1024]}"), "set 1 " + stateOf("ball")})
    client->expect(statement);
  const std::string error = client->request("render 1").error;  // 64 bytes a pixel
  EXPECT_EQ(error.substr(0, 40), "memory: the picture takes 67108864 bytes") << error;
}

TEST(Clients, ThatCloseAreNotToldOfTheEnd) {
  const auto server = withModules();
  std::atomic<int> ends = 0;
  auto options = server->options();
  options.onEnd = [&](const std::string&) { ends++; };
  { Client client(options); }
  EXPECT_EQ(ends, 0);
}

TEST(Clients, HaveAsManyWindowsAndPixelsAsTheyMay) {
  const auto server = withModules();
  const auto client = server->client();
  client->expect("load viewer");
  const protocol::Limits limits = client->welcome().limits;
  for (size_t id = 1; id <= limits.windows; id++) client->expect("window " + std::to_string(id));
  EXPECT_NE(client->request("window 100").error.find("expected no more"), std::string::npos);
  client->expect("close 1");
  client->expect("window 100 {\"size\": [7680, 4320]}");
  EXPECT_EQ(limits.pixels, 7680u * 4320u);
  const std::string error = client->request("window 100 {\"size\": [7681, 4320]}").error;
  EXPECT_NE(error.find("expected at most 33177600 pixels"), std::string::npos) << error;
}

}  // namespace
}  // namespace gxy::test
