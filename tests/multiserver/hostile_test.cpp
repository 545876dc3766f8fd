// SPDX-License-Identifier: Apache-2.0
// Clients that send anything, read nothing and die at any time: nobody else notices, and nothing is left of them.
#include <gtest/gtest.h>

#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>
#include <random>
#include <thread>

#include "core/comm/error.h"
#include "tests/multiserver/bystander.h"
#include "tests/multiserver/raw_client.h"
#include "tests/multiserver/test_server.h"
#include "tests/support/swapped_link.h"

namespace gxy::test {
namespace {

using nlohmann::json;
using protocol::MessageChannel;
using protocol::WireMessage;

ServerSetup setup() {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  return setup;
}

/// How often everything is done: --times=25 for long runs.
int times(int few) { return few * argument("--times=", 1); }

// Statements near to right ones.
std::string randomStatement(std::mt19937& random) {
  static const std::vector<std::string> seeds{
      "list",
      "info ball",
      "import {\"Datasets\": [{\"name\": \"b\", \"filename\": \"ball.vol\", \"type\": \"Volume\"}]}",
      "import shared like b {\"Datasets\": {\"name\": \"c\", \"filename\": \"../x.vol\", \"type\": "
      "\"Particles\"}}",
      "drop b",
      "rename b c",
      "range b",
      "publish b writable",
      "unpublish b",
      "wait b 1 0.01",
      "observe",
      "unobserve b",
      "window 1 {\"size\": [20, 20], \"follow\": true}",
      "set 1 " + stateOf("b"),
      "render 1 {\"levels\": [4, 1]}",
      "render 1 {\"Camera\": {\"viewpoint\": [1, 2, 3]}, \"encoding\": \"jpeg\", \"passes\": 2}",
      "cancel_frame 1",
      "close 1",
      "windows",
      "state 1",
      "help",
      "modules",
      "load viewer",
      "load ../data",
      "stat",
      "cancel 3",
      "echo x",
      "batch {\"prefix\": \"../p\", \"state\": " + stateOf("b") + "}",
      "server.stat",
      "data.list",
      "viewer.list"};
  std::string text = seeds[random() % seeds.size()];
  for (int n = int(random() % 4); n > 0 && !text.empty(); n--) {
    const size_t at = random() % text.size();
    switch (random() % 5) {
      case 0:
        text[at] = char(random());
        break;
      case 1:
        text.erase(at, random() % 8);
        break;
      case 2:
        text.insert(at, text.substr(random() % text.size(), random() % 20));
        break;
      case 3:
        text.insert(at, std::to_string(int64_t(random()) * (random() % 2 ? -1 : 1000000007)));
        break;
      default:
        text.insert(at, std::string(random() % 100, "{[\"-9,e"[random() % 7]));
    }
  }
  return text;
}

TEST(Hostile, StatementsOfAllKindsAreAnsweredAndOthersSeeTheirPictures) {
  TestServer server(setup());
  Bystander bystander(server);
  for (uint32_t seed = 1; seed <= uint32_t(times(4)); seed++) {
    std::mt19937 random(seed);
    auto options = server.options("hostile");
    Client client(options);
    client.expect("load data");
    client.expect("load viewer");
    std::vector<std::future<Reply>> replies;
    std::vector<std::string> sent;
    for (int i = 0; i < 150; i++) {
      auto promise = std::make_shared<std::promise<Reply>>();
      replies.push_back(promise->get_future());
      sent.push_back(randomStatement(random));
      const uint32_t id = client.send(sent.back(), [promise](const Reply& r) { promise->set_value(r); });
      if (sent.back().find("wait") != std::string::npos) client.expect("cancel " + std::to_string(id));
    }
    bystander.expectTheSamePicture();
    for (size_t i = 0; i < replies.size(); i++)
      ASSERT_EQ(replies[i].wait_for(std::chrono::minutes(1)), std::future_status::ready)
          << seed << ": " << sent[i];
    EXPECT_TRUE(client.connected()) << seed;
  }
  bystander.expectTheSamePicture();
}

TEST(Hostile, BytesOfAllKindsEndOnlyTheirOwnConnection) {
  TestServer server(setup());
  Bystander bystander(server);
  for (uint32_t seed = 1; seed <= uint32_t(times(60)); seed++) {
    std::mt19937 random(seed);
    RawClient raw(server.port());
    if (random() % 4 == 0) {
      Bytes noise(random() % 2000);
      for (std::byte& b : noise) b = std::byte(random());
      raw.send(noise);
    } else {
      raw.greet("hostile");
      for (int i = int(random() % 6); i >= 0; i--) {
        WireMessage frame = protocol::textMessage(MessageChannel(random() % 2), uint32_t(random() % 3),
                                                  randomStatement(random));
        auto header = protocol::headerOf(frame);
        if (random() % 2) header[random() % header.size()] = std::byte(random());
        raw.send(header);
        raw.send(std::span(frame.payload)
                     .first(frame.payload.size() - (random() % 3 == 0 ? frame.payload.size() / 2 : 0)));
      }
    }
    if (random() % 2) raw.reset();
  }
  bystander.expectTheSamePicture();
  waitForClients(server, 1);
}

TEST(Hostile, ViolationsOfTheProtocolCloseTheConnection) {
  ServerSetup s = setup();
  s.server.connection.limits.requestBytes = 1000;
  TestServer server(std::move(s));
  const auto closes = [&](auto&& act) {
    RawClient raw(server.port());
    act(raw);
    return raw.closedByServer();
  };
  EXPECT_TRUE(closes([](RawClient& r) { r.send(Bytes(16)); })) << "another magic";
  EXPECT_TRUE(closes([](RawClient& r) {
    auto preamble = protocol::preamble();
    preamble[8] = std::byte(9);
    r.send(preamble);
  })) << "another version";
  EXPECT_TRUE(closes([](RawClient& r) {
    r.send(protocol::preamble());
    r.request(1, "list");
  })) << "a request before hello";
  EXPECT_TRUE(closes([](RawClient& r) {
    r.greet();
    r.request(1, std::string(1001, 'x'));
  })) << "too long";
  EXPECT_TRUE(closes([](RawClient& r) {
    r.greet();
    r.send(protocol::textMessage(MessageChannel::Pixels, 0, ""));
  })) << "on the server's channel";
  EXPECT_TRUE(closes([](RawClient& r) {
    r.greet();
    r.request(5, "load data");
    r.request(6, "wait nothing");
    r.request(6, "list");
  })) << "an id twice";
  EXPECT_TRUE(closes([](RawClient& r) {
    r.greet();
    r.send(protocol::textMessage(MessageChannel::Control, 0, "ping me"));
  })) << "a wrong ping";
  EXPECT_TRUE(closes([](RawClient& r) {
    r.greet();
    r.send(protocol::textMessage(MessageChannel::Control, 0, "ping 123456789012345678901"));
  })) << "a ping of 21 digits";
  waitForClients(server, 0);
}

TEST(Hostile, WhoSaysNothingOrNoLongerAnswersIsClosed) {
  ServerSetup s = setup();
  s.server.connection.patience = {std::chrono::milliseconds(200), std::chrono::milliseconds(100),
                                  std::chrono::milliseconds(400)};
  TestServer server(std::move(s));
  const auto alive = server.client();
  RawClient silent(server.port());
  EXPECT_TRUE(silent.closedByServer()) << "no handshake";
  RawClient halfOpen(server.port());
  halfOpen.greet();
  halfOpen.request(1, "echo once");
  EXPECT_TRUE(halfOpen.closedByServer()) << "no pong";
  EXPECT_TRUE(alive->request("echo").ok) << "whoever answers pings stays";
  EXPECT_EQ(server.server().clients(), 1u);
}

TEST(Hostile, SocketsThatSayNothingKeepNobodyOut) {
  ServerSetup s = setup();
  s.server.connection.limits.clients = 2;
  s.server.connection.patience.handshake = std::chrono::hours(1);
  TestServer server(std::move(s));
  std::vector<std::unique_ptr<RawClient>> silent;
  for (int i = 0; i < 300; i++) silent.push_back(std::make_unique<RawClient>(server.port()));
  EXPECT_TRUE(silent.front()->closedByServer()) << "the oldest makes room";
  const auto first = server.client(), second = server.client();
  EXPECT_TRUE(second->request("echo").ok);
  EXPECT_THROW(server.client(), Error) << "as many as may be have a session";
}

TEST(Hostile, WhoHasAsManyRequestsOutAsItMayIsNotTakenForDead) {
  ServerSetup s = setup();
  s.server.connection.patience.ping = std::chrono::milliseconds(100);
  s.server.connection.patience.silence = std::chrono::milliseconds(500);
  s.server.connection.limits.requests = 4;
  TestServer server(std::move(s));
  RawClient full(server.port());
  full.greet();
  full.request(1, "load data");
  for (uint32_t id = 2; id < 6; id++) full.request(id, "wait ball 1 1e6");
  auto all = std::async(std::launch::async, [&] { return full.repliesAndEnds(5, 0); });
  EXPECT_EQ(all.wait_for(std::chrono::milliseconds(1500)), std::future_status::timeout);
  const auto other = server.client();
  other->expect("load data");
  other->expect(importBall("ball"));
  EXPECT_EQ(all.get(), "");
}

TEST(Hostile, ASlowReaderOfALongFrameIsNotTakenForDead) {
  ServerSetup s = setup();
  s.server.connection.patience.ping = std::chrono::milliseconds(250);
  s.server.connection.patience.silence = std::chrono::milliseconds(2000);
  TestServer server(std::move(s));
  RawClient slow(server.port(), 16384);
  slow.greet();
  constexpr size_t kLong = 2 << 20;
  slow.request(1, "echo " + std::string(kLong, 'x'));
  std::vector<std::byte> buffer(4096);
  size_t received = 0;
  while (received < 64 << 10) {  // until the reply comes, which may take long, it is heard
    ASSERT_TRUE(slow.send(protocol::textMessage(MessageChannel::Control, 0, "ping 1")));
    received += slow.receive(buffer, 100);
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(2500);
  while (std::chrono::steady_clock::now() < end && received < kLong / 2) {
    received += slow.receive(buffer, 1000);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  while (received < kLong) {
    const size_t size = slow.receive(buffer, 10000);
    ASSERT_GT(size, 0u) << "closed after " << received << " bytes";
    received += size;
  }
}

TEST(Hostile, ASlowReaderGetsFewerPixelsAndTakesNoMoreMemory) {
  TestServer server(setup());
  Bystander bystander(server);
  RawClient slow(server.port(), 4096);
  slow.greet("slow");
  uint32_t id = 1;
  for (const std::string& statement :
       {std::string("load data"), std::string("load viewer"), importBall("ball"),
        std::string("window 1 {\"size\": [800, 600]}"), "set 1 " + stateOf("ball")})
    ASSERT_TRUE(slow.request(id++, statement));
  const auto other = server.client("slow");  // of the same tenant, to see when the data are there
  other->expect("load data");
  other->expect("wait ball 1");
  constexpr int kFrames = 12;
  for (int i = 0; i < kFrames; i++) slow.request(id++, "render 1 {\"encoding\": \"raw\", \"levels\": [1]}");
  constexpr uint64_t kPicture = 800 * 600 * 4;
  json mine;
  for (int i = 0; i < 600; i++) {  // until its last frame is done
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const json stat = server.client()->expect("stat");
    for (const json& c : stat.at("clients"))
      if (c.at("client") == "raw") mine = c;
    if (!mine.is_null() && mine.at("requests") == 0 && mine.at("queued bytes").get<uint64_t>() > kPicture / 2)
      break;
  }
  ASSERT_FALSE(mine.is_null());
  EXPECT_LT(mine.at("most queued bytes").get<uint64_t>(), 2 * kPicture + 100000);
  int64_t charged = 0;
  for (const Ledger::Line& line : server.serverRank().ledger.snapshot())
    if (line.tenant == "slow" && line.purpose == "to be sent") charged = line.bytes;
  EXPECT_GT(charged, int64_t(kPicture / 2)) << "to its tenant";
  bystander.expectTheSamePicture();
}

/// A client of tenant "slow" makes a window and asks for a raw frame of the ball, without reading anything. `id` is its next
/// request's.
bool asksForAFrame(RawClient& client, const std::string& window, uint32_t& id) {
  client.greet("slow");
  for (const std::string& statement : {std::string("load viewer"), window, "set 1 " + stateOf("ball"),
                                       std::string(R"(render 1 {"encoding": "raw", "levels": [1]})")})
    if (!client.request(id++, statement)) return false;
  return true;
}

TEST(Hostile, AWindowThatFollowsMakesFewFramesForWhoReadsNoneAndThenTheNewest) {
  ServerSetup s = setup();
  s.server.connection.outbox.text = 2000;
  TestServer server(std::move(s));
  const auto other = server.client("slow");
  other->expect("load data");
  other->expect(importBall("ball"));
  RawClient slow(server.port(), 4096);
  uint32_t id = 1;
  ASSERT_TRUE(asksForAFrame(slow, "window 1 {\"size\": [256, 256], \"follow\": true}", id));
  const auto frames = [&] {
    const json stat = other->expect("stat");
    for (const json& t : stat.at("tenants"))
      if (t.at("tenant") == "slow") return t.at("frames").get<int>();
    return 0;
  };
  while (frames() < 1) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  int generation = 1;  // a step is left out while frames show the two before
  while (generation < 60) generation += other->request(importBall("ball")).ok;
  EXPECT_LT(frames(), 30);
  json end;
  EXPECT_TRUE(slow.readUntil([&](const WireMessage& frame) {
    if (!RawClient::isEnd(frame)) return false;
    const auto data = protocol::pixelData(frame.payload);
    end = json::parse(std::string_view(reinterpret_cast<const char*>(data.data()), data.size()));
    return end.at("generations") == json{{"ball", generation}};
  }));
  EXPECT_EQ(end.at("status"), "complete");
}

// Its first picture waits to be read, and its second for that.
TEST(Hostile, AFrameThatWaitsForAWindowThatIsNotReadHoldsNoDataBackAndShowsTheNewest) {
  TestServer server(setup());
  const auto other = server.client("slow");
  other->expect("load data");
  other->expect(importBall("ball"));
  RawClient slow(server.port(), 4096);
  slow.greet("slow");
  uint32_t id = 1;
  for (const std::string& statement :
       {std::string("load viewer"), std::string("window 1 {\"size\": [1024, 1024]}"),
        "set 1 " + stateOf("ball"), std::string("render 1 {\"encoding\": \"raw\", \"levels\": [1]}"),
        std::string("render 1 {\"wait\": true, \"levels\": [4]}")})
    ASSERT_TRUE(slow.request(id++, statement));
  const auto waits = [&] {
    const json stat = other->expect("stat");
    for (const json& t : stat.at("tenants"))
      if (t.at("tenant") == "slow") return t.at("frames") == 1 && t.at("frames in flight") == 1;
    return false;
  };
  while (!waits()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  for (int update = 0; update < 3; update++) other->expect(importBall("ball"));
  json end;
  EXPECT_TRUE(slow.readUntil([&](const WireMessage& frame) {
    if (!RawClient::isEnd(frame) || protocol::pixelHeader(frame.payload).frame != 2) return false;
    const auto data = protocol::pixelData(frame.payload);
    end = json::parse(std::string_view(reinterpret_cast<const char*>(data.data()), data.size()));
    return true;
  }));
  EXPECT_EQ(end.at("status"), "complete") << end;
  EXPECT_EQ(end.at("generations"), (json{{"ball", 4}}));
}

TEST(Hostile, AFrameThatWaitsBeginsAtOnceWhereTheOneBeforeWasCancelledUnread) {
  ServerSetup s = setup();
  s.server.connection.patience.ping = std::chrono::minutes(1);
  s.server.connection.patience.silence = std::chrono::minutes(5);
  TestServer server(std::move(s));
  const auto other = server.client("slow");
  other->expect("load data");
  other->expect(importBall("ball"));
  RawClient slow(server.port(), 4096);
  uint32_t id = 1;
  ASSERT_TRUE(asksForAFrame(slow, "window 1 {\"size\": [1024, 1024]}", id));
  const auto isMade = [&] {
    const json stat = other->expect("stat");
    for (const json& t : stat.at("tenants"))
      if (t.at("tenant") == "slow") return t.at("frames") == 1;
    return false;
  };
  for (int i = 0; i < 6000 && !isMade(); i++) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ASSERT_TRUE(isMade());
  ASSERT_TRUE(slow.request(id++, "cancel_frame 1"));
  ASSERT_TRUE(slow.request(id++, "render 1 {\"wait\": true, \"levels\": [4]}"));
  json end;
  EXPECT_TRUE(slow.readUntil([&](const WireMessage& frame) {
    if (frame.channel == MessageChannel::Control && frame.text().starts_with("ping")) return true;  // in vain
    if (!RawClient::isEnd(frame) || protocol::pixelHeader(frame.payload).frame != 2) return false;
    const auto data = protocol::pixelData(frame.payload);
    end = json::parse(std::string_view(reinterpret_cast<const char*>(data.data()), data.size()));
    return true;
  }));
  EXPECT_EQ((end.is_null() ? "" : end.at("status").get<std::string>()), "complete");
}

TEST(Hostile, ABatchThatWaitsForWhoReadsNoPicturesIsCancelledNevertheless) {
  ServerSetup s = setup();
  s.server.connection.outbox.files = 1000;
  TestServer server(std::move(s));
  const auto other = server.client("slow");
  other->expect("load data");
  other->expect(importBall("ball"));
  json state = json::parse(stateOf("ball"));
  const json camera = state["Camera"];
  state.erase("Camera");
  for (int i = 0; i < 200; i++) state["Cameras"].push_back(camera);  // of 120 kB each
  RawClient slow(server.port(), 4096);
  slow.greet("slow");
  ASSERT_TRUE(slow.request(1, "load viewer"));
  ASSERT_TRUE(slow.request(2, "batch " + json{{"state", state}, {"to", "client"}, {"format", "raw"}}.dump()));
  json mine = json::object();  // until it has been admitted
  const auto look = [&] {
    const json stat = other->expect("stat");
    for (const json& c : stat.at("clients"))
      if (c.at("client") == "raw") mine = c;
    return stat.at("ranks").at(0).at("frames");
  };
  // A picture waits, and no other is rendered: the batch waits, too.
  int still = 0;
  for (int i = 0; i < 6000 && still < 3; i++) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    const bool none = look() == 0;
    still = none && mine.value("queued bytes", 0) > 100000 ? still + 1 : 0;
  }
  ASSERT_EQ(still, 3) << mine;
  EXPECT_EQ(mine.at("requests"), 1);
  ASSERT_TRUE(slow.request(3, "cancel 2"));
  for (int i = 0; i < 6000 && mine.at("requests") > 0; i++) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    look();
  }
  EXPECT_EQ(mine.at("requests"), 0) << "its client still reads nothing";
}

TEST(Hostile, WhoReadsRepliesAgainIsReadAgain) {
  ServerSetup s = setup();
  s.server.connection.outbox.text = 100000;
  TestServer server(std::move(s));
  const auto deaf = server.client("deaf"), other = server.client();
  constexpr int kRequests = 4000;  // more than all that lies between can hold
  std::promise<void> reads, all;
  const std::shared_future<void> readsAgain = reads.get_future().share();
  std::atomic<int> replies = 0;
  const auto sending = std::async(std::launch::async, [&] {
    const std::string text = "echo " + std::string(10000, 'x');
    for (int i = 0; i < kRequests; i++)
      deaf->send(text, [&](const Reply&) {
        readsAgain.wait();  // its thread, which reads
        if (++replies == kRequests) all.set_value();
      });
  });
  const auto waiting = [&] {
    const json stat = other->expect("stat");
    for (const json& c : stat.at("clients"))
      if (c.at("tenant") == "deaf") return c.at("queued bytes").get<uint64_t>();
    return uint64_t(0);
  };
  // Once there are so many, the system may take some of them, so that there are fewer again.
  uint64_t queued = 0;
  for (int i = 0; i < 6000 && (queued = waiting()) <= 100000; i++)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_GT(queued, 100000u);
  reads.set_value();
  EXPECT_EQ(all.get_future().wait_for(std::chrono::minutes(1)), std::future_status::ready)
      << replies << " replies";
  server.stop();  // so that whoever still sends ends
}

TEST(Hostile, WhoReadsNoRepliesIsReadNoMore) {
  ServerSetup s = setup();
  s.server.connection.outbox.text = 100000;
  TestServer server(std::move(s));
  Bystander bystander(server);
  RawClient deaf(server.port(), 4096);
  deaf.greet("deaf");
  const std::string text = "echo " + std::string(10000, 'x');
  uint32_t id = 1;
  int sent = 0;
  while (sent < 5000 && deaf.request(id++, text)) sent++;
  EXPECT_LT(sent, 5000) << "the server goes on reading whoever reads nothing";
  const json stat = server.client()->expect("stat");
  uint64_t most = 0;
  for (const json& c : stat.at("clients"))
    if (c.at("tenant") == "deaf") most = c.at("most queued bytes");
  EXPECT_GT(most, 100000u);
  EXPECT_LT(most, 100000u + 300 * 11000u);
  bystander.expectTheSamePicture();
}

TEST(Hostile, RequestsThatWaitTakeNoMoreMemoryThanTheyMay) {
  ServerSetup s = setup();
  constexpr uint64_t kLongest = 100000;
  s.server.connection.limits.requestBytes = kLongest;
  TestServer server(std::move(s));
  Bystander bystander(server);
  RawClient hog(server.port());
  hog.greet("hog");
  uint32_t id = 1;
  hog.request(id++, "load data");
  for (int i = 0; i <= Session::kAside; i++) hog.request(id++, "wait nothing 1 1e6");
  const std::string text = "echo " + std::string(kLongest - 5, 'x');
  while (id < 250 && hog.request(id, text)) id++;
  uint64_t received = 0;
  const json stat = server.client()->expect("stat");
  for (const json& c : stat.at("clients"))
    if (c.at("tenant") == "hog") received = c.at("received bytes");
  EXPECT_GT(received, 2 * kLongest);
  EXPECT_LT(received, 4 * kLongest);
  EXPECT_LE(server.serverRank().ledger.total("hog"), int64_t(3 * kLongest));
  bystander.expectTheSamePicture();
}

TEST(Hostile, RequestsOfATenantTakeNoMoreThanItsMemoryHoweverManyItsConnections) {
  constexpr int64_t kMost = 2'000'000;
  ServerSetup s = setup();
  s.serverRank.tenantMemory = kMost;
  TestServer server(std::move(s));
  Bystander bystander(server);
  std::deque<RawClient> hogs;
  const std::string text = "echo " + std::string(300'000, 'x');
  for (int i = 0; i < 10; i++) {
    RawClient& hog = hogs.emplace_back(server.port());
    hog.greet("hog");
    hog.request(1, "load data");
    for (uint32_t id = 2; id <= 2 + Session::kAside; id++) hog.request(id, "wait nothing 1 1e6");
    hog.request(100, text);
    // one whose payload does not come
    auto half = protocol::headerOf(protocol::textMessage(MessageChannel::Request, 101, text));
    hog.send(half);
  }
  RawClient& last = hogs.back();
  std::string refusal;
  last.request(102, "");  // within that payload
  last.send(Bytes(text.size() - protocol::kHeaderBytes, std::byte('x')));
  EXPECT_TRUE(last.readUntil([&](const WireMessage& frame) {
    if (frame.channel == MessageChannel::Reply && frame.id == 101) refusal = frame.text();
    return !refusal.empty();
  }));
  EXPECT_TRUE(refusal.starts_with("error: memory: 300005 bytes are needed")) << refusal;
  EXPECT_LE(server.serverRank().ledger.total("hog"), kMost + 10 * (Session::kAside + 3) * 4096);
  EXPECT_GT(server.serverRank().ledger.total("hog"), kMost / 2);
  EXPECT_TRUE(server.client("hog")->request("echo short").ok) << "to free memory there must be a way";
  bystander.expectTheSamePicture();
}

TEST(Hostile, CorruptAndVanishedFilesAreErrorsOfTheirImport) {
  TestServer server(setup());
  Bystander bystander(server);
  const auto client = server.client("importer");
  client->expect("load data");
  std::string whole;
  {
    std::ifstream in(server.folder() / "ball.vol");
    whole.assign(std::istreambuf_iterator<char>(in), {});
  }
  std::mt19937 random(5);
  for (int i = 0; i < times(60); i++) {
    std::string text = whole;
    for (int k = 0; k < 2; k++) text[random() % text.size()] = char(random());
    if (random() % 4 == 0) text.resize(random() % text.size());
    std::ofstream(server.folder() / "corrupt.vol") << text;
    client->request(importBall("c", "corrupt.vol"));
  }
  std::filesystem::resize_file(server.folder() / "ball.raw", 100);
  EXPECT_FALSE(client->request(importBall("short")).ok);
  std::filesystem::remove(server.folder() / "ball.raw");
  EXPECT_FALSE(client->request(importBall("gone")).ok);
  bystander.expectTheSamePicture();
}

TEST(Hostile, NothingOutsideTheDataFoldersIsImportedWhileLinksAreSwapped) {
  TestServer server(setup());
  const TemporaryFolder outside;
  writeBall(outside.path().string(), "ball", 16, 1000);
  const auto client = server.client("importer");
  client->expect("load data");
  const SwappedLink swapped(server.folder() / "ball.raw", outside / "ball.raw");
  for (int i = 0; i < times(200); i++) {
    if (!client->request(importBall("ball")).ok) continue;
    EXPECT_LT(client->expect("range ball").at("range").at(1).get<double>(), 2);
  }
}

/// While it lives, no file of this process grows beyond so many bytes: writing more fails as on a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit little{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &little);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST(Hostile, AFullDiskIsAnErrorOfWhatWritesThere) {
  TestServer server(setup());
  Bystander bystander(server);
  const auto client = server.client("writer");
  client->expect("load data");
  client->expect("load viewer");
  client->expect(importBall("ball"));
  const std::string batch = R"(batch {"prefix": "full", "format": "raw", "state": )" + stateOf("ball") + "}";
  {
    const FullDisk full(1000);
    const Reply reply = client->request(batch);
    EXPECT_FALSE(reply.ok);
    EXPECT_TRUE(reply.error.starts_with("rank ")) << reply.error;
    EXPECT_NE(reply.error.find("full_00000.raw: cannot be written"), std::string::npos) << reply.error;
    bystander.expectTheSamePicture();
  }
  for (const auto& file : std::filesystem::directory_iterator(server.folder().path()))
    EXPECT_FALSE(file.path().filename().string().starts_with("full")) << "a part of a file is left";
  client->expect(batch);
}

TEST(Hostile, ARankThatCannotTakeItsPartOfAnImportIsNamedAndNothingChanges) {
  TestServer server(setup());
  Bystander bystander(server);
  const auto client = server.client("importer");
  client->expect("load data");
  client->expect(importBall("ball"));
  {
    const LedgerEntry all =
        server.serverRank(1).ledger.enter("importer", "a test's", server.serverRank(1).options.tenantMemory);
    for (const char* name : {"ball", "other"}) {
      const Reply reply = client->request(importBall(name));
      EXPECT_FALSE(reply.ok);
      EXPECT_TRUE(reply.error.starts_with("rank 1: memory: ")) << reply.error;
    }
    bystander.expectTheSamePicture();
  }
  const json list = client->expect("list").at("datasets");
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].at("generation"), 1);
  client->expect(importBall("ball"));
  client->expect("drop ball");
  for (int rank = 0; rank < 2; rank++) EXPECT_EQ(server.serverRank(rank).ledger.total("importer"), 0) << rank;
}

}  // namespace
}  // namespace gxy::test
