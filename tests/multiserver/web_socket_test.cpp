// SPDX-License-Identifier: Apache-2.0
// Sessions over a WebSocket: they are those over TCP, and whoever breaks the rules is let go.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <memory>
#include <set>
#include <thread>
#include <vector>

#include "tests/multiserver/bystander.h"
#include "tests/multiserver/viewer_client.h"
#include "tests/multiserver/web_client.h"

namespace gxy::test {
namespace {

using protocol::MessageChannel;
using protocol::WireMessage;

ServerSetup webSetup() {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  return setup;
}

/// All that a session was told, in a form that does not depend on time.
struct Told {
  std::vector<std::string> replies;
  std::set<std::string> tiles;  ///< whole records
  std::vector<std::string> ends;

  void take(const WireMessage& message) {
    if (message.channel == MessageChannel::Reply) replies.emplace_back(message.text());
    if (message.channel != MessageChannel::Pixels) return;
    const protocol::PixelHeader header = protocol::pixelHeader(message.payload);
    if (header.kind == protocol::PixelKind::Tile) {
      tiles.emplace(message.text());
      return;
    }
    const auto data = protocol::pixelData(message.payload);
    auto json =
        nlohmann::json::parse(std::string_view(reinterpret_cast<const char*>(data.data()), data.size()));
    json.erase("seconds");
    ends.push_back(json.dump());
  }
};

/// The same session over any connection.
template <class Connection>
Told session() {
  TestServer server(webSetup());
  Connection connection(server.port());
  connection.greet();
  const std::vector<std::string> statements{"load data",
                                            "load viewer",
                                            importBall("ball"),
                                            "list",
                                            "info ball",
                                            "range ball",
                                            "range nothing",
                                            "window 1 {\"size\": [300, 280]}",
                                            "set 1 " + stateOf("ball"),
                                            "pick 1 150 140",
                                            "render 1 {\"levels\": [4, 1], \"passes\": 2}",
                                            "echo " + std::string(100000, 'x'),
                                            "nonsense"};
  Told told;
  bool over = false;
  EXPECT_TRUE(connection.readUntil([&](const WireMessage& message) {
    told.take(message);
    over = over || RawClient::isEnd(message);
    const size_t answered = told.replies.size();
    const bool next =
        message.channel == MessageChannel::Reply || protocol::afterWord(message.text(), "welcome");
    if (next && answered < statements.size())
      connection.request(uint32_t(answered + 1), statements[answered]);
    return over && answered == statements.size();
  }));
  for (std::string& reply : told.replies)  // the name of the server's folder
    for (size_t at; (at = reply.find(server.folder().path().string())) != reply.npos;)
      reply.erase(at, server.folder().path().string().size());
  return told;
}

TEST(WebSocket, SaysByteForByteWhatTcpSays) {
  const Told overTcp = session<RawClient>(), overWebSocket = session<WebSocketClient>();
  EXPECT_TRUE(overTcp.replies == overWebSocket.replies);
  EXPECT_EQ(overTcp.ends, overWebSocket.ends);
  EXPECT_GT(overTcp.tiles.size(), 5u);
  EXPECT_TRUE(overTcp.tiles == overWebSocket.tiles);
}

TEST(WebSocket, TakesMessagesInFragmentsOfOneByteAndPingsBetween) {
  TestServer server(webSetup());
  WebSocketClient client(server.port());
  const auto inPieces = [&](const WireMessage& message) {
    const std::string bytes = WebSocketClient::bytesOf(message);
    std::string frames;
    for (size_t i = 0; i < bytes.size(); i++) {
      frames += WebSocketClient::frame(i == 0 ? WebSocketClient::kBinary : 0, {&bytes[i], 1},
                                       i + 1 == bytes.size());
      if (i == bytes.size() / 2) frames += WebSocketClient::frame(WebSocketClient::kPing, "alive");
    }
    for (const char c : frames) client.raw().send(bytesIn({&c, 1}));
  };
  inPieces(protocol::textMessage(MessageChannel::Control, 0, protocol::helloText({"", "pieces"})));
  inPieces(protocol::textMessage(MessageChannel::Request, 7, "echo whole"));
  int pongs = 0;
  std::string reply;
  while (reply.empty()) {
    const auto frame = client.nextFrame();
    ASSERT_NE(frame.opcode, -1);
    pongs += frame.opcode == WebSocketClient::kPong && frame.payload == "alive";
    if (frame.opcode == WebSocketClient::kBinary && frame.payload.find("whole") != frame.payload.npos)
      reply = frame.payload.substr(16);
  }
  EXPECT_EQ(pongs, 2);
  EXPECT_EQ(reply, "ok {\"text\":\"whole\"}");
}

TEST(WebSocket, ViolationsAreToldAndEndTheConnection) {
  ServerSetup s = webSetup();
  s.server.connection.limits.requestBytes = 1000;
  TestServer server(std::move(s));
  const auto reason = [&](auto&& act) {
    WebSocketClient client(server.port());
    client.greet();
    EXPECT_NE(client.awaitControl("welcome"), "closed");
    act(client);
    const std::string why = client.awaitControl("bye");
    EXPECT_TRUE(client.closedByServer());
    return why;
  };
  const auto expect = [&](const std::string& part, auto&& act) {
    const std::string why = reason(act);
    EXPECT_NE(why.find(part), std::string::npos) << why << ", expected " << part;
  };
  const auto request = [](const std::string& text) {
    return WebSocketClient::bytesOf(protocol::textMessage(MessageChannel::Request, 1, text));
  };
  expect("text", [&](auto& c) { c.sendFrame(WebSocketClient::kText, request("list")); });
  expect("0 bytes", [](auto& c) { c.sendFrame(WebSocketClient::kBinary, ""); });
  expect("15 bytes", [](auto& c) { c.sendFrame(WebSocketClient::kBinary, std::string(15, '\0')); });
  expect("header tells 4", [&](auto& c) { c.sendFrame(WebSocketClient::kBinary, request("list") + "x"); });
  expect("header tells 4",
         [&](auto& c) { c.sendFrame(WebSocketClient::kBinary, request("list").substr(0, 19)); });
  expect("header tells 4",
         [&](auto& c) { c.sendFrame(WebSocketClient::kBinary, request("list") + request("list")); });
  expect("at most 1000",
         [&](auto& c) { c.sendFrame(WebSocketClient::kBinary, request(std::string(1001, 'x'))); });
  expect("at most 1000", [&](auto& c) {
    c.sendFrame(WebSocketClient::kBinary, request(std::string(1001, 'x')).substr(0, 16), false);
  });
  expect("channel 4", [](auto& c) { c.send(protocol::textMessage(MessageChannel::Pixels, 0, "x")); });
  expect("id", [](auto& c) { c.request(0, "list"); });
  expect("header tells 724333350664028487",
         [](auto& c) { c.sendFrame(WebSocketClient::kBinary, "GALAXY\r\nGALAXY\r\n"); });
  EXPECT_EQ(reason([](auto& c) { c.sendFrame(WebSocketClient::kBinary, "x", true, false); }), "closed")
      << "unmasked";
  EXPECT_EQ(reason([](auto& c) { c.sendFrame(3, "x"); }), "closed") << "an opcode that is none";
}

TEST(WebSocket, HelloComesFirstAndOnce) {
  TestServer server(webSetup());
  WebSocketClient early(server.port());
  early.request(1, "help");
  EXPECT_NE(early.awaitControl("bye"), "closed");
  WebSocketClient twice(server.port());
  twice.greet();
  EXPECT_NE(twice.awaitControl("welcome"), "closed");
  twice.greet();
  EXPECT_NE(twice.awaitControl("bye"), "closed");
}

TEST(WebSocket, AByeOrACloseFrameEndsTheSession) {
  TestServer server(webSetup());
  WebSocketClient bye(server.port()), close(server.port());
  for (WebSocketClient* client : {&bye, &close}) {
    client->greet();
    EXPECT_NE(client->awaitControl("welcome"), "closed");
  }
  EXPECT_EQ(server.server().clients(), 2u);
  bye.send(protocol::textMessage(MessageChannel::Control, 0, "bye"));
  close.sendFrame(WebSocketClient::kClose, std::string("\x03\xe8", 2));
  EXPECT_TRUE(bye.closedByServer());
  EXPECT_TRUE(close.closedByServer());
  until([&] { return server.server().clients() == 0; }, "the sessions have ended");
}

TEST(WebSocket, TheServersEndIsTold) {
  TestServer server(webSetup());
  WebSocketClient client(server.port());
  WebClient waiting(server.port());  // before its first request
  client.greet();
  EXPECT_NE(client.awaitControl("welcome"), "closed");
  std::thread stop([&] { server.stop(); });
  EXPECT_EQ(client.awaitControl("bye").rfind("the server stops", 0), 0u);
  EXPECT_EQ(client.nextFrame().opcode, WebSocketClient::kClose) << "an ordinary end";
  EXPECT_TRUE(waiting.closedByServer());
  stop.join();
}

TEST(WebSocket, WhoSaysNothingOrNoLongerAnswersIsClosed) {
  ServerSetup s = webSetup();
  s.server.connection.patience = {std::chrono::seconds(2), std::chrono::milliseconds(100),
                                  std::chrono::milliseconds(600)};
  TestServer server(std::move(s));
  WebSocketClient silent(server.port()), dead(server.port());
  dead.greet();
  EXPECT_NE(dead.awaitControl("welcome"), "closed");
  EXPECT_TRUE(silent.closedByServer()) << "no hello";
  EXPECT_TRUE(dead.closedByServer()) << "pings are not answered";
}

TEST(WebSocket, TicketsStandForTokensOnce) {
  ServerSetup s = webSetup();
  s.tokens = {{"good", "ann"}, {"best", "admin"}};
  TestServer server(std::move(s));
  const auto options = [&](const std::string& token) {
    Client::Options o = server.options();
    const std::string file = (server.folder().path() / token).string();
    std::ofstream(file) << token << '\n';
    o.tokenFile = file;
    return o;
  };
  Client ann(options("good")), admin(options("best"));
  const auto ticket = [](Client& client) {
    const auto reply = client.expect("ticket");
    EXPECT_EQ(reply.at("seconds"), 60);
    return reply.at("ticket").get<std::string>();
  };
  const auto enter = [&](const protocol::Hello& hello) {
    WebSocketClient client(server.port());
    client.hello(hello);
    std::string answer;
    client.readUntil([&](const WireMessage& message) {
      answer = message.text();
      return true;
    });
    return answer;
  };
  const std::string anns = ticket(ann), admins = ticket(admin);
  const protocol::Welcome first = protocol::parseWelcome(enter({"", "browser", "admin", anns}));
  EXPECT_EQ(first.tenant, "ann") << "whatever tenant it names";
  EXPECT_FALSE(first.administrator);
  EXPECT_EQ(first.token, "good");
  EXPECT_EQ(protocol::parseWelcome(enter({"", "browser", "user", admins})).token, "best");
  EXPECT_NE(enter({"", "browser", "user", anns}).find("bye the ticket was used"), std::string::npos);
  EXPECT_NE(enter({"best", "browser", "user", anns}).find("bye the ticket"), std::string::npos)
      << "beside a token";
  const protocol::Welcome again = protocol::parseWelcome(enter({first.token, "browser"}));
  EXPECT_EQ(again.tenant, "ann");
  EXPECT_EQ(again.token, "") << "only a ticket is answered by a token";
  EXPECT_NE(enter({"wrong", "browser"}).find("bye the token is wrong"), std::string::npos);
}

TEST(WebSocket, WhatStandsInAUrlLetsNobodyIn) {
  ServerSetup s = webSetup();
  s.tokens = {{"good", "ann"}};
  TestServer server(std::move(s));
  const std::string ticket = server.serverRank().tickets.issue("good", Tickets::kShort);
  WebSocketClient client(server.port(), 0, "/ws?token=good&ticket=" + ticket);
  client.hello({"", "browser"});
  EXPECT_EQ(client.awaitControl("bye").find("the token is wrong"), 0u);
  EXPECT_EQ(server.serverRank().tickets.redeem(ticket), "good") << "it was not used";
}

TEST(WebSocket, AServerWithoutTokensNeedsNoTickets) {
  TestServer server(webSetup());
  EXPECT_EQ(server.client()->expect("ticket").at("ticket"), "");
  WebSocketClient client(server.port());
  client.hello({"", "browser", "ann", "whatever"});
  EXPECT_EQ(protocol::parseWelcome("welcome " + client.awaitControl("welcome")).tenant, "ann");
}

TEST(WebSocket, ManyIdleBrowsersAndOneThatStopsReadingDisturbNobody) {
  ServerSetup s = webSetup();
  s.server.connection.limits.requestBytes = 1 << 20;
  TestServer server(std::move(s));
  Bystander bystander(server);
  std::vector<std::unique_ptr<WebSocketClient>> idle;
  for (int i = 0; i < 100; i++) {
    idle.push_back(std::make_unique<WebSocketClient>(server.port()));
    idle.back()->greet("idle");
    EXPECT_NE(idle.back()->awaitControl("welcome"), "closed");
  }
  WebSocketClient stuck(server.port(), 4096);
  stuck.greet("stuck");
  EXPECT_NE(stuck.awaitControl("welcome"), "closed");
  uint32_t id = 0;
  while (stuck.request(++id, "echo " + std::string(100000, 'x')) && id < 1000) {
  }
  EXPECT_LT(id, 1000u) << "the server reads on";
  bystander.expectTheSamePicture();
  for (const auto& client : idle) {
    client->request(1, "echo here");
    EXPECT_EQ(client->readUntil([](const WireMessage& m) { return m.channel == MessageChannel::Reply; }),
              true);
  }
  const auto stat = server.client()->expect("stat");
  for (const auto& client : stat.at("clients"))
    EXPECT_LT(client.at("queued bytes"), 8 << 20) << client.at("tenant");
}

}  // namespace
}  // namespace gxy::test
